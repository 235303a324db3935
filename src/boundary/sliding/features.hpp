// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include "backend/atomic.hpp"
#include "boundary/classify.hpp"
#include "boundary/sliding/reference_surface.hpp"
#include "boundary/sliding/weak_lines.hpp"
#include "math/angle.hpp"
#include "math/elementary.hpp"
#include "mesh/constrained_edges.hpp"

namespace tetune {

namespace features_detail {

/// An edge within a patch is weak where the surface turns by at most this multiple of the feature angle.
inline constexpr double kMaxWeakTurn = 4.0 / 3;
/// A vertex of a weak line is a tip where the angles around it add up to less than a full circle by more than this
/// number of degrees.
inline constexpr double kTipDefect = 30;

/// Where the surface turns.
///
/// A cap is a triangle with a vertex close to its longest edge. In scanned surfaces its normal is noise: a displacement
/// by a part of its height turns it. Where the surface seems to fold at one of its short edges, it has the normal of
/// the triangle across the longest edge instead, so that no fold is found where there is none.
struct SurfaceFolds {
  Span<const Point> points;
  Span<const SurfaceTriangle> triangles;
  Span<const int> tags;
  Span<const Index> opposite_corners;  ///< by find_across()
  ConstrainedEdges constrained;
  double cos_angle;  ///< an edge is a feature where the surface turns by more than this angle

  /// The corner across the edge opposite a corner, or kFeatureEdge where the edge is a feature because the surface
  /// turns by more than an angle, the patch ends, or the edge is constrained.
  TETUNE_HD Index across(Size corner, double cos_bound) const {
    const Index opposite = opposite_in_patch(corner);
    const bool is_feature = opposite == kFeatureEdge || is_fold(corner, smooth_normal(corner / 3), Size{opposite},
                                                                smooth_normal(Size{opposite} / 3), cos_bound);
    return is_feature ? kFeatureEdge : opposite;
  }
  /// The ends of the edge opposite a corner, in the orientation of its triangle.
  TETUNE_HD Index start(Size corner) const { return triangles[corner / 3].v[(corner + 1) % 3]; }
  TETUNE_HD Index end(Size corner) const { return triangles[corner / 3].v[(corner + 2) % 3]; }

 private:
  static constexpr double kMaxCapHeight = 0.02;        ///< over the longest edge, relative to it,
  static constexpr double kMaxCapHeightOfShort = 0.1;  ///< and to the shortest edge

  TETUNE_HD Vec3 edge(Size corner) const { return vec(points[end(corner)]) - vec(points[start(corner)]); }

  /// The corner across the edge opposite a corner, or kFeatureEdge where the patch ends or the edge is constrained.
  TETUNE_HD Index opposite_in_patch(Size corner) const {
    if (constrained.contains(start(corner), end(corner))) return kFeatureEdge;
    const Index opposite = opposite_corners[corner];
    return opposite == kFeatureEdge || tags[opposite / 3] != tags[corner / 3] ? kFeatureEdge : opposite;
  }
  /// Whether the surface folds between the triangles of two corners opposite one edge, with normals n and m.
  TETUNE_HD bool is_fold(Size corner, const Vec3& n, Size opposite, const Vec3& m, double cos_bound) const {
    const double turned = start(corner) == start(opposite) ? -1 : 1;
    // The product of the lengths, as that of their squares underflows in a small part of a large mesh.
    return turned * dot(n, m) < cos_bound * (norm(n) * norm(m));
  }
  TETUNE_HD Vec3 normal(Size triangle) const { return cross(edge(3 * triangle), edge(3 * triangle + 1)); }
  TETUNE_HD Vec3 smooth_normal(Size triangle) const {
    const Vec3 n = normal(triangle);
    Size longest = 3 * triangle;
    double length2[3];
    for (Size k = 0; k < 3; ++k) {
      const Vec3 e = edge(3 * triangle + k);
      length2[k] = dot(e, e);
      longest = length2[k] > length2[longest % 3] ? 3 * triangle + k : longest;
    }
    const double shortest2 = std::fmin(std::fmin(length2[0], length2[1]), length2[2]);
    const double longest2 = length2[longest % 3];
    const double height2 = dot(n, n) / longest2;
    const bool is_cap = height2 < kMaxCapHeight * kMaxCapHeight * longest2 &&
                        height2 < kMaxCapHeightOfShort * kMaxCapHeightOfShort * shortest2;
    if (!is_cap) return n;
    const Index beyond = opposite_in_patch(longest);
    if (beyond == kFeatureEdge || !folds_at_short_edge(triangle, longest, n)) return n;
    const Vec3 m = normal(beyond / 3);
    return start(longest) == start(Size{beyond}) ? -1.0 * m : m;
  }
  TETUNE_HD bool folds_at_short_edge(Size triangle, Size longest, const Vec3& n) const {
    for (Size corner = 3 * triangle; corner < 3 * triangle + 3; ++corner) {
      const Index opposite = corner == longest ? kFeatureEdge : opposite_in_patch(corner);
      if (opposite != kFeatureEdge && is_fold(corner, n, Size{opposite}, normal(opposite / 3), cos_angle)) return true;
    }
    return false;
  }
};

/// Keeps the corner across each edge that is no feature.
struct CutAtFeatures {
  SurfaceFolds folds;
  Span<Index> across;
  TETUNE_HD void operator()(Size corner) const { across[corner] = folds.across(corner, folds.cos_angle); }
};

/// Whether a feature edge is opposite a corner; of the two corners of an edge, the lower one.
struct IsAtFeatureEdge {
  Span<const Index> across;
  Span<const Index> opposite_corners;
  TETUNE_HD bool operator()(Size corner) const {
    const Index opposite = opposite_corners[corner];
    return across[corner] == kFeatureEdge && (opposite == kFeatureEdge || corner < opposite);
  }
};

struct ListFeatureEdge {
  SurfaceFolds folds;
  double cos_weak;
  Span<const Index> corners;
  Span<FeatureEdge> edges;
  TETUNE_HD void operator()(Size i) const {
    const Index corner = corners[i];
    const bool is_weak = folds.across(corner, cos_weak) != kFeatureEdge;
    edges[i] = {{folds.start(corner), folds.end(corner)}, corner, is_weak ? 1U : 0U};
  }
};

/// Makes the edges opposite some corners no features, and flags their ends.
struct JoinAcross {
  SurfaceFolds folds;
  Span<const Index> corners;
  Span<Index> across;
  Span<std::uint8_t> on_weak_line;
  TETUNE_HD void operator()(Size i) const {
    const Index corner = corners[i];
    const Index opposite = folds.opposite_corners[corner];
    across[corner] = opposite;
    across[opposite] = corner;
    backend::store_shared(on_weak_line[folds.start(corner)], std::uint8_t{1});
    backend::store_shared(on_weak_line[folds.end(corner)], std::uint8_t{1});
  }
};

/// At 180 degrees no edge is a feature; -2 is below any cosine, with rounding errors.
inline double cosine_of_turn(double degrees) {
  return degrees >= 180 ? -2 : elementary::cos(degrees * std::numbers::pi / 180);
}

/// Joins the triangles across the edges of weak lines, whose vertices it flags.
template <class Backend>
void join_across_weak_lines(const Backend& backend, const SurfaceFolds& folds, double feature_angle, Span<Index> across,
                            Span<std::uint8_t> on_weak_line) {
  BufferOf<Backend, Index> corners(backend, across.size());
  corners.resize(backend,
                 backend.compact(across.size(), IsAtFeatureEdge{across, folds.opposite_corners}, corners.span()));
  if (corners.size() == 0) return;
  BufferOf<Backend, FeatureEdge> edges(backend, corners.size());
  backend.for_each(corners.size(),
                   ListFeatureEdge{folds, cosine_of_turn(kMaxWeakTurn * feature_angle), corners.span(), edges.span()});
  const std::vector<Index> weak = find_weak_lines(edges.download());
  const DeviceViewOf<Backend, Index> joined(backend, weak);
  backend.for_each(std::ssize(weak), JoinAcross{folds, joined.span(), across, on_weak_line});
}

struct ClassifySlidingVertex {
  Span<const Point> points;
  Span<const SurfaceTriangle> triangles;
  Span<const Index> across;
  CsrView vertex2corner;
  Span<const Index> edges;
  CsrView vertex2edge_end;
  Span<const VertexConstraint> constraints;
  Span<const std::uint8_t> on_weak_line;
  double cos_angle;
  Span<VertexDof> dof;
  Span<LineVertex> line;

  TETUNE_HD void operator()(Size v) const {
    EdgeEnds ends;
    dof[v] = classify(v, ends);
    line[v] = dof[v] == VertexDof::curve ? LineVertex{{ends.end[0], ends.end[1]}} : LineVertex{{-1, -1}};
  }

 private:
  TETUNE_HD VertexDof classify(Size v, EdgeEnds& ends) const {
    if (constraints[v] == VertexConstraint::frozen) return VertexDof::fixed;
    const Size begin = vertex2corner.begin(v);
    const Size triangles_at_vertex = vertex2corner.size(v);
    if (triangles_at_vertex == 0 && vertex2edge_end.size(v) == 0) return VertexDof::free;

    for (Size e = vertex2edge_end.begin(v); e < vertex2edge_end.end(v); ++e) {
      ends.add(edges[Size{vertex2edge_end.items[e]} ^ 1]);
    }
    Size in_sectors = 0;
    for (Size c = begin; c < vertex2corner.end(v); ++c) {
      const std::uint32_t corner = vertex2corner.items[c];
      for (int side = 1; side <= 2; ++side) {
        if (across_edge(corner, side) != kFeatureEdge) continue;
        ends.add(other_end(corner, side));
        in_sectors += sector(corner, side, triangles_at_vertex);
      }
    }
    if (ends.count == 0) {
      // One closed fan contains all triangles; sheets that only touch at the vertex have several fans.
      const bool one_fan =
          triangles_at_vertex > 0 && sector(vertex2corner.items[begin], 1, triangles_at_vertex) == triangles_at_vertex;
      return one_fan && !(on_weak_line[v] != 0 && is_tip(v)) ? VertexDof::surface : VertexDof::fixed;
    }
    // Each sector between two features is traversed from both its ends; triangles in no sector belong to a sheet that
    // only touches at the vertex.
    if (ends.count != 2 || in_sectors != 2 * triangles_at_vertex) return VertexDof::fixed;
    const Vec3 x = vec(points[v]);
    const Vec3 d0 = vec(points[ends.end[0]]) - x;
    const Vec3 d1 = vec(points[ends.end[1]]) - x;
    return -dot(d0, d1) < cos_angle * norm(d0) * norm(d1) ? VertexDof::fixed : VertexDof::curve;
  }

  TETUNE_HD bool is_tip(Size v) const {
    double sum = 0;
    for (Size c = vertex2corner.begin(v); c < vertex2corner.end(v); ++c) {
      const std::uint32_t corner = vertex2corner.items[c];
      const Vec3 a = vec(points[other_end(corner, 1)]) - vec(points[v]);
      const Vec3 b = vec(points[other_end(corner, 2)]) - vec(points[v]);
      sum += upper_atan2(norm(cross(a, b)), dot(a, b));
    }
    return 360 - kDegreesPerRadian * sum > kTipDefect;
  }

  /// The corner across the edge from a vertex's corner to the next (side 1) or second next (side 2) vertex.
  TETUNE_HD Index across_edge(std::uint32_t corner, int side) const {
    return across[Size{corner / 3} * 3 + (corner + 3 - static_cast<std::uint32_t>(side)) % 3];
  }
  TETUNE_HD Index other_end(std::uint32_t corner, int side) const {
    return triangles[corner / 3].v[(corner + static_cast<std::uint32_t>(side)) % 3];
  }

  /// The number of triangles from this one on around the vertex, away from the edge on `side`, up to the next feature
  /// edge or back to the start; at most max_count + 1.
  TETUNE_HD Size sector(std::uint32_t corner, int side, Size max_count) const {
    const std::uint32_t start = corner;
    Size count = 0;
    do {
      ++count;
      // Leave by the other edge, and enter the next triangle by it.
      const Index through = across_edge(corner, 3 - side);
      if (through == kFeatureEdge) break;
      const Index shared = other_end(corner, 3 - side);
      const auto opposite = static_cast<std::uint32_t>(through);
      const SurfaceTriangle t = triangles[opposite / 3];
      const std::uint32_t k = opposite % 3;
      // Of the two ends of the edge opposite `through`, one is shared, the other is the vertex.
      const std::uint32_t at = t.v[(k + 1) % 3] == shared ? (k + 2) % 3 : (k + 1) % 3;
      corner = opposite / 3 * 3 + at;
      side = t.v[(at + 1) % 3] == shared ? 1 : 2;
    } while (corner != start && count <= max_count);
    return count;
  }
};

}  // namespace features_detail

/// Makes the surface the reference surface, and finds its features and where each vertex may go:
///   free     not on the surface and on no constrained edge
///   surface  on the surface, on no feature edge
///   curve    between exactly two feature edges, where the line turns by at most the feature angle
///   fixed    ends and junctions of feature lines, their sharper turns, tips on weak lines, points at which sheets of
///            the surface touch, and frozen vertices
/// Feature edges are those where the surface turns by more than `feature_angle` degrees (180: none), unless they are in
/// a weak line (find_weak_lines()), borders between tags, edges not on two triangles, and the constrained edges.
template <class Backend>
void build_reference(const Backend& backend, WorkMesh<Backend>& mesh, const ConstrainedSurface<Backend>& constrained,
                     double feature_angle, Span<VertexDof> dof, ReferenceSurface<Backend>& reference) {
  using namespace features_detail;
  const Surface<Backend>& surface = constrained.surface;
  const Span<const Index> edges = constrained.edges.ends.span();
  const Size vertices = mesh.vertices();
  const Size triangles = surface.triangles.size();
  reference.points.assign(backend, mesh.points);
  reference.triangles.assign(backend, surface.triangles);
  reference.vertex2corner.offsets.assign(backend, surface.vertex2corner.offsets);
  reference.vertex2corner.items.assign(backend, surface.vertex2corner.items);
  reference.across.resize(backend, 3 * triangles);
  const double cos_angle = cosine_of_turn(feature_angle);
  BufferOf<Backend, Index> opposite_corners(backend, 3 * triangles);
  find_across(backend, reference.triangles.span(), reference.vertex2corner.view(), opposite_corners.span());
  const SurfaceFolds folds{mesh.points,      reference.triangles,      surface.tags,
                           opposite_corners, constrained.edges.view(), cos_angle};
  backend.for_each(3 * triangles, CutAtFeatures{folds, reference.across});
  BufferOf<Backend, std::uint8_t> on_weak_line(backend, vertices);
  backend.fill(on_weak_line.span(), std::uint8_t{0});
  join_across_weak_lines(backend, folds, feature_angle, reference.across.span(), on_weak_line.span());
  Csr<Backend> vertex2edge_end;
  build_csr(backend, vertices, edges.size(), VertexOfEdgeEnd{edges}, vertex2edge_end, edges.size());
  reference.line.resize(backend, vertices);
  backend.for_each(vertices,
                   ClassifySlidingVertex{mesh.points, reference.triangles, reference.across,
                                         reference.vertex2corner.view(), edges, vertex2edge_end.view(),
                                         constrained.vertices, on_weak_line.span(), cos_angle, dof, reference.line});
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "boundary/surface.hpp"
#include "boundary/vertex_dof.hpp"
#include "mesh/constrained_edges.hpp"

namespace tetune {

/// Distances from a plane or line below this part of the local edge length count as zero. A vertex that moves in such a
/// plane changes the surface by at most about that much.
inline constexpr double kFlat = 1e-6;

/// At most this number of listed corners, or junctions of listed lines, are features whatever the geometry shows.
inline constexpr Size kFewListed = 10;

/// Whether a list can be one of features, of which `listed_only` vertices are corners or junctions by the list alone.
/// Heuristic: it is none where these are more than kFewListed and more than 5 % of the constrained vertices (TetGen
/// lists every vertex and edge of its input).
inline bool can_be_features(Size listed_only, Size constrained) {
  return listed_only <= kFewListed || 20 * listed_only <= constrained;
}

/// Returns the number of vertices that are corners or junctions of feature lines by the list alone; 0 where the list is
/// accepted (can_be_features()).
template <class IsListed>
Size count_unsupported(Span<const VertexDof> dof, const IsListed& is_listed) {
  Size constrained = 0;
  Size listed_only = 0;
  for (Size v = 0; v < dof.size(); ++v) {
    if (dof[v] != VertexDof::free) ++constrained;
    if (dof[v] != VertexDof::fixed && is_listed(v)) ++listed_only;
  }
  return can_be_features(listed_only, constrained) ? 0 : listed_only;
}

/// Whether the edges of a list from entry `first` of `ends` on can be feature lines, given where vertices may go
/// without them: feature lines meet in few places. (TetGen lists and tags all edges of its input.)
inline bool are_feature_lines(Span<const Index> ends, Size first, Span<const VertexDof> dof) {
  std::vector<Index> degrees(to_size_t(dof.size()), 0);
  const Span<Index> degree = span_of(degrees);
  for (Size i = first; i < ends.size(); ++i) ++degree[ends[i]];
  return count_unsupported(dof, [degree](Size v) { return degree[v] > 2; }) == 0;
}

/// Fixes the vertices of one constraint if their list is accepted. Returns the number of those that stay movable.
inline Size fix_listed(Span<const VertexConstraint> constraints, VertexConstraint constraint, Span<VertexDof> dof) {
  const Size unsupported = count_unsupported(dof, [=](Size v) { return constraints[v] == constraint; });
  for (Size v = 0; v < dof.size() && unsupported == 0; ++v) {
    if (constraints[v] == constraint) dof[v] = VertexDof::fixed;
  }
  return unsupported;
}

/// Fixes the listed corners if the list is accepted. Returns the number of listed vertices that stay movable.
inline Size fix_corners(Span<const VertexConstraint> constraints, Span<VertexDof> dof) {
  return fix_listed(constraints, VertexConstraint::corner, dof);
}

/// Fixes the ends and junctions of tagged lines, so that each line keeps its extent, unless they are too many for
/// lines. Returns the number of those that stay movable.
inline Size fix_line_ends(Span<const VertexConstraint> constraints, Span<VertexDof> dof) {
  return fix_listed(constraints, VertexConstraint::line_end, dof);
}

/// The other ends of edges of one kind at a vertex, each once; the first two are stored.
struct EdgeEnds {
  int count = 0;
  Index end[2] = {-1, -1};
  TETUNE_HD void add(Index q) {
    if (count > 2 || (count > 0 && end[0] == q) || (count > 1 && end[1] == q)) return;
    if (count < 2) end[count] = q;
    ++count;
  }
};

/// A surface with what constrains motion on it: the input of classify_vertices() and build_reference().
template <class Backend>
struct ConstrainedSurface {
  const Surface<Backend>& surface;
  const EdgeSet<Backend>& edges;
  Span<const VertexConstraint> vertices;
};

/// Where vertices of the surface may go.
enum class SurfaceRule : std::uint8_t { keeps_shape, fixed };

namespace classify_detail {

struct ClassifyVertex {
  Span<const Point> points;
  Span<const SurfaceTriangle> triangles;
  Span<const int> tags;
  CsrView vertex2corner;
  Span<const Index> across;  ///< per corner: the corner on the other side of its edge, or kFeatureEdge
  Span<const Index> edges;
  CsrView vertex2edge_end;
  ConstrainedEdges constrained;
  Span<const VertexConstraint> constraints;
  bool surface_fixed;
  Span<VertexDof> dof;
  Span<Vec3> axis;

  TETUNE_HD void operator()(Size v) const {
    Vec3 direction{0, 0, 0};
    dof[v] = classify(to_index(v), direction);
    axis[v] = direction;
  }

 private:
  /// The surface triangles at vertex v, which is at x: those of its corners begin .. end - 1.
  struct Fan {
    Index v;
    Vec3 x;
    Size begin, end;
  };
  /// The vectors from x to the two other vertices of a triangle, in order.
  struct Sides {
    Vec3 e1, e2;
  };
  TETUNE_HD Sides sides(const Fan& fan, Size c) const {
    const std::uint32_t corner = vertex2corner.items[c];
    const SurfaceTriangle t = triangles[corner / 3];
    const std::uint32_t k = corner % 3;
    return {vec(points[t.v[k == 2 ? 0 : k + 1]]) - fan.x, vec(points[t.v[k == 0 ? 2 : k - 1]]) - fan.x};
  }

  TETUNE_HD VertexDof classify(Index v, Vec3& direction) const {
    const Size surface_corners = vertex2corner.size(v);
    const Size edge_begin = vertex2edge_end.begin(v);
    const Size edge_end = vertex2edge_end.end(v);
    if (constraints[v] == VertexConstraint::frozen || (surface_fixed && surface_corners > 0)) return VertexDof::fixed;
    if (surface_corners == 0 && edge_begin == edge_end) return VertexDof::free;

    const Fan fan{v, vec(points[v]), vertex2corner.begin(v), vertex2corner.end(v)};
    // Feature edges whatever their angle; constrained edges come first.
    EdgeEnds features;
    for (Size e = edge_begin; e < edge_end; ++e) features.add(edges[Size{vertex2edge_end.items[e]} ^ 1]);
    EdgeEnds folds;
    for (Size c = fan.begin; c < fan.end; ++c) {
      const Index corner = to_index(vertex2corner.items[c]);
      for (Index side = 1; side <= 2; ++side) add_edge(fan, corner, side, features, folds);
      // Motion along a feature would tear folds beside it, so a vertex with both is fixed.
      if (features.count > 2 || folds.count > 2 || (features.count > 0 && folds.count > 0)) return VertexDof::fixed;
    }
    // The test for folds comes first: without it, a sheet thinner than the tolerance would count as flat at its border.
    if (features.count == 0 && folds.count == 0 && is_flat(fan, direction)) return VertexDof::plane;
    return is_straight(fan, features.count > 0 ? features : folds, direction) ? VertexDof::line : VertexDof::fixed;
  }

  /// Whether the triangles of the fan lie in one plane; `unit` receives its normal.
  TETUNE_HD bool is_flat(const Fan& fan, Vec3& unit) const {
    Vec3 normal{0, 0, 0};
    double length = 0;
    for (Size c = fan.begin; c < fan.end; ++c) {
      const auto [e1, e2] = sides(fan, c);
      Vec3 n = cross(e1, e2);
      // Interface triangles come from either side: turn all normals into one half space.
      if (dot(n, normal) < 0) n = -1.0 * n;
      normal = normal + n;
      length += 0.5 * (norm(e1) + norm(e2));
    }
    const double size = norm(normal);
    if (!(size > 0)) return false;
    length /= static_cast<double>(fan.end - fan.begin);
    for (Size c = fan.begin; c < fan.end; ++c) {
      const auto [e1, e2] = sides(fan, c);
      const double height = dot(normal, e1) / size;
      const double height2 = dot(normal, e2) / size;
      if (!(std::fabs(height) <= kFlat * length && std::fabs(height2) <= kFlat * length)) return false;
    }
    unit = (1 / size) * normal;
    return true;
  }

  /// Whether two edges form one straight line that lies in the planes of all triangles; `unit` receives its direction.
  TETUNE_HD bool is_straight(const Fan& fan, const EdgeEnds& line, Vec3& unit) const {
    if (line.count != 2) return false;
    const Vec3 d0 = vec(points[line.end[0]]) - fan.x;
    const Vec3 d1 = vec(points[line.end[1]]) - fan.x;
    if (dot(d0, d1) >= 0) return false;
    const Vec3 difference = d0 - d1;
    const Vec3 along = (1 / norm(difference)) * difference;
    if (norm(cross(d0, along)) > kFlat * norm(d0) || norm(cross(d1, along)) > kFlat * norm(d1)) return false;
    // Motion along the line leaves a triangle in its plane only if the plane contains the line.
    for (Size c = fan.begin; c < fan.end; ++c) {
      const auto [e1, e2] = sides(fan, c);
      const double longest = dot(e1, e1) > dot(e2, e2) ? dot(e1, e1) : dot(e2, e2);
      if (std::fabs(dot(cross(e1, e2), along)) > kFlat * longest) return false;
    }
    unit = along;
    return true;
  }

  /// Classifies the edge from a corner of the fan to the next (side 1) or second next (side 2) vertex of its triangle
  /// as feature, fold or neither.
  TETUNE_HD void add_edge(const Fan& fan, Index corner, Index side, EdgeEnds& features, EdgeEnds& folds) const {
    const Index triangle = corner / 3;
    const Index apex = (corner + 3 - side) % 3;
    const Index q = triangles[triangle].v[(corner + side) % 3];
    if (constrained.contains(fan.v, q)) return;  // counted already
    const Index opposite = across[3 * triangle + apex];
    if (opposite == kFeatureEdge || tags[opposite / 3] != tags[triangle]) {
      features.add(q);
      return;
    }
    if (opposite / 3 < triangle) return;  // tested already, from the other triangle
    const Vec3 e = vec(points[q]) - fan.x;
    const Vec3 p1 = vec(points[triangles[triangle].v[apex]]) - fan.x;
    const Vec3 p2 = vec(points[triangles[opposite / 3].v[opposite % 3]]) - fan.x;
    const Vec3 n1 = cross(e, p1);
    const Vec3 n2 = cross(p2, e);
    const bool first_larger = dot(n1, n1) > dot(n2, n2);
    const Vec3 n = first_larger ? n1 : n2;
    const Vec3 far = first_larger ? p2 : p1;
    // A fold: the apex of the smaller triangle is off the plane of the larger one, or the triangles overlap.
    if (std::fabs(dot(n, far)) > kFlat * norm(e) * norm(n) || dot(n1, n2) <= 0) folds.add(q);
  }
};

}  // namespace classify_detail

/// Finds for each vertex where it may go without changing the surface (Sect. 4.2, Alg. 2):
///   free   not on the surface and on no constrained edge
///   plane  V_F: its triangles lie in one plane, none folded back on another, and have one tag
///   line   V_E: the planes of all its triangles contain one line, along which its two feature edges run. Feature edges
///          are folds, borders between tags, edges not on two triangles, and the constrained edges
///   fixed  V_C: all others; the whole surface with SurfaceRule::fixed; and frozen vertices
/// `axis` receives the direction of the line or the normal of the plane.
template <class Backend>
void classify_vertices(const Backend& backend, WorkMesh<Backend>& mesh, const ConstrainedSurface<Backend>& constrained,
                       SurfaceRule rule, Span<VertexDof> dof, Span<Vec3> axis) {
  using namespace classify_detail;
  const Surface<Backend>& surface = constrained.surface;
  const bool surface_fixed = rule == SurfaceRule::fixed;
  const Span<const Index> edges = constrained.edges.ends.span();
  Csr<Backend> vertex2edge_end;
  build_csr(backend, mesh.vertices(), edges.size(), VertexOfEdgeEnd{edges}, vertex2edge_end, edges.size());
  BufferOf<Backend, Index> across(backend, 3 * surface.triangles.size());
  if (!surface_fixed) find_across(backend, surface.triangles, surface.vertex2corner.view(), across);
  backend.for_each(
      mesh.vertices(),
      ClassifyVertex{mesh.points, surface.triangles, surface.tags, surface.vertex2corner.view(), across, edges,
                     vertex2edge_end.view(), constrained.edges.view(), constrained.vertices, surface_fixed, dof, axis});
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "boundary/classify.hpp"
#include "boundary/sliding/open_fan.hpp"
#include "mesh/constrained_edges.hpp"
#include "operators/flips/boundary_flip.hpp"

/// The edges of the boundary that a flip may remove.
namespace tetune {
namespace boundary_flip_detail {

/// Finds the triangles with a flagged vertex in the mesh, or all of them where there are no flags; of one with
/// tetrahedra on both sides, the lower of the two faces.
struct FindFaces {
  MeshView mesh;
  Span<const BoundaryTriangle> triangles;
  CsrView vertex2corner;
  Span<const std::uint8_t> flags;
  Span<Index> triangle2face;
  TETUNE_HD void operator()(Size t) const {
    const FaceAdjacency links = mesh.tet2tet[t];
    if (!mesh.alive(t)) return;
    const Tet tet = mesh.tet2vertex[t];
    for (int f = 0; f < 4; ++f) {
      if (!lists_locked_face(to_index(t), links[f])) continue;
      const Index v[3] = {tet[face_vertex(f, 0)], tet[face_vertex(f, 1)], tet[face_vertex(f, 2)]};
      if (flags.size() > 0 && (flags[v[0]] | flags[v[1]] | flags[v[2]]) == 0) continue;
      const Index triangle = find_triangle(triangles, vertex2corner, v);
      if (triangle >= 0) triangle2face[triangle] = to_index(4 * t + f);
    }
  }
};

/// Edges are evaluated whose opposite angles have cotangents with a sum below this. The sum is 0 where an edge ceases
/// to be a Delaunay edge, and hardly any flip gains above (docs/benchmarks/cpu.md, "Flips of boundary edges").
inline constexpr double kMaxCotSum = 0.3;

/// An edge of the boundary and the two triangles at it, (a, b, p) and (b, a, q).
struct BoundaryEdge {
  Index a, b, p, q;
  Index triangle, other;  ///< other -1: there is none, or more than one
};

TETUNE_HD inline BoundaryEdge no_boundary_edge() { return {-1, -1, -1, -1, -1, -1}; }

struct FindEdge {
  Span<const Point> points;
  ConstrainedEdges constrained;
  Span<const BoundaryTriangle> triangles;
  CsrView vertex2corner;
  bool flips_bend;  ///< flips may bend the surface,
  BendLimit limit;  ///< within this limit
  PeriodicImagesView images;

  /// The edge opposite a corner.
  TETUNE_HD BoundaryEdge operator()(Size corner) const {
    const auto triangle = static_cast<Index>(corner / 3);
    const Size k = corner % 3;
    const BoundaryTriangle& t = triangles[triangle];
    BoundaryEdge e{t.v[(k + 1) % 3], t.v[(k + 2) % 3], t.v[k], -1, triangle, -1};
    const Index end = vertex2corner.shorter(e.a, e.b);
    for (Size c = vertex2corner.begin(end); c < vertex2corner.end(end); ++c) {
      const auto other = static_cast<Index>(vertex2corner.items[c] / 3);
      const BoundaryTriangle& u = triangles[other];
      if (other == triangle || !has_vertex(u, e.a) || !has_vertex(u, e.b)) continue;
      if (e.q >= 0) return {e.a, e.b, e.p, -1, triangle, -1};  // sheets touch along the edge
      for (int j = 0; j < 3; ++j) e.q = u.v[j] != e.a && u.v[j] != e.b ? u.v[j] : e.q;
      e.other = other;
    }
    return e;
  }

  /// The cotangent of the angle at p.
  TETUNE_HD double cot(Index a, Index b, Index p) const {
    const Vec3 pa = vec(points[a]) - vec(points[p]);
    const Vec3 pb = vec(points[b]) - vec(points[p]);
    return dot(pa, pb) / norm(cross(pa, pb));
  }
  TETUNE_HD double cot(Size corner) const {
    const BoundaryTriangle& t = triangles[corner / 3];
    const Size k = corner % 3;
    return cot(t.v[(k + 1) % 3], t.v[(k + 2) % 3], t.v[k]);
  }

  /// Whether an edge lies within a flat part of one patch, or in one sheet of a surface that may bend.
  TETUNE_HD bool is_candidate(const BoundaryEdge& e) const {
    if (e.other < 0 || constrained.contains(e.a, e.b)) return false;
    const BoundaryTriangle& t = triangles[e.triangle];
    const BoundaryTriangle& u = triangles[e.other];
    if (t.stays == kStays || t.stays != u.stays || !in_one_patch(t, u)) return false;
    const bool may_bend = flips_bend && t.stays == 0;
    if (flips_bend && !may_bend && is_feature_edge(t, e.a, e.b)) return false;
    return (may_bend || is_flat(e)) && (!adds_deviation(e) || deviation_after(e) < kInfeasible) &&
           !have_edge(triangles, vertex2corner, e.p, e.q);
  }
  /// Whether a flip adds to the deviation of its triangles. Triangles that are coplanar need not be so in the edited
  /// surface.
  TETUNE_HD bool adds_deviation(const BoundaryEdge& e) const {
    return (flips_bend || limit.is_bounded()) && triangles[e.triangle].stays == 0;
  }

  /// Whether an edge is flipped together with its periodic image.
  TETUNE_HD bool is_paired(const BoundaryEdge& e) const { return triangles[e.triangle].stays == kFlipsWithImage; }
  /// The periodic image of an edge and its two triangles, whose vertices must be in four classes. no_boundary_edge() if
  /// there is none, or more than one.
  TETUNE_HD BoundaryEdge image_of(const BoundaryEdge& e) const {
    const Index v[4] = {e.a, e.b, e.p, e.q};
    for (int i = 0; i < 4; ++i) {
      if (images.class_of(v[i]) < 0) return no_boundary_edge();
      for (int j = 0; j < i; ++j) {
        if (images.class_of(v[i]) == images.class_of(v[j])) return no_boundary_edge();
      }
    }
    const Vec3 shift = images.shift_of(e.a);
    const Index c = images.class_of(e.a);
    BoundaryEdge found = no_boundary_edge();
    for (std::uint32_t m = images.first[c]; m < images.first[c + 1]; ++m) {
      const PeriodicMember a = images.members[m];
      if (a.vertex == e.a) continue;
      const BoundaryEdge image = translated(e, a.vertex, a.shift - shift);
      if (image.other < 0) continue;
      if (found.other >= 0) return no_boundary_edge();
      found = image;
    }
    return found;
  }

  /// The deviation (BoundaryTriangle::deviation) after a flip; kInfeasible where it would be too large.
  TETUNE_HD double deviation_after(const BoundaryEdge& e) const {
    if (is_feature_edge(triangles[e.triangle], e.a, e.b)) return kInfeasible;
    return limit.largest(points, [&](Span<const Point> positions) { return deviation_after(e, positions); });
  }

 private:
  TETUNE_HD double deviation_after(const BoundaryEdge& e, Span<const Point> positions) const {
    const BoundaryTriangle& t = triangles[e.triangle];
    const BoundaryTriangle& u = triangles[e.other];
    const Vec3 a = vec(positions[e.a]);
    OpenFan before;
    before.add(e.b, e.p);
    before.add(e.q, e.b);
    OpenFan after;  // around p
    after.add(e.a, e.q);
    after.add(e.q, e.b);
    const FanComparison comparison(positions, a, before);
    const Vec3 p = vec(positions[e.p]);
    const double apexes = segment_distance(a, vec(positions[e.b]), p, vec(positions[e.q]));
    const double distance = comparison.distance(a, before, p, after, apexes);
    const double largest = t.deviation > u.deviation ? t.deviation : u.deviation;
    return limit.add(largest, distance, comparison.edge_length(before));
  }
  /// The image of an edge by the translation that maps a to `image_a`, with the orientation of its own triangle.
  TETUNE_HD BoundaryEdge translated(const BoundaryEdge& e, Index image_a, const Vec3& translation) const {
    const Index v[3] = {image_a, images.image_of(e.b, translation), images.image_of(e.p, translation)};
    const Index q = images.image_of(e.q, translation);
    if (v[1] < 0 || v[2] < 0 || q < 0) return no_boundary_edge();
    const Index triangle = find_triangle(triangles, vertex2corner, v);
    if (triangle < 0) return no_boundary_edge();
    const BoundaryTriangle& t = triangles[triangle];
    const BoundaryEdge image = (*this)(3 * Size{triangle} + (t.v[0] == v[2] ? 0 : t.v[1] == v[2] ? 1 : 2));
    return image.other >= 0 && image.q == q ? image : no_boundary_edge();
  }
  /// Whether the surface is flat across the edge and across the one that a flip would make, and not folded back.
  TETUNE_HD bool is_flat(const BoundaryEdge& e) const {
    const Vec3 a = vec(points[e.a]);
    const Vec3 ab = vec(points[e.b]) - a;
    const Vec3 ap = vec(points[e.p]) - a;
    const Vec3 aq = vec(points[e.q]) - a;
    const Vec3 n1 = cross(ab, ap);
    const Vec3 n2 = cross(aq, ab);
    if (!(dot(n1, n2) > 0)) return false;
    const double volume = std::fabs(dot(n1, aq));
    const Vec3 m1 = cross(aq, ap);
    const Vec3 m2 = n1 + n2 - m1;  // of (q, b, p)
    return volume <= kFlat * norm(ab) * larger(n1, n2) && volume <= kFlat * norm(ap - aq) * larger(m1, m2);
  }
  TETUNE_HD static double larger(const Vec3& x, const Vec3& y) {
    const double xx = dot(x, x);
    const double yy = dot(y, y);
    return std::sqrt(xx > yy ? xx : yy);
  }
};

/// Marks each edge that may be flipped with a gain, at the corner with the larger angle: most corners are decided by
/// their own angle.
struct MarkEdge {
  FindEdge find;
  Span<const std::uint8_t> changed;
  Span<std::uint8_t> marks;
  TETUNE_HD void operator()(Size corner) const { marks[corner] = is_promising(corner) ? 1 : 0; }

 private:
  /// Of an edge and its image that which has the lowest triangle stands for both.
  TETUNE_HD static bool leads(const BoundaryEdge& e, const BoundaryEdge& image) {
    return (e.triangle < e.other ? e.triangle : e.other) <
           (image.triangle < image.other ? image.triangle : image.other);
  }
  /// Whether an edge or its image has an end that is flagged; false for a paired edge that may not be flipped with its
  /// image, and for the one of the two that does not stand for both.
  TETUNE_HD bool has_changed(const BoundaryEdge& e) const {
    if (!find.is_paired(e)) return (changed[e.a] | changed[e.b]) != 0;
    const BoundaryEdge image = find.image_of(e);
    return image.other >= 0 && leads(e, image) && find.is_paired(image) && find.is_candidate(image) &&
           (changed[e.a] | changed[e.b] | changed[image.a] | changed[image.b]) != 0;
  }
  /// Whether an end of the edge opposite a corner is flagged, or the edge may have a periodic image.
  TETUNE_HD bool may_have_changed(Size corner) const {
    const BoundaryTriangle& t = find.triangles[corner / 3];
    const Size k = corner % 3;
    return t.stays == kFlipsWithImage || (changed[t.v[(k + 1) % 3]] | changed[t.v[(k + 2) % 3]]) != 0;
  }
  TETUNE_HD bool is_promising(Size corner) const {
    if (!may_have_changed(corner)) return false;
    const double cot = find.cot(corner);
    if (!(2 * cot < kMaxCotSum)) return false;
    const BoundaryEdge e = find(corner);
    if (e.other < 0 || !has_changed(e)) return false;
    const double other_cot = find.cot(e.a, e.b, e.q);
    const bool is_larger_angle = cot < other_cot || (cot == other_cot && e.triangle < e.other);
    return is_larger_angle && cot + other_cot < kMaxCotSum && find.is_candidate(e);
  }
};

struct IsMarkedCorner {
  Span<const std::uint8_t> marks;
  TETUNE_HD bool operator()(Size i) const { return marks[i] != 0; }
};

struct FillEdge {
  static constexpr Size kGrain = 32;
  FindEdge find;
  Span<const Index> corners;
  Span<BoundaryEdge> edges;
  Span<BoundaryEdge> images;  ///< empty where no edge is paired
  TETUNE_HD void operator()(Size i) const {
    edges[i] = find(corners[i]);
    if (images.size() > 0) images[i] = find.is_paired(edges[i]) ? find.image_of(edges[i]) : no_boundary_edge();
  }
};

}  // namespace boundary_flip_detail
}  // namespace tetune

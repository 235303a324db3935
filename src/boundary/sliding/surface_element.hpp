// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/sliding/reference_surface.hpp"

/// The triangles and edges of the reference surface as the sets on which a vertex moves, and the steepest descent among
/// them (Alg. 3).
namespace tetune {

/// A tangent vector of a surface element, in the coordinates of its frame.
struct TangentVector {
  double u = 0, v = 0;
};
TETUNE_HD inline TangentVector operator*(double s, const TangentVector& w) { return {s * w.u, s * w.v}; }
TETUNE_HD inline double dot(const TangentVector& a, const TangentVector& b) { return a.u * b.u + a.v * b.v; }

/// An orthogonal frame of a triangle or edge of the reference surface, not normalized: corner 0 is at `origin`, corner
/// 1 at origin + u, and corner 2 of a triangle at origin + shear u + v.
struct Frame {
  Vec3 origin{}, u{}, v{}, edge2{};
  double u2 = 0, v2 = 0;
  double inverse_u2 = 0, inverse_v2 = 0;
  double shear = 0;

  Frame() = default;
  /// The frame of edge (a, b).
  TETUNE_HD Frame(const Vec3& a, const Vec3& b) : origin(a), u(b - a), u2(dot(u, u)), inverse_u2(1 / u2) {}
  /// The frame of a triangle; v2 > 0 does not hold where it is degenerate.
  TETUNE_HD Frame(const Vec3& p0, const Vec3& p1, const Vec3& p2) : Frame(p0, p1) {
    edge2 = p2 - p0;
    shear = inverse_u2 * dot(u, edge2);
    v = edge2 - shear * u;
    v2 = dot(v, v);
    inverse_v2 = 1 / v2;
  }

  TETUNE_HD Vec3 in_space(const TangentVector& w) const { return w.u * u + w.v * v; }
  TETUNE_HD double length(const TangentVector& w) const { return std::sqrt(w.u * w.u * u2 + w.v * w.v * v2); }
  /// The derivatives of a triangle's barycentric coordinates along w.
  TETUNE_HD Vec3 rates(const TangentVector& w) const {
    const double rate1 = w.u - shear * w.v;
    return {-rate1 - w.v, rate1, w.v};
  }
  /// Whether the barycentric coordinates of the corners whose bits are set in `corners` increase along w.
  TETUNE_HD bool increases(unsigned corners, const TangentVector& w) const {
    const Vec3 rate = rates(w);
    return ((corners & 1U) == 0 || rate.x > 0) && ((corners & 2U) == 0 || rate.y > 0) &&
           ((corners & 4U) == 0 || rate.z > 0);
  }
  /// The barycentric coordinates of a point of a triangle.
  TETUNE_HD Vec3 coordinates(const Vec3& y) const {
    const Vec3 d = y - origin;
    const double l2 = inverse_v2 * dot(v, d);
    const double l1 = inverse_u2 * dot(u, d) - shear * l2;
    return {1 - l1 - l2, l1, l2};
  }
  /// The point with given barycentric coordinates.
  TETUNE_HD Vec3 at(const Vec3& l) const { return origin + l.y * u + l.z * edge2; }
};

struct EdgeVertices {
  Index a, b;
};
TETUNE_HD inline EdgeVertices edge_vertices(const ReferenceView& ref, const SurfacePoint& edge) {
  if (edge.kind == SurfacePointKind::segment) return {edge.item / 2, ref.line[edge.item / 2].next[edge.item % 2]};
  const SurfaceTriangle t = ref.triangles[edge.item / 3];
  return {t.v[(edge.item + 1) % 3], t.v[(edge.item + 2) % 3]};
}

TETUNE_HD inline Frame frame_of(const ReferenceView& ref, const SurfacePoint& on) {
  if (on.kind == SurfacePointKind::triangle) {
    const SurfaceTriangle t = ref.triangles[on.item];
    return {ref.point(t.v[0]), ref.point(t.v[1]), ref.point(t.v[2])};
  }
  const EdgeVertices e = edge_vertices(ref, on);
  return {ref.point(e.a), ref.point(e.b)};
}

/// A triangle, edge or segment of the reference surface along which a vertex may move, and the gradient on it.
struct SurfaceElement {
  SurfacePoint on;  ///< kind none: there is no direction of descent
  Frame frame;
  TangentVector negative_gradient;  ///< the negative derivatives along u and v
  TangentVector descent;  ///< the direction of steepest descent, as long as the negative directional derivative
  double descent2 = 0;    ///< its squared length

  SurfaceElement() = default;
  TETUNE_HD SurfaceElement(const ReferenceView& ref, const SurfacePoint& element, const Vec3& g)
      : on(element),
        frame(frame_of(ref, element)),
        negative_gradient{-dot(g, frame.u), -dot(g, frame.v)},
        descent{negative_gradient.u * frame.inverse_u2, negative_gradient.v * frame.inverse_v2},
        descent2(dot(negative_gradient, descent)) {}
  TETUNE_HD void reject() {
    on = {};
    descent2 = 0;
  }
};

/// The corners of a reference triangle whose barycentric coordinates must increase for a direction to lead from a point
/// of its boundary into it, as bits.
TETUNE_HD inline unsigned entered_from(const ReferenceView& ref, const SurfacePoint& from, Index triangle) {
  if (from.kind == SurfacePointKind::edge) {
    const Index corner = from.item / 3 == triangle ? from.item : ref.across[from.item];
    return 1U << corner % 3;
  }
  if (from.kind != SurfacePointKind::vertex) return 0;
  const SurfaceTriangle t = ref.triangles[triangle];
  return t.v[0] == from.item ? 6U : t.v[1] == from.item ? 5U : 3U;
}

namespace surface_element_detail {

/// A triangle, rejected unless the descent increases the coordinates of the corners in `corners`.
TETUNE_HD inline SurfaceElement in_triangle(const ReferenceView& ref, Index triangle, unsigned corners, const Vec3& g) {
  SurfaceElement e(ref, {SurfacePointKind::triangle, triangle}, g);
  if (!(e.frame.v2 > 0) || !(e.descent2 > 0) || !e.frame.increases(corners, e.descent)) e.reject();
  return e;
}

/// An edge or segment; with `from` >= 0 rejected unless the descent leads away from that end.
TETUNE_HD inline SurfaceElement on_edge(const ReferenceView& ref, const SurfacePoint& edge, Index from, const Vec3& g) {
  SurfaceElement e(ref, edge, g);
  const bool leads_away = from < 0 || (from == edge_vertices(ref, edge).a ? e.descent.u : -e.descent.u) > 0;
  if (!leads_away || !(e.descent2 > 0)) e.reject();
  return e;
}

/// The steepest element at a point of an edge: one of its triangles, or the edge where neither has a descent.
TETUNE_HD inline SurfaceElement steepest_at_edge(const ReferenceView& ref, const SurfacePoint& edge, const Vec3& g) {
  SurfaceElement best = in_triangle(ref, edge.item / 3, 1U << edge.item % 3, g);
  const Index opposite = ref.across[edge.item];
  if (opposite != kFeatureEdge) {
    const SurfaceElement other = in_triangle(ref, opposite / 3, 1U << opposite % 3, g);
    if (other.descent2 > best.descent2) best = other;
  }
  if (best.on.kind == SurfacePointKind::none) best = on_edge(ref, edge, -1, g);
  return best;
}

/// The steepest element at a vertex, from the dot products of the edges alone: a descent leads into a triangle when
/// both coordinates of its projection increase.
TETUNE_HD inline SurfaceElement steepest_at_vertex(const ReferenceView& ref, Index vertex, const Vec3& g) {
  const Vec3 o = ref.point(vertex);
  Index best_triangle = -1;
  Index best_edge = -1;
  double edge2 = 0;
  double triangle2 = 0;
  for (Size i = ref.vertex2corner.begin(vertex); i < ref.vertex2corner.end(vertex); ++i) {
    const Index corner = to_index(ref.vertex2corner.items[i]);
    const Index triangle = corner / 3;
    const Index next = 3 * triangle + (corner + 1) % 3;
    const Index after = 3 * triangle + (corner + 2) % 3;
    const SurfaceTriangle t = ref.triangles[triangle];
    const Vec3 a = ref.point(t.v[next - 3 * triangle]) - o;
    const Vec3 b = ref.point(t.v[after - 3 * triangle]) - o;
    const double aa = dot(a, a);
    const double bb = dot(b, b);
    const double along_a = -dot(g, a);
    const double along_b = -dot(g, b);
    // The edge to a corner is the edge of the third corner.
    if (along_a > 0 && along_a * along_a > edge2 * aa) {
      edge2 = along_a * along_a / aa;
      best_edge = after;
    }
    if (along_b > 0 && along_b * along_b > edge2 * bb) {
      edge2 = along_b * along_b / bb;
      best_edge = next;
    }
    const double ab = dot(a, b);
    const double u = along_a * bb - along_b * ab;
    const double v = along_b * aa - along_a * ab;
    if (!(u > 0) || !(v > 0)) continue;
    const double descent2 = u * along_a + v * along_b;
    const double area2 = aa * bb - ab * ab;
    if (!(area2 > 0) || !(descent2 > triangle2 * area2)) continue;
    triangle2 = descent2 / area2;
    best_triangle = triangle;
  }
  if (triangle2 >= edge2 && best_triangle >= 0) {
    const SurfaceElement e = in_triangle(ref, best_triangle, 0, g);
    if (e.on.kind != SurfacePointKind::none) return e;
  }
  return best_edge >= 0 ? on_edge(ref, {SurfacePointKind::edge, best_edge}, vertex, g) : SurfaceElement{};
}

}  // namespace surface_element_detail

/// The element at a surface point with the steepest descent against the gradient `g`, among those that the descent
/// leads into (Alg. 3). The derivative along an edge is never larger than that in its triangles, but the descent of
/// these may lead out of them, as over the bottom of a valley; on an edge it counts when neither triangle has a
/// descent. At a vertex all elements are compared, as a valley may be steeper than a triangle elsewhere.
TETUNE_HD TETUNE_OUTLINE inline SurfaceElement steepest(const ReferenceView& ref, VertexDof dof,
                                                        const SurfacePoint& point, const Vec3& g) {
  namespace detail = surface_element_detail;
  switch (point.kind) {
    case SurfacePointKind::triangle:
      return detail::in_triangle(ref, point.item, 0, g);
    case SurfacePointKind::segment:
      return detail::on_edge(ref, point, -1, g);
    case SurfacePointKind::edge:
      return detail::steepest_at_edge(ref, point, g);
    case SurfacePointKind::vertex: {
      if (dof != VertexDof::curve) return detail::steepest_at_vertex(ref, point.item, g);
      const SurfaceElement first = detail::on_edge(ref, {SurfacePointKind::segment, 2 * point.item}, point.item, g);
      const SurfaceElement second =
          detail::on_edge(ref, {SurfacePointKind::segment, 2 * point.item + 1}, point.item, g);
      return second.descent2 > first.descent2 ? second : first;
    }
    default:
      return {};
  }
}

}  // namespace tetune

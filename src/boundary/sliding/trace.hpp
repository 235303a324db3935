// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/sliding/surface_element.hpp"

/// Tracing of straight steps within elements of the reference surface (Alg. 4).
namespace tetune {

/// Barycentric coordinates below this count as zero (Alg. 4).
inline constexpr double kSnap = 1e-9;
/// The part of the way to a feature after which a vertex stops that must not step on it.
inline constexpr double kStandoff = 0.99;

/// A place on the reference surface, and where the vertex that is there may go.
struct SurfacePlace {
  Vec3 position;
  SurfacePoint surface_point;
  VertexDof dof;
};

/// The end of a step along a surface element.
struct TraceResult {
  Vec3 position;
  SurfacePoint surface_point;
  double t;          ///< the length of the step, in step vectors
  bool at_boundary;  ///< the end is on an edge or vertex of the element that the vertex may cross
};

namespace trace_detail {

TETUNE_HD inline TraceResult advance_on_edge(const ReferenceView& ref, VertexDof dof, const SurfaceElement& element,
                                             const Vec3& y, double rate, double t) {
  const Frame& frame = element.frame;
  double s = frame.inverse_u2 * dot(frame.u, y - frame.origin);
  s = s < 0 ? 0 : s > 1 ? 1 : s;
  const double t_end = rate > 0 ? (1 - s) / rate : -s / rate;
  if (!(t >= t_end)) return {frame.origin + (s + t * rate) * frame.u, element.on, t, false};
  const EdgeVertices e = edge_vertices(ref, element.on);
  const Index end = rate > 0 ? e.b : e.a;
  if (ref.dof[end] == dof) return {ref.point(end), {SurfacePointKind::vertex, end}, t_end, true};
  const double t_stop = kStandoff * t_end;
  return {frame.origin + (s + t_stop * rate) * frame.u, element.on, t_stop, false};
}

/// Moves to the boundary of a triangle at most, from given barycentric coordinates that change at given rates.
TETUNE_HD TETUNE_OUTLINE inline TraceResult advance_to_boundary(const ReferenceView& ref, VertexDof dof,
                                                                const SurfaceElement& element, const Vec3& from,
                                                                const Vec3& rates, double t) {
  const Index triangle = element.on.item;
  const double l[3] = {from.x, from.y, from.z};
  const double rate[3] = {rates.x, rates.y, rates.z};
  int first = -1;
  double t_end = 0;
  for (int k = 0; k < 3; ++k) {
    if (!(rate[k] < 0) || (first >= 0 && l[k] >= -rate[k] * t_end)) continue;
    first = k;
    t_end = l[k] / -rate[k];
  }
  if (first < 0 || !(t >= t_end)) return {element.frame.at(from + t * rates), element.on, t, false};
  const int next = (first + 1) % 3;
  const int after = (first + 2) % 3;
  const double l_next = l[next] + t_end * rate[next];
  const double l_after = l[after] + t_end * rate[after];
  const double t_stop = kStandoff * t_end;
  const TraceResult before_feature{element.frame.at(from + t_stop * rates), element.on, t_stop, false};
  if (l_next <= kSnap || l_after <= kSnap) {
    const Index end = ref.triangles[triangle].v[l_next > l_after ? next : after];
    if (ref.dof[end] != dof) return before_feature;
    return {ref.point(end), {SurfacePointKind::vertex, end}, t_end, true};
  }
  const SurfacePoint edge{SurfacePointKind::edge, 3 * triangle + first};
  if (ref.across[edge.item] == kFeatureEdge) return before_feature;
  const EdgeVertices e = edge_vertices(ref, edge);
  return {ref.point(e.a) + l_after * (ref.point(e.b) - ref.point(e.a)), edge, t_end, true};
}

/// The barycentric coordinates of a point on the boundary of a triangle, with exact zeros where they are zero.
TETUNE_HD inline Vec3 on_boundary(const ReferenceView& ref, Index triangle, const SurfacePoint& point, const Vec3& l) {
  const SurfaceTriangle t = ref.triangles[triangle];
  if (point.kind == SurfacePointKind::vertex) {
    return {t.v[0] == point.item ? 1.0 : 0.0, t.v[1] == point.item ? 1.0 : 0.0, t.v[2] == point.item ? 1.0 : 0.0};
  }
  const Index corner = (point.item / 3 == triangle ? point.item : ref.across[point.item]) % 3;
  return {corner == 0 ? 0 : l.x, corner == 1 ? 0 : l.y, corner == 2 ? 0 : l.z};
}

}  // namespace trace_detail

/// Moves by t p along a surface element, at most to its boundary, and identifies the surface point there (Alg. 4). The
/// position is computed from coordinates on the element, so that rounding errors do not add up over many steps.
TETUNE_HD TETUNE_OUTLINE inline TraceResult advance(const ReferenceView& ref, const SurfacePlace& from,
                                                    const SurfaceElement& element, const TangentVector& p, double t) {
  const Frame& frame = element.frame;
  if (element.on.kind != SurfacePointKind::triangle) {
    return trace_detail::advance_on_edge(ref, from.dof, element, from.position, p.u, t);
  }
  Vec3 l = frame.coordinates(from.position);
  l = {l.x < 0 ? 0 : l.x, l.y < 0 ? 0 : l.y, l.z < 0 ? 0 : l.z};
  if (from.surface_point.kind != SurfacePointKind::triangle) {
    l = trace_detail::on_boundary(ref, element.on.item, from.surface_point, l);
  }
  const Vec3 rates = frame.rates(p);
  // Most steps end inside the element: these take no division.
  const Vec3 end = l + t * rates;
  if (end.x > kSnap && end.y > kSnap && end.z > kSnap) return {frame.at(end), element.on, t, false};
  return trace_detail::advance_to_boundary(ref, from.dof, element, l, rates, t);
}

/// The end of a step from x, at surface point `on`: its projection onto the element that it descends into, at most to
/// the boundary of that element; x itself where there is none.
TETUNE_HD TETUNE_OUTLINE inline TraceResult project_step(const ReferenceView& ref, VertexDof dof,
                                                         const SurfacePoint& on, const Vec3& x, const Vec3& step) {
  const SurfaceElement element = steepest(ref, dof, on, -1.0 * step);
  if (element.on.kind == SurfacePointKind::none) return {x, on, 0, false};
  return advance(ref, {x, on, dof}, element, element.descent, 1);
}

/// Moves over the surface, from `from` at surface point `on`, while that leads closer to a target, over at most
/// `max_elements` of its elements; returns the end and its surface point.
TETUNE_HD inline Vec3 project_on_reference(const ReferenceView& ref, VertexDof dof, const Vec3& from,
                                           const Vec3& target, SurfacePoint& on, int max_elements = 32) {
  Vec3 x = from;
  for (int step = 0; step < max_elements; ++step) {
    const TraceResult end = project_step(ref, dof, on, x, target - x);
    x = end.position;
    on = end.surface_point;
    if (!end.at_boundary) break;
  }
  return x;
}

}  // namespace tetune

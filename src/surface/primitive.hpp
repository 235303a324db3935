// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "surface/reference.hpp"

namespace tetune {

/// A triangle, edge or segment of the reference surface that a vertex may move along from where it is.
struct Primitive {
  Site on;                ///< kind none: there is no way down
  Vec3 down{};            ///< steepest descent within it: minus the directional derivative
  double down2 = 0;       ///< its square
  TriangleFrame frame{};  ///< of a triangle
};

/// Barycentric coordinates below this count as zero (Alg. 4).
inline constexpr double kSnap = 1e-9;
/// How far towards a feature a vertex gets that must not step on it.
inline constexpr double kShort = 0.99;

struct Ends {
  Index a, b;
};
TETUNE_HD inline Ends ends_of(const ReferenceView& ref, const Site& site) {
  if (site.kind == SiteKind::segment) return {site.item / 2, ref.line[site.item / 2].next[site.item % 2]};
  const SurfaceTriangle t = ref.triangles[site.item / 3];
  return {t.v[(site.item + 1) % 3], t.v[(site.item + 2) % 3]};
}

/// The corners of a reference triangle that must rise for a direction to lead from a site into it, as bits.
TETUNE_HD inline unsigned entered_from(const ReferenceView& ref, const Site& site, Index triangle) {
  if (site.kind == SiteKind::edge) {
    const Index corner = site.item / 3 == triangle ? site.item : ref.across[site.item];
    return 1U << corner % 3;
  }
  if (site.kind != SiteKind::vertex) return 0;
  const SurfaceTriangle t = ref.triangles[triangle];
  return t.v[0] == site.item ? 6U : t.v[1] == site.item ? 5U : 3U;
}

namespace primitive_detail {

struct Best {
  Primitive& primitive;

  /// Takes a triangle if its derivative is the largest so far and leads into it: the coordinates of the corners with a
  /// bit in `enters` must rise.
  TETUNE_HD void triangle(const ReferenceView& ref, Index triangle, unsigned enters, const Vec3& g) {
    const TriangleFrame frame(ref, triangle);
    if (!frame.leads_inside(enters, -1.0 * g)) return;
    const double n2 = dot(frame.normal, frame.normal);
    if (!(n2 > 0)) return;
    const Vec3 down = (dot(g, frame.normal) / n2) * frame.normal - g;
    const double d2 = dot(down, down);
    if (!(d2 > primitive.down2)) return;
    primitive = {{SiteKind::triangle, triangle}, down, d2, frame};
  }

  /// The same for an edge or segment; `from` -1: either way, else away from that end only.
  TETUNE_HD void edge(const ReferenceView& ref, const Site& site, Index from, const Vec3& g) {
    const Ends e = ends_of(ref, site);
    const Vec3 ab = ref.point(e.b) - ref.point(e.a);
    const double length = norm(ab);
    if (!(length > 0)) return;
    const Vec3 unit = (1 / length) * ab;
    const double slope = -dot(g, unit);
    if (from >= 0 && !((from == e.a ? slope : -slope) > 0)) return;
    if (!(slope * slope > primitive.down2)) return;
    primitive = {site, slope * unit, slope * slope};
  }

  /// The triangles and edges at a vertex, from the dot products of their edges alone: a descent leads into a triangle
  /// when both coordinates of its projection rise.
  TETUNE_HD void around(const ReferenceView& ref, Index vertex, const Vec3& g) {
    const Vec3 o = ref.point(vertex);
    Index in_triangle = -1;
    Index on_edge = -1;
    double edge2 = 0;
    double triangle2 = 0;
    for (Size i = ref.vertex2corner.begin(vertex); i < ref.vertex2corner.end(vertex); ++i) {
      const auto corner = static_cast<Index>(ref.vertex2corner.items[i]);
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
      // An edge is the one opposite the corner at which neither of its ends is.
      if (along_a > 0 && along_a * along_a > edge2 * aa) {
        edge2 = along_a * along_a / aa;
        on_edge = after;
      }
      if (along_b > 0 && along_b * along_b > edge2 * bb) {
        edge2 = along_b * along_b / bb;
        on_edge = next;
      }
      const double ab = dot(a, b);
      const double u = along_a * bb - along_b * ab;
      const double v = along_b * aa - along_a * ab;
      if (!(u > 0) || !(v > 0)) continue;
      const double down2 = u * along_a + v * along_b;
      const double area2 = aa * bb - ab * ab;
      if (!(area2 > 0) || !(down2 > triangle2 * area2)) continue;
      triangle2 = down2 / area2;
      in_triangle = triangle;
    }
    if (triangle2 >= edge2 && in_triangle >= 0) triangle(ref, in_triangle, 0, g);
    if (primitive.on.kind == SiteKind::none && on_edge >= 0) edge(ref, {SiteKind::edge, on_edge}, vertex, g);
  }
};

}  // namespace primitive_detail

/// The primitive at a site with the steepest descent against the gradient `g`, among those that it leads into (Alg. 3).
/// An edge's derivative is never larger than that of its triangles, but the descent of those may lead out of them: over
/// the edge of a valley. On an edge it is asked when neither triangle has a way down. At a vertex all are asked, as a
/// valley may fall more steeply than a triangle elsewhere.
TETUNE_HD inline Primitive steepest(const ReferenceView& ref, Mobility walker, const Site& site, const Vec3& g) {
  Primitive steepest;
  primitive_detail::Best best{steepest};
  switch (site.kind) {
    case SiteKind::triangle:
      best.triangle(ref, site.item, 0, g);
      break;
    case SiteKind::segment:
      best.edge(ref, site, -1, g);
      break;
    case SiteKind::edge: {
      const Index other = ref.across[site.item];
      best.triangle(ref, site.item / 3, 1U << site.item % 3, g);
      if (other != kWall) best.triangle(ref, other / 3, 1U << other % 3, g);
      if (steepest.on.kind == SiteKind::none) best.edge(ref, site, -1, g);
      break;
    }
    case SiteKind::vertex:
      if (walker == Mobility::curve) {
        for (Index way = 0; way < 2; ++way) best.edge(ref, {SiteKind::segment, 2 * site.item + way}, site.item, g);
        break;
      }
      best.around(ref, site.item, g);
      break;
    case SiteKind::none:
      break;
  }
  return steepest;
}

/// Where a move along a primitive ends.
struct Landing {
  Vec3 at;
  Site site;
  double t;     ///< of the move that was made
  bool at_rim;  ///< on an edge or vertex that the vertex may cross
};

/// Moves from y at `site` by t p along a primitive, no farther than its rim, and identifies the site there (Alg. 4).
/// The position is built from coordinates on the primitive, so that rounding does not add up over many moves.
TETUNE_HD inline Landing advance(const ReferenceView& ref, Mobility walker, const Primitive& primitive,
                                 const Site& site, const Vec3& y, const Vec3& p, double t) {
  if (primitive.on.kind != SiteKind::triangle) {
    const Ends e = ends_of(ref, primitive.on);
    const Vec3 a = ref.point(e.a);
    const Vec3 ab = ref.point(e.b) - a;
    const double length2 = dot(ab, ab);
    const double rate = dot(p, ab) / length2;
    double s = dot(y - a, ab) / length2;
    s = s < 0 ? 0 : s > 1 ? 1 : s;
    const double rim = rate > 0 ? (1 - s) / rate : -s / rate;
    if (!(t >= rim)) return {a + (s + t * rate) * ab, primitive.on, t, false};
    const Index end = rate > 0 ? e.b : e.a;
    if (ref.kind[end] == walker) return {ref.point(end), {SiteKind::vertex, end}, rim, true};
    return {a + (s + kShort * rim * rate) * ab, primitive.on, kShort * rim, false};
  }

  const Index triangle = primitive.on.item;
  const TriangleFrame& b = primitive.frame;
  const double inverse_n2 = 1 / dot(b.normal, b.normal);
  const Vec3 from = y - b.p[0];
  const Vec3 slope1 = inverse_n2 * b.inward(1);
  const Vec3 slope2 = inverse_n2 * b.inward(2);
  double l[3] = {0, dot(slope1, from), dot(slope2, from)};
  double rate[3] = {0, dot(slope1, p), dot(slope2, p)};
  l[0] = 1 - l[1] - l[2];
  rate[0] = -rate[1] - rate[2];
  for (double& coordinate : l) coordinate = coordinate < 0 ? 0 : coordinate;
  if (site.kind == SiteKind::edge) {
    const Index corner = site.item / 3 == triangle ? site.item : ref.across[site.item];
    l[corner % 3] = 0;
  } else if (site.kind == SiteKind::vertex) {
    for (int k = 0; k < 3; ++k) l[k] = ref.triangles[triangle].v[k] == site.item ? 1 : 0;
  }
  int first = -1;
  double rim = 0;
  for (int k = 0; k < 3; ++k) {
    if (!(rate[k] < 0) || (first >= 0 && l[k] >= -rate[k] * rim)) continue;
    first = k;
    rim = l[k] / -rate[k];
  }
  const auto place = [&](double s) {
    return b.p[0] + (l[1] + s * rate[1]) * (b.p[1] - b.p[0]) + (l[2] + s * rate[2]) * (b.p[2] - b.p[0]);
  };
  if (first < 0 || !(t >= rim)) return {place(t), primitive.on, t, false};
  const int next = (first + 1) % 3;
  const int after = (first + 2) % 3;
  const double l_next = l[next] + rim * rate[next];
  const double l_after = l[after] + rim * rate[after];
  const Landing stopped_short{place(kShort * rim), primitive.on, kShort * rim, false};
  if (l_next <= kSnap || l_after <= kSnap) {
    const Index end = ref.triangles[triangle].v[l_next > l_after ? next : after];
    if (ref.kind[end] != walker) return stopped_short;
    return {ref.point(end), {SiteKind::vertex, end}, rim, true};
  }
  const Index corner = 3 * triangle + first;
  if (ref.across[corner] == kWall) return stopped_short;
  return {b.p[next] + l_after * (b.p[after] - b.p[next]), {SiteKind::edge, corner}, rim, true};
}

}  // namespace tetune

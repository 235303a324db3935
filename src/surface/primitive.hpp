// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "surface/reference.hpp"

namespace tetune {

/// A direction within a primitive, in the coordinates of its frame.
struct Way {
  double along = 0, aside = 0;
};
TETUNE_HD inline Way operator*(double s, const Way& w) { return {s * w.along, s * w.aside}; }
TETUNE_HD inline double dot(const Way& v, const Way& w) { return v.along * w.along + v.aside * w.aside; }

/// A triangle or edge of the reference in orthogonal coordinates: corner 0 is at `origin`, corner 1 is `along` from it;
/// corner 2 of a triangle is shear * along + aside from it.
struct Frame {
  Vec3 origin{}, along{}, aside{}, edge2{};
  double along2 = 0, aside2 = 0;
  double inverse_along2 = 0, inverse_aside2 = 0;
  double shear = 0;

  Frame() = default;
  /// Of the edge a b.
  TETUNE_HD Frame(const Vec3& a, const Vec3& b)
      : origin(a), along(b - a), along2(dot(along, along)), inverse_along2(1 / along2) {}
  /// Of a triangle; where that is degenerate, aside2 > 0 does not hold.
  TETUNE_HD Frame(const Vec3& p0, const Vec3& p1, const Vec3& p2) : Frame(p0, p1) {
    edge2 = p2 - p0;
    shear = inverse_along2 * dot(along, edge2);
    aside = edge2 - shear * along;
    aside2 = dot(aside, aside);
    inverse_aside2 = 1 / aside2;
  }

  TETUNE_HD Vec3 in_space(const Way& w) const { return w.along * along + w.aside * aside; }
  TETUNE_HD double length(const Way& w) const {
    return std::sqrt(w.along * w.along * along2 + w.aside * w.aside * aside2);
  }
  /// How fast the affine coordinates of a triangle's corners rise.
  TETUNE_HD Vec3 rates(const Way& w) const {
    const double rate1 = w.along - shear * w.aside;
    return {-rate1 - w.aside, rate1, w.aside};
  }
  /// Whether those of the corners with a bit in `enters` rise.
  TETUNE_HD bool leads_inside(unsigned enters, const Way& w) const {
    const Vec3 rate = rates(w);
    return ((enters & 1U) == 0 || rate.x > 0) && ((enters & 2U) == 0 || rate.y > 0) &&
           ((enters & 4U) == 0 || rate.z > 0);
  }
  /// The affine coordinates of a point of a triangle, and the point of such.
  TETUNE_HD Vec3 coordinates(const Vec3& y) const {
    const Vec3 from = y - origin;
    const double l2 = inverse_aside2 * dot(aside, from);
    const double l1 = inverse_along2 * dot(along, from) - shear * l2;
    return {1 - l1 - l2, l1, l2};
  }
  TETUNE_HD Vec3 at(const Vec3& l) const { return origin + l.y * along + l.z * edge2; }
};

struct Ends {
  Index a, b;
};
TETUNE_HD inline Ends ends_of(const ReferenceView& ref, const Site& site) {
  if (site.kind == SiteKind::segment) return {site.item / 2, ref.line[site.item / 2].next[site.item % 2]};
  const SurfaceTriangle t = ref.triangles[site.item / 3];
  return {t.v[(site.item + 1) % 3], t.v[(site.item + 2) % 3]};
}

TETUNE_HD inline Frame frame_of(const ReferenceView& ref, const Site& site) {
  if (site.kind == SiteKind::triangle) {
    const SurfaceTriangle t = ref.triangles[site.item];
    return {ref.point(t.v[0]), ref.point(t.v[1]), ref.point(t.v[2])};
  }
  const Ends e = ends_of(ref, site);
  return {ref.point(e.a), ref.point(e.b)};
}

/// A triangle, edge or segment of the reference surface that a vertex may move along from where it is.
struct Primitive {
  Site on;  ///< kind none: there is no way down
  Frame frame;
  Way fall;          ///< minus the derivatives along the frame
  Way down;          ///< steepest descent within it: minus the directional derivative
  double down2 = 0;  ///< its square

  Primitive() = default;
  TETUNE_HD Primitive(const ReferenceView& ref, const Site& site, const Vec3& g)
      : on(site),
        frame(frame_of(ref, site)),
        fall{-dot(g, frame.along), -dot(g, frame.aside)},
        down{fall.along * frame.inverse_along2, fall.aside * frame.inverse_aside2},
        down2(dot(fall, down)) {}
  TETUNE_HD void refuse() {
    on = {};
    down2 = 0;
  }
};

/// Barycentric coordinates below this count as zero (Alg. 4).
inline constexpr double kSnap = 1e-9;
/// How far towards a feature a vertex gets that must not step on it.
inline constexpr double kShort = 0.99;

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

/// A triangle, if the descent leads into it: the coordinates of the corners with a bit in `enters` must rise.
TETUNE_HD inline Primitive in_triangle(const ReferenceView& ref, Index triangle, unsigned enters, const Vec3& g) {
  Primitive p(ref, {SiteKind::triangle, triangle}, g);
  if (!(p.frame.aside2 > 0) || !(p.down2 > 0) || !p.frame.leads_inside(enters, p.down)) p.refuse();
  return p;
}

/// The same of an edge or segment; `from` -1: either way, else away from that end only.
TETUNE_HD inline Primitive on_edge(const ReferenceView& ref, const Site& site, Index from, const Vec3& g) {
  Primitive p(ref, site, g);
  const bool leads = from < 0 || (from == ends_of(ref, site).a ? p.down.along : -p.down.along) > 0;
  if (!leads || !(p.down2 > 0)) p.refuse();
  return p;
}

/// The steepest of an edge and its triangles.
TETUNE_HD inline Primitive across_edge(const ReferenceView& ref, const Site& site, const Vec3& g) {
  Primitive best = in_triangle(ref, site.item / 3, 1U << site.item % 3, g);
  const Index other = ref.across[site.item];
  if (other != kWall) {
    const Primitive there = in_triangle(ref, other / 3, 1U << other % 3, g);
    if (there.down2 > best.down2) best = there;
  }
  if (best.on.kind == SiteKind::none) best = on_edge(ref, site, -1, g);
  return best;
}

/// The triangles and edges at a vertex, from the dot products of their edges alone: a descent leads into a triangle
/// when both coordinates of its projection rise.
TETUNE_HD inline Primitive around(const ReferenceView& ref, Index vertex, const Vec3& g) {
  const Vec3 o = ref.point(vertex);
  Index best_triangle = -1;
  Index best_edge = -1;
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
    const double down2 = u * along_a + v * along_b;
    const double area2 = aa * bb - ab * ab;
    if (!(area2 > 0) || !(down2 > triangle2 * area2)) continue;
    triangle2 = down2 / area2;
    best_triangle = triangle;
  }
  if (triangle2 >= edge2 && best_triangle >= 0) {
    const Primitive p = in_triangle(ref, best_triangle, 0, g);
    if (p.on.kind != SiteKind::none) return p;
  }
  return best_edge >= 0 ? on_edge(ref, {SiteKind::edge, best_edge}, vertex, g) : Primitive{};
}

}  // namespace primitive_detail

/// The primitive at a site with the steepest descent against the gradient `g`, among those that it leads into (Alg. 3).
/// An edge's derivative is never larger than that of its triangles, but the descent of those may lead out of them: over
/// the edge of a valley. On an edge it is asked when neither triangle has a way down. At a vertex all are asked, as a
/// valley may fall more steeply than a triangle elsewhere.
TETUNE_HD inline Primitive steepest(const ReferenceView& ref, Mobility walker, const Site& site, const Vec3& g) {
  namespace detail = primitive_detail;
  switch (site.kind) {
    case SiteKind::triangle:
      return detail::in_triangle(ref, site.item, 0, g);
    case SiteKind::segment:
      return detail::on_edge(ref, site, -1, g);
    case SiteKind::edge:
      return detail::across_edge(ref, site, g);
    case SiteKind::vertex: {
      if (walker != Mobility::curve) return detail::around(ref, site.item, g);
      const Primitive one = detail::on_edge(ref, {SiteKind::segment, 2 * site.item}, site.item, g);
      const Primitive other = detail::on_edge(ref, {SiteKind::segment, 2 * site.item + 1}, site.item, g);
      return other.down2 > one.down2 ? other : one;
    }
    default:
      return {};
  }
}

/// Where a move along a primitive ends.
struct Landing {
  Vec3 at;
  Site site;
  double t;     ///< of the move that was made
  bool at_rim;  ///< on an edge or vertex that the vertex may cross
};

namespace primitive_detail {

TETUNE_HD inline Landing advance_on_edge(const ReferenceView& ref, Mobility walker, const Primitive& primitive,
                                         const Vec3& y, double rate, double t) {
  const Frame& frame = primitive.frame;
  double s = frame.inverse_along2 * dot(frame.along, y - frame.origin);
  s = s < 0 ? 0 : s > 1 ? 1 : s;
  const double rim = rate > 0 ? (1 - s) / rate : -s / rate;
  const auto place = [&](double by) { return frame.origin + (s + by * rate) * frame.along; };
  if (!(t >= rim)) return {place(t), primitive.on, t, false};
  const Ends e = ends_of(ref, primitive.on);
  const Index end = rate > 0 ? e.b : e.a;
  if (ref.kind[end] == walker) return {ref.point(end), {SiteKind::vertex, end}, rim, true};
  return {place(kShort * rim), primitive.on, kShort * rim, false};
}

/// Up to the rim of a triangle, from affine coordinates that change at some rates.
TETUNE_HD inline Landing advance_to_rim(const ReferenceView& ref, Mobility walker, const Primitive& primitive,
                                        const Vec3& from, const Vec3& rates, double t) {
  const Index triangle = primitive.on.item;
  const double l[3] = {from.x, from.y, from.z};
  const double rate[3] = {rates.x, rates.y, rates.z};
  int first = -1;
  double rim = 0;
  for (int k = 0; k < 3; ++k) {
    if (!(rate[k] < 0) || (first >= 0 && l[k] >= -rate[k] * rim)) continue;
    first = k;
    rim = l[k] / -rate[k];
  }
  const auto place = [&](double by) { return primitive.frame.at(from + by * rates); };
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
  const Site edge{SiteKind::edge, 3 * triangle + first};
  if (ref.across[edge.item] == kWall) return stopped_short;
  const Ends e = ends_of(ref, edge);
  return {ref.point(e.a) + l_after * (ref.point(e.b) - ref.point(e.a)), edge, rim, true};
}

/// Coordinates in a triangle of a vertex on its rim: what is 0 there is made so.
TETUNE_HD inline Vec3 on_rim(const ReferenceView& ref, Index triangle, const Site& site, const Vec3& l) {
  const SurfaceTriangle t = ref.triangles[triangle];
  if (site.kind == SiteKind::vertex) {
    return {t.v[0] == site.item ? 1.0 : 0.0, t.v[1] == site.item ? 1.0 : 0.0, t.v[2] == site.item ? 1.0 : 0.0};
  }
  const Index corner = (site.item / 3 == triangle ? site.item : ref.across[site.item]) % 3;
  return {corner == 0 ? 0 : l.x, corner == 1 ? 0 : l.y, corner == 2 ? 0 : l.z};
}

}  // namespace primitive_detail

/// Moves from y at `site` by t p along a primitive, no farther than its rim, and identifies the site there (Alg. 4).
/// The position is built from coordinates on the primitive, so that rounding does not add up over many moves.
TETUNE_HD inline Landing advance(const ReferenceView& ref, Mobility walker, const Primitive& primitive,
                                 const Site& site, const Vec3& y, const Way& p, double t) {
  const Frame& frame = primitive.frame;
  if (primitive.on.kind != SiteKind::triangle)
    return primitive_detail::advance_on_edge(ref, walker, primitive, y, p.along, t);
  Vec3 l = frame.coordinates(y);
  l = {l.x < 0 ? 0 : l.x, l.y < 0 ? 0 : l.y, l.z < 0 ? 0 : l.z};
  if (site.kind != SiteKind::triangle) l = primitive_detail::on_rim(ref, primitive.on.item, site, l);
  const Vec3 rates = frame.rates(p);
  // Most moves end well inside: that takes no division.
  const Vec3 end = l + t * rates;
  if (end.x > kSnap && end.y > kSnap && end.z > kSnap) return {frame.at(end), primitive.on, t, false};
  return primitive_detail::advance_to_rim(ref, walker, primitive, l, rates, t);
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "surface/star_cover.hpp"

namespace tetune {

/// The bound on how far the surface of the mesh and the reference surface may lie apart, for moves of one vertex.
///
/// Over each triangle of the mesh's surface, the reference is a height: piecewise linear, so its largest value is at a
/// corner of a reference triangle clipped to the prism over the mesh's triangle. Where all heights are within the
/// bound, so is the distance of each from the other. In the wedge that opens between the prisms of two triangles, the
/// distance from their common edge is a convex function, so there the corners of the reference are asked themselves.
/// The reference triangles are found from the sites of the triangle's vertices on, from neighbour to neighbour within
/// the patch. Along feature lines the same is done in one dimension. What cannot be decided in the memory of one thread
/// counts as too far.
class DeviationBound {
 public:
  TETUNE_HD DeviationBound(const ReferenceView& ref, Span<const Point> points, Span<const Site> sites, Index vertex,
                           double limit)
      : ref_(ref), points_(points), sites_(sites), vertex_(vertex), limit_(limit) {}

  /// Whether the vertex may be at x. A limit of 0: anywhere.
  TETUNE_HD bool allows(const Vec3& x, const Site& site) const {
    if (!(limit_ > 0)) return true;
    if (ref_.kind[vertex_] == Mobility::curve) {
      for (int way = 0; way < 2; ++way) {
        if (!line_is_close(x, site, ref_.line[vertex_].next[way])) return false;
      }
    }
    if (slides(vertex_)) {
      StarCover star(ref_, points_, sites_, limit_);
      if (star.take(vertex_, x)) {
        const auto wedge_at = [&](std::uint32_t corner, const Vec3& p, const double l[3]) {
          return wedge_of(corner, x, p, l);
        };
        StarCover::Mask in_doubt = 0;
        if (!star.is_close(site, wedge_at, in_doubt)) return false;
        for (int i = 0; i < star.size(); ++i) {
          if ((in_doubt >> i & 1) != 0 && !triangle_is_close(star.corner(i), x, site)) return false;
        }
        return true;
      }
    }
    for (Size c = ref_.vertex2corner.begin(vertex_); c < ref_.vertex2corner.end(vertex_); ++c) {
      if (!triangle_is_close(ref_.vertex2corner.items[c], x, site)) return false;
    }
    return true;
  }

 private:
  static constexpr int kMostTriangles = 96;
  static constexpr int kMostSegments = 64;
  static constexpr Index kNone = -1;
  /// Of the prism over a triangle: reference triangles that only touch it do not count.
  static constexpr double kInset = 1e-6;
  /// Part of a triangle that may lie beyond the patch.
  static constexpr double kUncovered = 1e-3;
  /// In a corner between a line and a height both count.
  static constexpr double kShare = 0.7;

  /// Coordinates over a triangle of the mesh, and the height above it.
  struct Over {
    double l[3];
    double height;
  };

  /// The reference triangles found so far.
  struct Found {
    Index triangle[kMostTriangles];
    bool taken[kMostTriangles];  ///< of those looked at: over the triangle, or in a wedge beside it
    int count = 0;
    bool full = false;
    TETUNE_HD void add(Index t) {
      for (int i = 0; i < count; ++i) {
        if (triangle[i] == t) return;
      }
      if (count == kMostTriangles) {
        full = true;
      } else {
        triangle[count++] = t;
      }
    }
  };

  TETUNE_HD void start_at(const Site& site, Found& found) const {
    if (site.kind == SiteKind::triangle) {
      found.add(site.item);
    } else if (site.kind == SiteKind::edge) {
      found.add(site.item / 3);
      if (ref_.across[site.item] != kWall) found.add(ref_.across[site.item] / 3);
    } else if (site.kind == SiteKind::vertex || site.kind == SiteKind::segment) {
      const bool vertex = site.kind == SiteKind::vertex;
      const Ends ends = vertex ? Ends{site.item, site.item} : ends_of(ref_, site);
      const Index from = ref_.vertex2corner.shorter(ends.a, ends.b);
      const Index to = ends.a ^ ends.b ^ from;
      for (Size c = ref_.vertex2corner.begin(from); c < ref_.vertex2corner.end(from); ++c) {
        const auto triangle = static_cast<Index>(ref_.vertex2corner.items[c] / 3);
        const SurfaceTriangle t = ref_.triangles[triangle];
        if (t.v[0] == to || t.v[1] == to || t.v[2] == to) found.add(triangle);
      }
    }
  }

  /// Whether one of the first i triangles that was taken is a neighbour of triangle i within the patch.
  TETUNE_HD bool is_beside_taken(const Found& found, int i) const {
    for (Index k = 0; k < 3; ++k) {
      const Index next = ref_.across[3 * found.triangle[i] + k];
      for (int j = 0; next != kWall && j < i; ++j) {
        if (found.triangle[j] == next / 3 && found.taken[j]) return true;
      }
    }
    return false;
  }

  TETUNE_HD bool triangle_is_close(std::uint32_t corner, const Vec3& x, const Site& site) const {
    const SurfaceTriangle t = ref_.triangles[corner / 3];
    const Index va = t.v[(corner + 1) % 3];
    const Index vb = t.v[(corner + 2) % 3];
    const Vec3 a = vec(points_[va]) - x;
    const Vec3 b = vec(points_[vb]) - x;
    const Vec3 normal = cross(a, b);
    const double n2 = dot(normal, normal);
    if (!(n2 > 0)) return false;
    const Vec3 slope_a = (1 / n2) * cross(b, normal);
    const Vec3 slope_b = (1 / n2) * cross(normal, a);
    const Vec3 unit = (1 / std::sqrt(n2)) * normal;

    Found found;
    start_at(site, found);
    start_at(sites_[va], found);
    start_at(sites_[vb], found);
    const int starts = found.count;
    Asked asked[kMostTriangles];
    int asked_count = 0;
    double covered = 0;
    double highest = 0;
    for (int i = 0; i < found.count; ++i) {
      Over polygon[9];
      Over corners[3];
      int n = 3;
      const SurfaceTriangle r = ref_.triangles[found.triangle[i]];
      for (int k = 0; k < 3; ++k) {
        const Vec3 d = ref_.point(r.v[k]) - x;
        const double la = dot(slope_a, d);
        const double lb = dot(slope_b, d);
        polygon[k] = {{1 - la - lb, la, lb}, dot(unit, d)};
        corners[k] = polygon[k];
      }
      for (int side = 0; side < 3 && n > 0; ++side) n = clip(polygon, n, side);
      found.taken[i] = false;
      // Where the search starts, there are also triangles of other patches. One of this patch may be reached later.
      if (n < 3 && i < starts && !is_beside_taken(found, i)) {
        found.triangle[i] = kNone;
        continue;
      }
      bool in_wedge = false;
      for (int k = 0; k < 3; ++k) {
        const double* l = corners[k].l;
        if (l[0] >= 0 && l[1] >= 0 && l[2] >= 0) continue;
        int place = 0;
        while (place < asked_count && asked[place].vertex != r.v[k]) ++place;
        if (place == kMostTriangles) return false;
        if (place == asked_count) asked[asked_count++] = {r.v[k], wedge_of(corner, x, ref_.point(r.v[k]), l)};
        if (asked[place].wedge == Wedge::far) return false;
        in_wedge = in_wedge || asked[place].wedge == Wedge::close;
      }
      if (n < 3 && !in_wedge) continue;
      found.taken[i] = true;
      double twice_area = 0;
      for (int k = 0; k < n; ++k) {
        const double height = std::fabs(polygon[k].height);
        if (!(height <= limit_)) return false;
        highest = height > highest ? height : highest;
        const Over& p = polygon[k];
        const Over& q = polygon[(k + 1) % n];
        twice_area += p.l[1] * q.l[2] - p.l[2] * q.l[1];
      }
      covered += std::fabs(twice_area);
      for (Index k = 0; k < 3; ++k) {
        const Index next = ref_.across[3 * found.triangle[i] + k];
        if (next != kWall) found.add(next / 3);
      }
      if (found.full) return false;
    }
    const double uncovered = (1 - covered) * std::sqrt(n2);
    if (uncovered <= kUncovered * std::sqrt(n2)) return true;
    // Beside a line, the triangle may reach beyond the patch by as much as the line's chord does.
    double beside = 0;
    if (!slides(vertex_) && !slides(va)) beside += norm(a);
    if (!slides(vertex_) && !slides(vb)) beside += norm(b);
    if (!slides(va) && !slides(vb)) beside += norm(b - a);
    return highest <= kShare * limit_ && uncovered <= 2 * limit_ * beside;
  }
  TETUNE_HD Vec3 at(Index v, const Vec3& x) const { return v == vertex_ ? x : vec(points_[v]); }

  /// A corner of the reference that was looked at.
  struct Asked {
    Index vertex;
    Wedge wedge;
  };

  /// For a corner of the reference beyond the prism over the triangle at `corner`, with coordinates l over its vertices
  /// from the corner's on: whether it is in the wedge at an edge or vertex, where no prism is, and within the bound
  /// then.
  TETUNE_HD Wedge wedge_of(std::uint32_t corner, const Vec3& x, const Vec3& p, const double l[3]) const {
    const SurfaceTriangle t = ref_.triangles[corner / 3];
    for (std::uint32_t side = 0; side < 3; ++side) {
      const std::uint32_t k = (corner + side) % 3;
      const Vec3 a = at(t.v[(k + 1) % 3], x);
      const Vec3 e = at(t.v[(k + 2) % 3], x) - a;
      const Vec3 d = p - a;
      const double e2 = dot(e, e);
      const double s = dot(d, e) / e2;
      if (l[side] < 0 && s > 0 && s < 1) {
        const Index other = ref_.across[Size{corner / 3} * 3 + k];
        // Beside a line the patch ends, and line_is_close() has the say.
        if (other == kWall) continue;
        const Vec3 apex = at(ref_.triangles[other / 3].v[other % 3], x) - a;
        if (dot(d, apex - (dot(apex, e) / e2) * e) > 0) continue;
        return within(d - s * e);
      }
      // At the vertex a, if none of its edges leads closer.
      if (s > 0 || dot(d, at(t.v[k], x) - a) > 0) continue;
      bool closer = false;
      const Index v = t.v[(k + 1) % 3];
      for (Size c = ref_.vertex2corner.begin(v); c < ref_.vertex2corner.end(v) && !closer; ++c) {
        const std::uint32_t o = ref_.vertex2corner.items[c];
        const SurfaceTriangle q = ref_.triangles[o / 3];
        closer = dot(d, at(q.v[(o + 1) % 3], x) - a) > 0 || dot(d, at(q.v[(o + 2) % 3], x) - a) > 0;
      }
      if (!closer) return within(d);
    }
    return Wedge::none;
  }
  TETUNE_HD Wedge within(const Vec3& d) const { return dot(d, d) <= limit_ * limit_ ? Wedge::close : Wedge::far; }

  TETUNE_HD bool slides(Index v) const { return ref_.kind[v] == Mobility::surface; }

  /// Cuts off what is below one coordinate (Sutherland and Hodgman); returns the number of corners left.
  TETUNE_HD static int clip(Over* polygon, int n, int side) {
    Over out[9];
    int m = 0;
    for (int k = 0; k < n; ++k) {
      const Over& p = polygon[k];
      const Over& q = polygon[(k + 1) % n];
      const double dp = p.l[side] - kInset;
      const double dq = q.l[side] - kInset;
      if (dp >= 0) out[m++] = p;
      if ((dp < 0) == (dq < 0)) continue;
      const double s = dp / (dp - dq);
      Over cut;
      for (int j = 0; j < 3; ++j) cut.l[j] = p.l[j] + s * (q.l[j] - p.l[j]);
      cut.height = p.height + s * (q.height - p.height);
      out[m++] = cut;
    }
    for (int k = 0; k < m; ++k) polygon[k] = out[k];
    return m;
  }

  /// Whether the reference line from the vertex to its neighbour on the line keeps close to the edge between them.
  TETUNE_HD bool line_is_close(const Vec3& x, const Site& site, Index neighbour) const {
    const Vec3 e = vec(points_[neighbour]) - x;
    const double length2 = dot(e, e);
    const Ends goal = interval(sites_[neighbour]);
    const Ends start = interval(site);
    for (int way = 0; way < 2; ++way) {
      const bool on_vertex = start.a == start.b;
      const Index from = on_vertex || way == 0 ? start.a : start.b;
      const Index to = on_vertex ? ref_.line[start.a].next[way] : way == 0 ? start.b : start.a;
      if (same({from, to}, goal) || reaches(from, to, goal, x, e, length2)) return true;
    }
    return false;
  }

  /// Whether the line, from one of its vertices on to the next, reaches the goal with all that it passes close to the
  /// edge.
  TETUNE_HD bool reaches(Index from, Index at, const Ends& goal, const Vec3& x, const Vec3& e, double length2) const {
    for (int i = 0; i < kMostSegments; ++i) {
      if (goal.a == goal.b && at == goal.a) return true;
      const Vec3 d = ref_.point(at) - x;
      double s = length2 > 0 ? dot(d, e) / length2 : 0;
      s = s < 0 ? 0 : s > 1 ? 1 : s;
      const Vec3 off = d - s * e;
      if (!(dot(off, off) <= kShare * kShare * limit_ * limit_)) return false;
      if (ref_.kind[at] != Mobility::curve) return false;
      const LineVertex line = ref_.line[at];
      const Index next = line.next[0] == from ? line.next[1] : line.next[0];
      if (same({at, next}, goal)) return true;
      from = at;
      at = next;
    }
    return false;
  }

  TETUNE_HD Ends interval(const Site& site) const {
    return site.kind == SiteKind::segment ? ends_of(ref_, site) : Ends{site.item, site.item};
  }
  TETUNE_HD static bool same(const Ends& p, const Ends& q) {
    return (p.a == q.a && p.b == q.b) || (p.a == q.b && p.b == q.a);
  }

  const ReferenceView& ref_;
  Span<const Point> points_;
  Span<const Site> sites_;
  Index vertex_;
  double limit_;
};

}  // namespace tetune

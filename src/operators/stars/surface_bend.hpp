// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/boundary_triangles.hpp"
#include "boundary/sliding/open_fan.hpp"
#include "operators/stars/star_candidate.hpp"

namespace tetune {

/// The distance between a curved surface before and after an operation on it. Each surface triangle carries a bound on
/// the distance that operations have added since the start (BoundaryTriangle::deviation); an operation adds its own to
/// the largest of the triangles that it replaces, and is not made where the sum would exceed the limit.
class SurfaceBend {
 public:
  TETUNE_HD SurfaceBend(Span<const Point> points, Span<const BoundaryTriangle> triangles, const BendLimit& limit)
      : points_(points), triangles_(triangles), limit_(limit) {}

  /// The deviation after a vertex at x has replaced a simplex of the surface, an edge or a triangle; kInfeasible where
  /// it would be too large.
  TETUNE_HD double after_insertion(const SurfaceSimplex& simplex, const ReplacedTriangles& replaced,
                                   const Vec3& x) const {
    return largest_of_sheets(replaced, [&](std::uint32_t& left) { return of_insertion(simplex, replaced, left, x); });
  }
  /// The deviation after v has been contracted to another vertex of the triangles at it; kInfeasible where it would be
  /// too large.
  TETUNE_HD double after_contraction(Index v, Index apex, const ReplacedTriangles& replaced) const {
    const Index end = line_end(v, apex, replaced);
    return largest_of_sheets(replaced,
                             [&](std::uint32_t& left) { return of_contraction(v, apex, end, replaced, left); });
  }
  /// The deviation after v has moved to x, inside the fan of the triangles at it; kInfeasible where it would be above a
  /// part of the limit, or the triangles are not one fan.
  TETUNE_HD double after_motion(Index v, const Vec3& x, const ReplacedTriangles& at) const {
    OpenFan fan;
    std::uint32_t left = (std::uint32_t{1} << at.count) - 1;
    take_sheet(v, at, left, fan);
    if (left != 0) return kInfeasible;
    const Vec3 c = vec(points_[v]);
    const FanComparison comparison(points_, c, fan);
    const double distance = comparison.distance(c, fan, x, fan, norm(x - c));
    const double deviation = add_to_deviation(at, distance, comparison.edge_length(fan));
    return deviation <= kMotionShare * limit_.max_bend ? deviation : kInfeasible;
  }

 private:
  /// The part of the limit that motions may use up: operations need the rest.
  static constexpr double kMotionShare = 0.5;
  static_assert(kMaxStarTriangles <= OpenFan::kMaxEdges);

  /// The largest of the deviations of all sheets, each of which removes its triangles from the set of those that are
  /// left.
  template <class Sheet>
  TETUNE_HD double largest_of_sheets(const ReplacedTriangles& replaced, const Sheet& deviation_of_sheet) const {
    double largest = 0;
    for (std::uint32_t left = (std::uint32_t{1} << replaced.count) - 1; left != 0 && largest < kInfeasible;) {
      const double d = deviation_of_sheet(left);
      largest = d > largest ? d : largest;
    }
    return largest;
  }
  TETUNE_HD double add_to_deviation(const ReplacedTriangles& replaced, double distance, double edge_length) const {
    double largest = 0;
    for (int i = 0; i < replaced.count; ++i) {
      const double d = triangles_[replaced.triangle[i]].deviation;
      largest = d > largest ? d : largest;
    }
    return limit_.add(largest, distance, edge_length);
  }
  /// The vertex other than the apex that v has a feature edge to, or -1.
  TETUNE_HD Index line_end(Index v, Index apex, const ReplacedTriangles& replaced) const {
    for (int i = 0; i < replaced.count; ++i) {
      const BoundaryTriangle& t = triangles_[replaced.triangle[i]];
      for (const Index w : t.v) {
        if (w != v && w != apex && is_feature_edge(t, v, w)) return w;
      }
    }
    return -1;
  }
  TETUNE_HD static int corner_of(const BoundaryTriangle& t, Index v) { return t.v[0] == v ? 0 : t.v[1] == v ? 1 : 2; }

  /// How a triangle at v is to be added to a fan of triangles around v.
  enum class FanSide {
    none,      ///< not at all: it is beside none of the fan
    same,      ///< as it is: it has the orientation of its neighbor in the fan
    opposite,  ///< turned over
  };

  /// Adds a triangle to a fan around v.
  TETUNE_HD void add(Index v, const BoundaryTriangle& t, FanSide side, OpenFan& fan) const {
    const int k = corner_of(t, v);
    const Index a = t.v[(k + 1) % 3];
    const Index b = t.v[(k + 2) % 3];
    side == FanSide::opposite ? fan.add(b, a) : fan.add(a, b);
  }

  TETUNE_HD double of_insertion(const SurfaceSimplex& simplex, const ReplacedTriangles& replaced, std::uint32_t& left,
                                const Vec3& x) const {
    const Index v = simplex.v[0];
    const Vec3 c = vec(points_[v]);
    OpenFan before;
    take_sheet(v, replaced, left, before);
    OpenFan after;
    for (int i = 0; i < before.count; ++i) {
      const Index a = before.edge[i][0];
      const Index b = before.edge[i][1];
      after.add(a, b);
      if (simplex.has(a)) after.add(b, v);
      if (simplex.has(b)) after.add(v, a);
    }
    const FanComparison comparison(points_, c, before);
    const Vec3 b = vec(points_[simplex.v[1]]);
    const double distance_to_edge = segment_distance(x, x, c, b);
    double distance = 0;
    if (simplex.size == 2 && before.count == 1) {
      // On a feature line: the map that moves the foot of x on the edge to x and is linear on both parts of the
      // triangle.
      if (comparison.shape(x, after) == FanShape::folded) return kInfeasible;
      distance = distance_to_edge;
    } else {
      distance = comparison.distance(c, before, x, after, distance_to_edge);
    }
    return add_to_deviation(replaced, distance, comparison.edge_length(before));
  }

  TETUNE_HD double of_contraction(Index v, Index apex, Index line_end, const ReplacedTriangles& replaced,
                                  std::uint32_t& left) const {
    OpenFan before;
    take_sheet(v, replaced, left, before);
    OpenFan after;
    for (int i = 0; i < before.count; ++i) {
      if (before.edge[i][0] != apex && before.edge[i][1] != apex) after.add(before.edge[i][0], before.edge[i][1]);
    }
    Vec3 c = vec(points_[v]);
    const Vec3 x = vec(points_[apex]);
    const FanComparison comparison(points_, c, before);
    const double length = comparison.edge_length(before);
    if (comparison.shape(c, before) == FanShape::folded) return kInfeasible;
    double moved = 0;
    if (line_end >= 0) {
      // The outline follows the line: first v moves onto its new segment.
      const Vec3 end = vec(points_[line_end]);
      const double s = dot(c - x, end - x) / dot(end - x, end - x);
      if (!(s > 0 && s < 1)) return kInfeasible;
      const Vec3 foot = x + s * (end - x);
      moved = norm(foot - c);
      c = foot;
    }
    return add_to_deviation(replaced, moved + comparison.distance(c, before, x, after, norm(x - c)), length);
  }
  /// Moves the triangles of one sheet, those that are connected over edges at v that are no features, from `left` to a
  /// fan.
  TETUNE_HD void take_sheet(Index v, const ReplacedTriangles& replaced, std::uint32_t& left, OpenFan& fan) const {
    for (bool grown = true; grown;) {
      grown = false;
      for (int i = 0; i < replaced.count; ++i) {
        if ((left >> i & 1) == 0) continue;
        const BoundaryTriangle& t = triangles_[replaced.triangle[i]];
        const FanSide side = fan.count == 0 ? FanSide::same : side_in(v, t, fan);
        if (side == FanSide::none) continue;
        add(v, t, side, fan);
        left &= ~(std::uint32_t{1} << i);
        grown = true;
      }
    }
  }
  TETUNE_HD FanSide side_in(Index v, const BoundaryTriangle& t, const OpenFan& fan) const {
    const int k = corner_of(t, v);
    for (int side = 1; side <= 2; ++side) {
      const Index w = t.v[(k + side) % 3];
      if (is_feature_edge(t, v, w)) continue;
      for (int i = 0; i < fan.count; ++i) {
        if (fan.edge[i][2 - side] == w) return FanSide::same;
        if (fan.edge[i][side - 1] == w) return FanSide::opposite;
      }
    }
    return FanSide::none;
  }

  Span<const Point> points_;
  Span<const BoundaryTriangle> triangles_;
  BendLimit limit_;
};

}  // namespace tetune

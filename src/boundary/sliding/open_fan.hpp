// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "energy/objective.hpp"
#include "mesh/tet.hpp"

namespace tetune {

/// Triangles of the surface with a common vertex, the center: the edges opposite it. All are oriented alike.
struct OpenFan {
  static constexpr int kMaxEdges = 24;
  int count = 0;
  Index edge[kMaxEdges][2];

  TETUNE_HD void add(Index a, Index b) {
    edge[count][0] = a;
    edge[count++][1] = b;
  }
};

/// Compares two triangulations of one part of the surface, each a fan, with the same outline, as graphs of a height
/// over a plane. The difference of the heights is linear between the points where edges of the two cross or end, so
/// its maximum is at one of these; it bounds the distance between the two in both directions.
class FanComparison {
 public:
  /// The plane is the mean plane of the fan with its center at c.
  TETUNE_HD FanComparison(Span<const Point> points, const Vec3& c, const OpenFan& fan) : points_(points) {
    Vec3 sum{0, 0, 0};
    for (int i = 0; i < fan.count; ++i) sum = sum + area_normal(c, fan, i);
    twice_area_ = norm(sum);
    normal_ = (1 / twice_area_) * sum;
  }

  /// The edge length of equilateral triangles of the mean area of those of the fan.
  TETUNE_HD double edge_length(const OpenFan& fan) const {
    constexpr double kTwiceAreaOfUnitTriangle = 0.8660254037844386;
    return std::sqrt(twice_area_ / (kTwiceAreaOfUnitTriangle * fan.count));
  }
  /// Whether the normals of all triangles are within 60 degrees of that of the plane.
  TETUNE_HD bool is_graph(const Vec3& c, const OpenFan& fan) const {
    for (int i = 0; i < fan.count; ++i) {
      const Vec3 n = area_normal(c, fan, i);
      if (!(dot(normal_, n) > kMinCos * norm(n))) return false;
    }
    return true;
  }
  /// The largest difference of the heights of a fan with its center at a and one with its center at b; kInfeasible
  /// where one of them is no graph.
  TETUNE_HD double distance(const Vec3& a, const OpenFan& fan_a, const Vec3& b, const OpenFan& fan_b) const {
    if (!is_graph(a, fan_a) || !is_graph(b, fan_b)) return kInfeasible;
    const double of_a = height_over(a, b, fan_b);
    const double of_b = height_over(b, a, fan_a);
    double largest = of_a > of_b ? of_a : of_b;
    for (int i = 0; i < 2 * fan_a.count; ++i) {
      const Vec3 p = vec(points_[fan_a.edge[i / 2][i % 2]]);
      for (int j = 0; j < 2 * fan_b.count; ++j) {
        const double height = height_at_crossing(a, p, b, vec(points_[fan_b.edge[j / 2][j % 2]]));
        largest = height > largest ? height : largest;
      }
    }
    return largest;
  }

 private:
  static constexpr double kMinCos = 0.5;
  /// The tolerance of barycentric coordinates for rounding.
  static constexpr double kOutside = 1e-9;

  TETUNE_HD Vec3 area_normal(const Vec3& c, const OpenFan& fan, int i) const {
    return cross(vec(points_[fan.edge[i][0]]) - c, vec(points_[fan.edge[i][1]]) - c);
  }
  /// The cross product of the projections of two vectors.
  TETUNE_HD double projected_cross(const Vec3& d, const Vec3& e) const { return dot(normal_, cross(d, e)); }

  /// The height of x over a fan.
  TETUNE_HD double height_over(const Vec3& x, const Vec3& c, const OpenFan& fan) const {
    double largest = -1;
    const Vec3 d = x - c;
    for (int i = 0; i < fan.count; ++i) {
      const Vec3 e = vec(points_[fan.edge[i][0]]) - c;
      const Vec3 f = vec(points_[fan.edge[i][1]]) - c;
      const double area = projected_cross(e, f);
      const double l = projected_cross(d, f) / area;
      const double m = projected_cross(e, d) / area;
      if (!(l >= -kOutside && m >= -kOutside && l + m <= 1 + kOutside)) continue;
      const double height = std::fabs(dot(normal_, d - l * e - m * f));
      largest = height > largest ? height : largest;
    }
    return largest < 0 ? kInfeasible : largest;
  }
  /// The difference of the heights of segments (a, p) and (b, q) where they cross, else 0.
  TETUNE_HD double height_at_crossing(const Vec3& a, const Vec3& p, const Vec3& b, const Vec3& q) const {
    const Vec3 d = p - a;
    const Vec3 e = q - b;
    const Vec3 ab = b - a;
    const double area = projected_cross(d, e);
    const double s = projected_cross(ab, e) / area;
    const double t = projected_cross(ab, d) / area;
    return s > 0 && s < 1 && t > 0 && t < 1 ? std::fabs(dot(normal_, ab + t * e - s * d)) : 0;
  }

  Span<const Point> points_;
  Vec3 normal_;
  double twice_area_;
};

}  // namespace tetune

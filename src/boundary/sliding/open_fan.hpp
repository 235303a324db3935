// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "backend/span.hpp"
#include "energy/objective.hpp"
#include "mesh/tet.hpp"

namespace tetune {

/// Triangles of the surface with a common vertex, the center: the edges opposite it. All are oriented consistently.
struct OpenFan {
  static constexpr int kMaxEdges = 24;
  int count = 0;
  Index edge[kMaxEdges][2];

  TETUNE_HD void add(Index a, Index b) {
    edge[count][0] = a;
    edge[count++][1] = b;
  }
};

/// The shape of a fan over a plane.
enum class FanShape {
  graph,               ///< of a height
  has_thin_triangles,  ///< a graph up to triangles that are so thin that their normals are noise
  folded,
};

/// The distance between two segments, or slightly more where they are nearly parallel.
TETUNE_HD inline double segment_distance(const Vec3& a, const Vec3& b, const Vec3& p, const Vec3& q) {
  const auto clamp = [](double t) { return t > 0 ? t < 1 ? t : 1.0 : 0.0; };
  const Vec3 d = b - a;
  const Vec3 e = q - p;
  const Vec3 ap = p - a;
  const double dd = dot(d, d);
  const double de = dot(d, e);
  const double ee = dot(e, e);
  const double det = dd * ee - de * de;
  double s = det > 0 ? clamp((ee * dot(d, ap) - de * dot(e, ap)) / det) : 0.0;
  const double t = ee > 0 ? clamp((s * de - dot(e, ap)) / ee) : 0.0;
  s = dd > 0 ? clamp((t * de + dot(d, ap)) / dd) : 0.0;
  return norm(ap + t * e - s * d);
}

/// Compares two triangulations of one part of the surface, each a fan, with the same outline. There are two bounds on
/// the distance between them, in both directions:
///   - As graphs of a height over a plane: the difference of the heights is linear between the points where edges of
///     the two cross or end, so its maximum is at one of these.
///   - Each is a cone over the outline. The map that is linear on the cones and moves one apex to the other moves no
///     point further than that. It needs no plane, so it also holds where a triangle is so thin that its normal is
///     noise, as in caps of scanned surfaces.
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
  /// Whether the normals of all triangles, or of all but thin ones, are within 60 degrees of that of the plane.
  TETUNE_HD FanShape shape(const Vec3& c, const OpenFan& fan) const {
    FanShape shape = FanShape::graph;
    for (int i = 0; i < fan.count; ++i) {
      const Vec3 n = area_normal(c, fan, i);
      if (dot(normal_, n) > kMinCos * norm(n)) continue;
      if (!is_thin(c, fan, i, norm(n))) return FanShape::folded;
      shape = FanShape::has_thin_triangles;
    }
    return shape;
  }
  /// A bound on the distance between a fan with its center at a and one with its center at b; kInfeasible where one of
  /// them is folded. `apexes`: the distance between a point from which the first is a cone and one from which the
  /// second is.
  TETUNE_HD double distance(const Vec3& a, const OpenFan& fan_a, const Vec3& b, const OpenFan& fan_b,
                            double apexes) const {
    const FanShape of_both[2] = {shape(a, fan_a), shape(b, fan_b)};
    if (of_both[0] == FanShape::folded || of_both[1] == FanShape::folded) return kInfeasible;
    if (of_both[0] != FanShape::graph || of_both[1] != FanShape::graph) return apexes;
    const double heights = height_difference(a, fan_a, b, fan_b);
    return heights < apexes ? heights : apexes;
  }

 private:
  static constexpr double kMinCos = 0.5;
  /// A triangle is thin whose height over its longest edge is below this part of the edge.
  static constexpr double kThin = 0.02;
  /// The tolerance of barycentric coordinates for rounding.
  static constexpr double kOutside = 1e-9;

  TETUNE_HD bool is_thin(const Vec3& c, const OpenFan& fan, int i, double twice_area) const {
    const Vec3 a = vec(points_[fan.edge[i][0]]);
    const Vec3 b = vec(points_[fan.edge[i][1]]);
    double longest2 = dot(b - a, b - a);
    for (const Vec3& d : {a - c, b - c}) longest2 = dot(d, d) > longest2 ? dot(d, d) : longest2;
    return twice_area < kThin * longest2;
  }
  TETUNE_HD double height_difference(const Vec3& a, const OpenFan& fan_a, const Vec3& b, const OpenFan& fan_b) const {
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

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune {

/// The largest absolute value of a coordinate; 0 without points.
inline double largest_coordinate(const std::vector<Point3>& points) {
  double largest = 0;
  for (const Point3& p : points) {
    for (const double x : p) largest = std::max(largest, std::fabs(x));
  }
  return largest;
}

/// A power of two that scales the largest coordinate to about 1. Multiplication by it is exact, except for coordinates
/// below 2^-1022 of the largest, and keeps products of several lengths in range.
inline double unit_scale(double largest) {
  return largest > 0 ? std::ldexp(1.0, std::clamp(-std::ilogb(largest), -1020, 1020)) : 1;
}
inline double unit_scale(const std::vector<Point3>& points) { return unit_scale(largest_coordinate(points)); }
inline double unit_scale(const TetMesh& mesh) { return unit_scale(mesh.points); }

}  // namespace tetune

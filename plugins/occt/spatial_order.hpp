// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "tetune/types.hpp"

namespace tetune::plugin {

/// Places on a Z-order curve through the bounding box of points: near places are near each other.
inline std::vector<std::uint32_t> places_of(const std::vector<Point3>& points) {
  constexpr int kBits = 10;  // per direction
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Point3 low{kInfinity, kInfinity, kInfinity};
  double size = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    double high = -kInfinity;
    for (const Point3& p : points) {
      low[k] = std::min(low[k], p[k]);
      high = std::max(high, p[k]);
    }
    size = std::max(size, high - low[k]);
  }
  const double scale = size > 0 ? ((1 << kBits) - 1) / size : 0;
  std::vector<std::uint32_t> places;
  places.reserve(points.size());
  for (const Point3& p : points) {
    std::uint32_t place = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto x = std::uint32_t(scale * (p[k] - low[k]));
      for (int bit = 0; bit < kBits; ++bit) place |= ((x >> bit) & 1U) << (3 * bit + int(k));
    }
    places.push_back(place);
  }
  return places;
}

}  // namespace tetune::plugin

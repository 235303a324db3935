// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "math/constants.hpp"
#include "math/hilbert.hpp"
#include "tetune/types.hpp"

namespace tetune::plugin {

/// Positions along the Hilbert curve through the bounding box of points: near positions are near each other.
inline std::vector<std::uint64_t> positions_of(const std::vector<Point3>& points) {
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
  const double scale = size > 0 ? (kHilbertCells - 1) / size : 0;
  const auto cell = [&](const Point3& p, std::size_t k) { return std::uint32_t(scale * (p[k] - low[k])); };
  std::vector<std::uint64_t> positions;
  positions.reserve(points.size());
  for (const Point3& p : points) positions.push_back(hilbert_index(cell(p, 0), cell(p, 1), cell(p, 2)));
  return positions;
}

}  // namespace tetune::plugin

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "math/vec3.hpp"

namespace tetune {

/// An axis-aligned box.
struct Box {
  Vec3 low, high;
  bool meets(const Box& o) const {
    return low.x <= o.high.x && o.low.x <= high.x && low.y <= o.high.y && o.low.y <= high.y && low.z <= o.high.z &&
           o.low.z <= high.z;
  }
  void include(const Vec3& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  void include(const Box& o) {
    include(o.low);
    include(o.high);
  }
  /// The squared distance of a point from the box.
  double distance2(const Vec3& p) const {
    const Vec3 d{std::max({low.x - p.x, p.x - high.x, 0.0}), std::max({low.y - p.y, p.y - high.y, 0.0}),
                 std::max({low.z - p.z, p.z - high.z, 0.0})};
    return dot(d, d);
  }
};

}  // namespace tetune

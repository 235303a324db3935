// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "backend/span.hpp"
#include "math/box.hpp"
#include "mesh/tet.hpp"

namespace tetune {

/// A bounding volume hierarchy of boxes in the order of a Hilbert curve. Queries may run concurrently.
class BoxTree {
 public:
  explicit BoxTree(const std::vector<Box>& boxes);

  /// Calls visit(i) for the boxes i that meet `box`, in an order that depends on the boxes alone.
  template <class Visit>
  void for_meeting(const Box& box, const Visit& visit) const {
    if (!items_.empty()) descend(levels_.size() - 1, 0, box, visit);
  }

  /// Calls visit(i) for the boxes i within a squared distance of a point. Close ones tend to be first, and visit()
  /// may lower the distance.
  template <class Visit>
  void for_closer(const Vec3& p, const double& distance2, const Visit& visit) const {
    if (!items_.empty()) approach(levels_.size() - 1, 0, p, distance2, visit);
  }

 private:
  static constexpr Size kFanout = 4;

  template <class Visit>
  void descend(std::size_t level, Size node, const Box& box, const Visit& visit) const {
    const std::vector<Box>& nodes = levels_[level];
    const Size end = std::min<Size>(node + kFanout, std::ssize(nodes));
    for (Size i = node; i < end; ++i) {
      if (!span_of(nodes)[i].meets(box)) continue;
      if (level == 0) {
        visit(span_of(items_)[i]);
      } else {
        descend(level - 1, i * kFanout, box, visit);
      }
    }
  }

  template <class Visit>
  void approach(std::size_t level, Size node, const Vec3& p, const double& distance2, const Visit& visit) const {
    const std::vector<Box>& nodes = levels_[level];
    std::array<std::pair<double, Size>, kFanout> children;
    auto last = children.begin();
    const Size end = std::min<Size>(node + kFanout, std::ssize(nodes));
    for (Size i = node; i < end; ++i) {
      const std::pair<double, Size> child{span_of(nodes)[i].distance2(p), i};
      auto place = last++;
      for (; place != children.begin() && child < *(place - 1); --place) *place = *(place - 1);
      *place = child;
    }
    for (auto child = children.begin(); child != last && child->first <= distance2; ++child) {
      const Size i = child->second;
      if (level == 0) {
        visit(span_of(items_)[i]);
      } else {
        approach(level - 1, i * kFanout, p, distance2, visit);
      }
    }
  }

  std::vector<Index> items_;              ///< in the order of the curve
  std::vector<std::vector<Box>> levels_;  ///< of the items; then of kFanout boxes of the level before each
};

}  // namespace tetune

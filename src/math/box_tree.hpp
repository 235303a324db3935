// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "backend/span.hpp"
#include "math/box.hpp"
#include "math/constants.hpp"
#include "tetune/types.hpp"

namespace tetune {

/// A bounding volume hierarchy of boxes in the order of a Hilbert curve. Host only; queries may run concurrently.
class BoxTree {
 public:
  explicit BoxTree(const std::vector<Box>& boxes);

  /// Calls visit(i) for the boxes i that meet `box`, in an order that depends on the boxes alone.
  template <class Visit>
  void for_meeting(const Box& box, const Visit& visit) const {
    while_meeting(box, [&visit](Index i) {
      visit(i);
      return true;
    });
  }
  /// Visits items as for_meeting() does, until visit() returns false. Returns whether it never did.
  template <class Visit>
  bool while_meeting(const Box& box, const Visit& visit) const {
    return items_.empty() || descend(levels_.size() - 1, 0, box, visit);
  }

  /// Calls visit(i) for the boxes i within a squared distance of a point. Close ones tend to be first, and visit()
  /// may lower the distance.
  template <class Visit>
  void for_closer(const Vec3& p, const double& distance2, const Visit& visit) const {
    if (!items_.empty()) approach(levels_.size() - 1, 0, p, distance2, visit);
  }

 private:
  static constexpr Size kFanout = 4;

  /// Boxes by coordinate, so that the compiler tests them in vector registers.
  struct Node {
    std::array<std::array<double, kFanout>, 3> low, high;
    Size count = 0;

    void append(const Box& box);
    Box bounds() const;
    /// The squared distances of a point; those of boxes that do not exist are unspecified.
    std::array<double, kFanout> distances2(const Vec3& p) const {
      const std::array<double, 3> point{p.x, p.y, p.z};
      std::array<double, kFanout> sum{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t k = 0; k < kFanout; ++k) {
          const double below = low[axis][k] - point[axis];
          const double above = point[axis] - high[axis][k];
          const double outside = std::max(std::max(below, above), 0.0);
          sum[k] += outside * outside;
        }
      }
      return sum;
    }
    /// The largest gap along an axis between each box and another one; at most 0 where they meet.
    std::array<double, kFanout> gaps(const Box& box) const {
      const std::array<double, 3> from{box.low.x, box.low.y, box.low.z};
      const std::array<double, 3> to{box.high.x, box.high.y, box.high.z};
      std::array<double, kFanout> result;
      result.fill(-kInfinity);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t k = 0; k < kFanout; ++k) {
          result[k] = std::max(result[k], std::max(low[axis][k] - to[axis], from[axis] - high[axis][k]));
        }
      }
      return result;
    }
  };

  template <class Visit>
  bool descend(std::size_t level, Size node, const Box& box, const Visit& visit) const {
    const Node& boxes = span_of(levels_[level])[node];
    const auto gaps = boxes.gaps(box);
    for (Size k = 0; k < boxes.count; ++k) {
      if (gaps[to_size_t(k)] > 0) continue;
      const Size child = node * kFanout + k;
      if (!(level == 0 ? visit(span_of(items_)[child]) : descend(level - 1, child, box, visit))) return false;
    }
    return true;
  }

  template <class Visit>
  void approach(std::size_t level, Size node, const Vec3& p, const double& distance2, const Visit& visit) const {
    const Node& boxes = span_of(levels_[level])[node];
    const auto distances2 = boxes.distances2(p);
    const auto enter = [&](Size k) {
      if (!(distances2[to_size_t(k)] <= distance2)) return;
      const Size child = node * kFanout + k;
      if (level == 0) {
        visit(span_of(items_)[child]);
      } else {
        approach(level - 1, child, p, distance2, visit);
      }
    };
    const Size closest = std::min_element(distances2.begin(), distances2.begin() + boxes.count) - distances2.begin();
    enter(closest);
    for (Size k = 0; k < boxes.count; ++k) {
      if (k != closest) enter(k);
    }
  }

  std::vector<Index> items_;               ///< in the order of the curve
  std::vector<std::vector<Node>> levels_;  ///< of the items; then of the nodes of the level before each
};

}  // namespace tetune

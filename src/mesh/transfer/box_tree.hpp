// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
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

  std::vector<Index> items_;              ///< in the order of the curve
  std::vector<std::vector<Box>> levels_;  ///< of the items; then of kFanout boxes of the level before each
};

}  // namespace tetune

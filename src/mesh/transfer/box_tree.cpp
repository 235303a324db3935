// SPDX-License-Identifier: Apache-2.0
#include "mesh/transfer/box_tree.hpp"

#include <cstdint>
#include <utility>

#include "math/hilbert.hpp"

namespace tetune {
namespace {

/// The position of the center of a box along the curve through `all`.
std::uint64_t curve_position(const Box& box, const Box& all) {
  const auto cell = [](double low, double high, double from, double to) {
    const double x = to > from ? (0.5 * (low + high) - from) / (to - from) : 0;
    return static_cast<std::uint32_t>(std::clamp(x * kHilbertCells, 0.0, kHilbertCells - 1));
  };
  return hilbert_index(cell(box.low.x, box.high.x, all.low.x, all.high.x),
                       cell(box.low.y, box.high.y, all.low.y, all.high.y),
                       cell(box.low.z, box.high.z, all.low.z, all.high.z));
}

}  // namespace

BoxTree::BoxTree(const std::vector<Box>& boxes) {
  if (boxes.empty()) return;
  Box all = boxes[0];
  for (const Box& box : boxes) {
    all.include(box.low);
    all.include(box.high);
  }
  std::vector<std::pair<std::uint64_t, Index>> order;
  order.reserve(boxes.size());
  for (Index i = 0; i < std::ssize(boxes); ++i) order.emplace_back(curve_position(span_of(boxes)[i], all), i);
  std::sort(order.begin(), order.end());
  std::vector<Box> level;
  for (const auto& [position, i] : order) {
    items_.push_back(i);
    level.push_back(span_of(boxes)[i]);
  }
  while (std::ssize(level) > kFanout) {
    std::vector<Box> parents;
    for (Size i = 0; i < std::ssize(level); ++i) {
      if (i % kFanout == 0) parents.push_back(span_of(level)[i]);
      parents.back().include(span_of(level)[i].low);
      parents.back().include(span_of(level)[i].high);
    }
    levels_.push_back(std::move(level));
    level = std::move(parents);
  }
  levels_.push_back(std::move(level));
}

}  // namespace tetune

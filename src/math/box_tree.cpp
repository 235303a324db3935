// SPDX-License-Identifier: Apache-2.0
#include "math/box_tree.hpp"

#include <cstdint>
#include <utility>

#include "math/hilbert.hpp"

namespace tetune {
namespace {

/// The position of the center of a box along the Hilbert curve through the cube of edge length `side` at `corner`.
std::uint64_t curve_position(const Box& box, const Vec3& corner, double side) {
  const Vec3 center = 0.5 * (box.low + box.high);
  const auto cell = [side](double x, double from) {
    const double part = side > 0 ? (x - from) / side : 0;
    return static_cast<std::uint32_t>(std::clamp(part * kHilbertCells, 0.0, kHilbertCells - 1));
  };
  return hilbert_index(cell(center.x, corner.x), cell(center.y, corner.y), cell(center.z, corner.z));
}

}  // namespace

void BoxTree::Node::append(const Box& box) {
  const std::array<double, 3> from{box.low.x, box.low.y, box.low.z};
  const std::array<double, 3> to{box.high.x, box.high.y, box.high.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low[axis][to_size_t(count)] = from[axis];
    high[axis][to_size_t(count)] = to[axis];
  }
  ++count;
}

Box BoxTree::Node::bounds() const {
  const auto lowest = [this](std::size_t axis) {
    return *std::min_element(low[axis].begin(), low[axis].begin() + count);
  };
  const auto highest = [this](std::size_t axis) {
    return *std::max_element(high[axis].begin(), high[axis].begin() + count);
  };
  return {{lowest(0), lowest(1), lowest(2)}, {highest(0), highest(1), highest(2)}};
}

BoxTree::BoxTree(const std::vector<Box>& boxes) {
  if (boxes.empty()) return;
  Box all = boxes[0];
  for (const Box& box : boxes) all.include(box);
  const Vec3 extent = all.high - all.low;
  const double side = std::max({extent.x, extent.y, extent.z});
  std::vector<std::pair<std::uint64_t, Index>> order;
  order.reserve(boxes.size());
  for (Index i = 0; i < std::ssize(boxes); ++i) {
    order.emplace_back(curve_position(span_of(boxes)[i], all.low, side), i);
  }
  std::sort(order.begin(), order.end());
  items_.reserve(boxes.size());
  for (const auto& [position, i] : order) items_.push_back(i);
  const auto make_level = [](Size count, const auto& box_at) {
    std::vector<Node> nodes(to_size_t((count + kFanout - 1) / kFanout));
    for (Size i = 0; i < count; ++i) span_of(nodes)[i / kFanout].append(box_at(i));
    return nodes;
  };
  levels_.push_back(make_level(std::ssize(items_), [&](Size i) { return span_of(boxes)[span_of(items_)[i]]; }));
  while (levels_.back().size() > 1) {
    const Span<const Node> below = span_of(std::as_const(levels_.back()));
    levels_.push_back(make_level(below.size(), [&](Size i) { return below[i].bounds(); }));
  }
}

}  // namespace tetune

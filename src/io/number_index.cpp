// SPDX-License-Identifier: Apache-2.0
#include "io/number_index.hpp"

#include <algorithm>
#include <functional>
#include <numeric>

namespace tetune {
namespace {

/// The largest ratio of the range of the numbers to their count for which a table is built.
constexpr std::int64_t kTablePerNumber = 8;

}  // namespace

NumberIndex::NumberIndex(const std::vector<std::int64_t>& numbers) : order_(numbers.size()) {
  if (numbers.empty()) return;
  std::iota(order_.begin(), order_.end(), 0);
  const auto [least, most] = std::minmax_element(numbers.begin(), numbers.end());
  first_ = *least;
  const bool is_ascending = std::adjacent_find(numbers.begin(), numbers.end(), std::greater_equal<>()) == numbers.end();
  if (!is_ascending) {
    std::stable_sort(order_.begin(), order_.end(),
                     [&](Index a, Index b) { return span_of(numbers)[a] < span_of(numbers)[b]; });
  }
  const bool is_dense = (*most - first_) / kTablePerNumber <= std::ssize(numbers);
  if (is_dense) table_.assign(to_size_t(*most - first_) + 1, -1);
  std::int64_t last = -1;
  Index rank = 0;
  for (const Index at : order_) {
    const std::int64_t number = span_of(numbers)[at];
    if (number == last) repeated_ = number;
    last = number;
    if (is_dense) {
      span_of(table_)[number - first_] = rank++;
    } else {
      sorted_.push_back(number);
    }
  }
}

std::int64_t NumberIndex::number(Index rank) const {
  if (table_.empty()) return span_of(sorted_)[rank];
  return first_ + (std::find(table_.begin(), table_.end(), rank) - table_.begin());
}

Index NumberIndex::search(std::int64_t number) const {
  const auto at = std::lower_bound(sorted_.begin(), sorted_.end(), number);
  return at == sorted_.end() || *at != number ? -1 : to_index(at - sorted_.begin());
}

}  // namespace tetune

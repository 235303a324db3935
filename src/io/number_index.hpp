// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "backend/span.hpp"
#include "tetune/types.hpp"

namespace tetune {

/// The positions of numbers, which may have gaps.
class NumberIndex {
 public:
  NumberIndex() = default;
  /// `numbers` are not negative.
  explicit NumberIndex(const std::vector<std::int64_t>& numbers);
  /// Returns the position of a number in the ascending order of all, or -1.
  Index rank(std::int64_t number) const {
    if (table_.empty()) return search(number);
    const std::int64_t at = number - first_;
    return at < 0 || at >= std::ssize(table_) ? -1 : table_[to_size_t(at)];
  }
  /// The number of a rank, by a search in all numbers.
  std::int64_t number(Index rank) const;
  /// The positions in the list in ascending order of the numbers.
  const std::vector<Index>& order() const { return order_; }
  /// A number that occurs twice, or -1.
  std::int64_t repeated() const { return repeated_; }

 private:
  Index search(std::int64_t number) const;
  std::vector<Index> order_;
  std::int64_t first_ = 0, repeated_ = -1;
  std::vector<Index> table_;          ///< rank by number, from first_; empty where the numbers are sparse
  std::vector<std::int64_t> sorted_;  ///< the numbers in ascending order where they are sparse
};

}  // namespace tetune

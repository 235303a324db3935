// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "star_forest.hpp"

namespace tetune::mpi {

/// The ranks that have a copy of an entity, for the entities whose owner rank is this one.
class Holders {
 public:
  Holders(const StarForest& star, const Blocks& blocks, int rank) : first_(blocks.begin(rank)) {
    begin_.push_back(0);
    for (const int n : star.copies()) begin_.push_back(begin_.back() + std::size_t(n));
    ranks_.resize(begin_.back());
    std::vector<std::size_t> next = begin_;
    star.for_each_copy([&](int holder, std::size_t place) { ranks_[next[place]++] = holder; });
  }
  /// Calls f(rank) for each rank that has a copy.
  template <class F>
  void for_each(Id id, F f) const {
    const std::size_t place(id - first_);
    for (std::size_t i = begin_[place]; i < begin_[place + 1]; ++i) f(ranks_[i]);
  }

 private:
  Id first_;
  std::vector<std::size_t> begin_;
  std::vector<int> ranks_;
};

}  // namespace tetune::mpi

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "backend/span.hpp"
#include "tetune/types.hpp"

namespace tetune {

/// A partition that is refined set by set: each class is a combination of sets.
template <class Member>
class Combinations {
 public:
  Combinations() : combinations_(1) {}
  /// Returns the combination with one more member, which exists from then on.
  Index with(Index combination, const Member& member) {
    const auto [at, is_new] = next_.try_emplace({combination, member}, to_index(combinations_.size()));
    if (is_new) {
      std::vector<Member> more = span_of(combinations_)[combination];
      more.push_back(member);
      combinations_.push_back(std::move(more));
    }
    return at->second;
  }
  const std::vector<Member>& of(Index combination) const { return span_of(combinations_)[combination]; }
  std::size_t size() const { return combinations_.size(); }

 private:
  std::vector<std::vector<Member>> combinations_;  ///< the first is empty
  std::map<std::pair<Index, Member>, Index> next_;
};

}  // namespace tetune

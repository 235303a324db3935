// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
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
  /// The combination with one more member.
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

/// Numbers combinations by the names of their members where these have numbers, as Volume50 with the start "Volume",
/// else from 1. The first, empty one gets 0, as do those that do not occur.
std::vector<int> number_inp_tags(const std::vector<std::vector<std::string>>& names, const std::vector<bool>& occurs,
                                 const char* start);

/// Whether number_inp_tags() gives this tag by this name.
bool is_inp_tag_name(const std::string& name, const char* start, int tag);

}  // namespace tetune

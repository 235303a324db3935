// SPDX-License-Identifier: Apache-2.0
#include "io/inp/inp_tags.hpp"

#include <cstdint>
#include <limits>
#include <optional>
#include <set>

#include "io/inp/inp_format.hpp"

namespace tetune {
namespace {

/// The number in a name like Volume50, as tetune and Gmsh write them for tags.
std::optional<int> tag_in_name(const std::string& name, const char* start) {
  const std::string key = inp_name(name);
  const std::string prefix = inp_name(start);
  std::int64_t value = 0;
  if (!key.starts_with(prefix) || !parse_inp_integer(key.substr(prefix.size()), value)) return {};
  if (value == 0 || value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max()) return {};
  return int(value);
}

}  // namespace

std::vector<int> number_inp_tags(const std::vector<std::vector<std::string>>& names, const std::vector<bool>& occurs,
                                 const char* start) {
  std::vector<int> tags(names.size(), 0);
  std::set<int> taken;
  for (std::size_t c = 1; c < names.size(); ++c) {
    std::set<int> numbers;
    for (const std::string& name : names[c]) {
      if (const std::optional<int> number = tag_in_name(name, start)) numbers.insert(*number);
    }
    if (occurs[c] && numbers.size() == 1 && taken.insert(*numbers.begin()).second) tags[c] = *numbers.begin();
  }
  int next = 1;
  for (std::size_t c = 1; c < names.size(); ++c) {
    if (!occurs[c] || tags[c] != 0) continue;
    while (!taken.insert(next).second) ++next;
    tags[c] = next;
  }
  return tags;
}

bool is_inp_tag_name(const std::string& name, const char* start, int tag) { return tag_in_name(name, start) == tag; }

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "io/unv/unv_tags.hpp"

#include <limits>
#include <set>
#include <utility>

#include "backend/span.hpp"
#include "io/tag_numbers.hpp"

namespace tetune {
namespace {

bool is_tag(std::int64_t number) { return number > 0 && number <= std::numeric_limits<int>::max(); }

/// Sets the tags of the classes of one dimension.
void number_dimension(const std::vector<UnvClass>& classes, const std::vector<std::int64_t>& group_numbers,
                      std::map<UnvClass, int>& class2tag) {
  std::map<int, int> property2classes;
  for (const UnvClass& c : classes) ++property2classes[c.property];
  std::set<int> in_use;
  const auto give = [&](const UnvClass& c, int tag) { return in_use.insert(tag).second && (class2tag[c] = tag, true); };
  std::vector<const UnvClass*> rest, last;
  for (const UnvClass& c : classes) {
    if (property2classes[c.property] == 1) {
      give(c, c.property);
    } else {
      rest.push_back(&c);
    }
  }
  for (const bool is_grouped : {true, false}) {
    for (const UnvClass* const c : rest) {
      if (c->groups.empty() == is_grouped) continue;
      const std::int64_t number = c->groups.size() == 1 ? span_of(group_numbers)[c->groups[0]] : 0;
      const bool has_own = is_grouped ? is_tag(number) && give(*c, int(number)) : give(*c, c->property);
      if (!has_own) last.push_back(c);
    }
  }
  // The other tags are no numbers of properties or groups, which they would be taken for.
  for (const UnvClass& c : classes) in_use.insert(c.property);
  for (const std::int64_t number : group_numbers) {
    if (is_tag(number)) in_use.insert(int(number));
  }
  FreeNumbers free_numbers(std::move(in_use));
  for (const UnvClass* const c : last) class2tag[*c] = free_numbers.take_lowest();
}

/// Whether a group is named for its only tag, as the writer names the groups of tags.
bool is_named_for_tag(const Group& group) {
  return group.tags.size() == 1 &&
         group.name == kUnvTagNames[to_size_t(group.dimension)] + std::to_string(group.tags[0]);
}

/// Finds the groups of tags to which the writer gave other numbers than the tags, as other groups have these: the
/// lowest free ones. `own`: the numbers of the groups in the file.
std::vector<std::uint8_t> find_displaced(const std::vector<Group>& groups, const std::vector<std::int64_t>& own) {
  std::vector<std::uint8_t> is_displaced(groups.size(), 0);
  const std::set<std::int64_t> of_file(own.begin(), own.end());
  std::set<std::int64_t> displaced;
  std::set<int> others;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const bool is_other = !is_named_for_tag(groups[i]) || own[i] == groups[i].tags[0];
    if (!is_other && of_file.contains(groups[i].tags[0])) {
      is_displaced[i] = 1;
      displaced.insert(own[i]);
    } else if (is_tag(own[i])) {
      others.insert(int(own[i]));
    }
  }
  FreeNumbers free_numbers(std::move(others));
  for (const std::int64_t number : displaced) {
    if (number != free_numbers.take_lowest()) return std::vector<std::uint8_t>(groups.size(), 0);
  }
  return is_displaced;
}

}  // namespace

std::map<UnvClass, int> tags_of_unv_classes(const std::vector<UnvClass>& classes,
                                            const std::vector<std::int64_t>& group_numbers) {
  std::map<UnvClass, int> class2tag;
  for (int dimension = 1; dimension <= 3; ++dimension) {
    std::vector<UnvClass> of_dimension;
    for (const UnvClass& c : classes) {
      if (c.dimension == dimension) of_dimension.push_back(c);
    }
    number_dimension(of_dimension, group_numbers, class2tag);
  }
  return class2tag;
}

std::size_t count_changed_properties(const std::map<UnvClass, int>& class2tag) {
  std::size_t all_changed = 0;
  for (int dimension = 1; dimension <= 3; ++dimension) {
    std::set<int> properties;
    std::size_t changed = 0;
    for (const auto& [c, tag] : class2tag) {
      if (c.dimension != dimension) continue;
      properties.insert(c.property);
      if (tag != c.property) ++changed;
    }
    if (properties.size() > 1) all_changed += changed;
  }
  return all_changed;
}

std::vector<Group> unv_groups(const std::map<UnvClass, int>& class2tag, const std::vector<std::string>& names,
                              const std::vector<std::int64_t>& numbers) {
  std::map<std::pair<std::int32_t, int>, std::set<int>> tags;  // by group and dimension
  for (const auto& [c, tag] : class2tag) {
    for (const std::int32_t group : c.groups) tags[{group, c.dimension}].insert(tag);
  }
  std::vector<Group> groups;
  std::vector<std::int64_t> own;
  for (const auto& [key, of] : tags) {
    groups.push_back({key.second, 0, span_of(names)[key.first], {of.begin(), of.end()}});
    own.push_back(span_of(numbers)[key.first]);
  }
  const std::vector<std::uint8_t> is_displaced = find_displaced(groups, own);
  std::array<std::set<int>, 4> in_use;
  const auto number = [&](Group& group, std::int64_t sought) {
    if (group.number != 0 || !is_tag(sought)) return;
    if (in_use[to_size_t(group.dimension)].insert(int(sought)).second) group.number = int(sought);
  };
  for (std::size_t i = 0; i < groups.size(); ++i) number(groups[i], is_displaced[i] != 0 ? 0 : own[i]);
  for (std::size_t i = 0; i < groups.size(); ++i) number(groups[i], is_displaced[i] != 0 ? groups[i].tags[0] : 0);
  for (std::size_t i = 0; i < groups.size(); ++i) number(groups[i], own[i]);
  std::array<FreeNumbers, 4> free_numbers{FreeNumbers(in_use[0]), FreeNumbers(in_use[1]), FreeNumbers(in_use[2]),
                                          FreeNumbers(in_use[3])};
  for (Group& group : groups) {
    if (group.number == 0) group.number = free_numbers[to_size_t(group.dimension)].take_lowest();
  }
  return groups;
}

}  // namespace tetune

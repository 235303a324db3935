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
  std::array<std::set<int>, 4> in_use;
  const auto is_of_tag = [&](std::int32_t group, int dimension, const std::set<int>& of) {
    return of.size() == 1 && span_of(names)[group] == kUnvTagNames[to_size_t(dimension)] + std::to_string(*of.begin());
  };
  std::vector<Group> groups;
  for (const auto& [key, of] : tags) {
    const auto& [group, dimension] = key;
    Group& added = groups.emplace_back(Group{dimension, 0, span_of(names)[group], {of.begin(), of.end()}});
    // The group of one tag has its number: other formats have the number of a group as the tag.
    if (is_of_tag(group, dimension, of) && in_use[to_size_t(dimension)].insert(*of.begin()).second) {
      added.number = *of.begin();
    }
  }
  auto added = groups.begin();
  for (const auto& [key, of] : tags) {
    const std::int64_t number = span_of(numbers)[key.first];
    if (added->number == 0 && is_tag(number) && in_use[to_size_t(key.second)].insert(int(number)).second) {
      added->number = int(number);
    }
    ++added;
  }
  std::array<FreeNumbers, 4> free_numbers{FreeNumbers(in_use[0]), FreeNumbers(in_use[1]), FreeNumbers(in_use[2]),
                                          FreeNumbers(in_use[3])};
  for (Group& group : groups) {
    if (group.number == 0) group.number = free_numbers[to_size_t(group.dimension)].take_lowest();
  }
  return groups;
}

}  // namespace tetune

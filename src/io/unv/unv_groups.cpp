// SPDX-License-Identifier: Apache-2.0
#include "io/unv/unv_groups.hpp"

#include <algorithm>
#include <set>

#include "backend/span.hpp"
#include "io/losses.hpp"
#include "io/plain_text.hpp"
#include "io/tag_numbers.hpp"
#include "io/unv/unv_format.hpp"
#include "io/unv/unv_tags.hpp"
#include "mesh/node_sets.hpp"

namespace tetune {
namespace {

class UnvGroupWriter {
 public:
  UnvGroupWriter(const TetMesh& mesh, const std::array<std::map<int, int>, 4>& properties, const IoContext& context)
      : mesh_(mesh), properties_(properties), context_(context) {}

  std::vector<UnvWrittenGroup> groups() {
    add_groups();
    add_node_sets();
    renamed_.warn(context_);
    const std::size_t named = list_.size();
    add_groups_of_tags();
    number(named);
    return std::move(list_);
  }

 private:
  static std::string name_of(int dimension, int number) {
    return kUnvTagNames[to_size_t(dimension)] + std::to_string(number);
  }

  /// Whether add_groups_of_tags() adds the group.
  bool is_of_tag(const Group& group, const std::string& name) const {
    const std::map<int, int>& tag2number = properties_[to_size_t(group.dimension)];
    const auto number = group.tags.size() == 1 ? tag2number.find(group.tags[0]) : tag2number.end();
    return number != tag2number.end() && name == name_of(group.dimension, number->second);
  }

  void add_groups() {
    const std::vector<const Group*> empty = empty_groups(mesh_);
    for (const Group& group : mesh_.groups) {
      if (group.dimension < 1) continue;
      if (std::binary_search(empty.begin(), empty.end(), &group)) {
        if (!group.name.empty()) warn_of_empty_group(group, context_);
        continue;
      }
      const std::string name = group.name.empty() ? name_of(group.dimension, group.number) : group.name;
      if (is_of_tag(group, name)) {
        tag2number_.emplace(std::pair{group.dimension, group.tags[0]}, group.number);
        continue;
      }
      UnvWrittenGroup& added = group_of(group.number, name);
      for (const int tag : group.tags) {
        added.tags.emplace_back(group.dimension, tag);
        grouped_.emplace(group.dimension, tag);
      }
    }
  }
  void add_node_sets() {
    for (const DataArray& array : mesh_.point_data) {
      if (!is_node_set(array)) continue;
      // An empty set is for example one of mid-side nodes, of which the reader has warned.
      const auto& in_set = std::get<std::vector<std::uint8_t>>(array.values);
      if (std::find(in_set.begin(), in_set.end(), std::uint8_t{1}) == in_set.end()) continue;
      const std::string text = array.name.substr(kNodeSet.size());
      const std::size_t colon = text.find(':');
      const int number = leading_unv_integer(text);
      UnvWrittenGroup* added = &group_of(number, colon == std::string::npos ? "" : text.substr(colon + 1));
      if (added->in_set != nullptr) added = &list_.emplace_back(UnvWrittenGroup{number, added->name, {}, nullptr});
      added->in_set = &in_set;
    }
  }
  /// Adds a group for each tag that is in none or only in one that is named for it: programs that do not read the
  /// numbers of properties, such as Salome, find the elements of a tag by its group.
  void add_groups_of_tags() {
    for (int dimension = 3; dimension > 0; --dimension) {
      for (const auto& [tag, property] : properties_[to_size_t(dimension)]) {
        const std::pair<int, int> key{dimension, tag};
        const auto known = tag2number_.find(key);
        if (known == tag2number_.end() && (tag == 0 || grouped_.contains(key))) continue;
        const int number = known == tag2number_.end() ? property : known->second;
        list_.push_back({number, name_of(dimension, property), {{dimension, tag}}, nullptr});
      }
    }
  }

  /// Returns the group of a number and name, which is added if there is none.
  UnvWrittenGroup& group_of(int number, const std::string& name) {
    std::string written = without_control_characters(trimmed(name));
    const auto [at, is_new] = positions_.try_emplace({number, written}, list_.size());
    if (!is_new) return list_[at->second];
    renamed_.add(name, written);
    return list_.emplace_back(UnvWrittenGroup{number, std::move(written), {}, nullptr});
  }

  /// Gives each group a number that no other has. The first `named` ones have those of the mesh where they can.
  void number(std::size_t named) {
    FreeNumbers numbers({});
    std::vector<UnvWrittenGroup*> rest;
    std::size_t changed = 0;
    for (std::size_t i = 0; i < list_.size(); ++i) {
      if (list_[i].number > 0 && numbers.take(list_[i].number)) continue;
      rest.push_back(&list_[i]);
      if (i < named) ++changed;
    }
    for (UnvWrittenGroup* const group : rest) group->number = numbers.take_lowest();
    if (changed == 0) return;
    context_.warn(std::to_string(changed) + " groups get other numbers: those of all dimensions and of sets of nodes " +
                  "differ in this format, and are at most 2147483647");
  }

  const TetMesh& mesh_;
  const std::array<std::map<int, int>, 4>& properties_;
  const IoContext& context_;
  std::vector<UnvWrittenGroup> list_;
  RenamedGroups renamed_;
  std::map<std::pair<int, std::string>, std::size_t> positions_;  ///< in list_, by number and name
  std::set<std::pair<int, int>> grouped_;                         ///< dimensions and tags
  /// The numbers of the groups of the mesh that add_groups_of_tags() adds, by dimension and tag.
  std::map<std::pair<int, int>, int> tag2number_;
};

}  // namespace

std::vector<UnvWrittenGroup> unv_groups_to_write(const TetMesh& mesh,
                                                 const std::array<std::map<int, int>, 4>& properties,
                                                 const IoContext& context) {
  return UnvGroupWriter(mesh, properties, context).groups();
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "io/msh/msh_model.hpp"

#include <algorithm>
#include <set>

#include "backend/span.hpp"

namespace tetune {
namespace {

using Key = std::vector<Index>;

/// Appends the elements of `from` with keep[e] != 0 to a list.
MshElements kept(const MshElements& from, const std::vector<std::uint8_t>& keep, std::size_t corners) {
  MshElements to;
  for (std::size_t e = 0; e < keep.size(); ++e) {
    if (keep[e] == 0) continue;
    const auto first = from.corners.begin() + std::ptrdiff_t(e * corners);
    to.corners.insert(to.corners.end(), first, first + std::ptrdiff_t(corners));
    to.cell.push_back(from.cell[e]);
    to.number.push_back(from.number[e]);
    if (e < from.has_middles.size()) to.has_middles.push_back(from.has_middles[e]);
  }
  return to;
}

/// The cells of the same entity and partition, by their groups.
class CellsByGroups {
 public:
  explicit CellsByGroups(std::vector<MshCell>& cells) : cells_(cells) {
    for (std::size_t c = 0; c < cells.size(); ++c) {
      cell_of_.try_emplace(key(cells[c], cells[c].groups), to_index(c));
      ++count_[key(cells[c], {})];
    }
  }
  /// Whether the entity of the cell has others, with other groups.
  bool is_split(const MshCell& cell) const { return count_.at(key(cell, {})) > 1; }
  /// The cell of the same entity with these groups.
  Index with_groups(const MshCell& cell, std::vector<int> groups) {
    const auto [at, is_new] = cell_of_.try_emplace(key(cell, groups), to_index(cells_.size()));
    if (is_new) {
      MshCell more = cell;
      more.groups = std::move(groups);
      cells_.push_back(std::move(more));
    }
    return at->second;
  }

 private:
  using EntityKey = std::pair<std::array<int, 3>, std::vector<int>>;
  static EntityKey key(const MshCell& cell, const std::vector<int>& groups) {
    return {{cell.dimension, cell.entity, cell.partition}, groups};
  }
  std::vector<MshCell>& cells_;
  std::map<EntityKey, Index> cell_of_;
  std::map<EntityKey, int> count_;
};

/// Joins the repeated elements of one list.
void join(MshElements& list, std::size_t corners, const std::vector<std::uint8_t>& is_split, CellsByGroups& by_groups,
          std::vector<MshCell>& cells) {
  std::map<std::pair<Key, int>, Index> first_of;  // by vertices and entity
  std::map<Index, std::set<int>> groups_of;       // of the first element
  std::vector<std::uint8_t> keep(list.cell.size(), 1);
  for (std::size_t e = 0; e < keep.size(); ++e) {
    if (span_of(is_split)[list.cell[e]] == 0) continue;
    const MshCell& cell = cells[to_size_t(list.cell[e])];
    const auto first = list.corners.begin() + std::ptrdiff_t(e * corners);
    const auto [at, is_new] =
        first_of.try_emplace({Key(first, first + std::ptrdiff_t(corners)), cell.entity}, to_index(e));
    groups_of[at->second].insert(cell.groups.begin(), cell.groups.end());
    keep[e] = is_new ? 1 : 0;
  }
  for (const auto& [element, groups] : groups_of) {
    Index& cell = span_of(list.cell)[element];
    const MshCell old = span_of(cells)[cell];
    cell = by_groups.with_groups(old, {groups.begin(), groups.end()});
  }
  list = kept(list, keep, corners);
}

}  // namespace

void find_dimensions_of_names(MshModel& model) {
  std::set<std::pair<int, int>> in_use;  // dimensions and numbers of groups
  for (const MshCell& cell : model.cells) {
    for (const int group : cell.groups) in_use.emplace(cell.dimension, group);
  }
  std::vector<MshName> names;
  for (const MshName& name : model.names) {
    if (name.dimension != kMshAnyDimension) {
      names.push_back(name);
      continue;
    }
    for (int dimension = 0; dimension <= 3; ++dimension) {
      if (in_use.contains({dimension, name.number})) names.push_back({dimension, name.number, name.name});
    }
  }
  model.names = std::move(names);
}

void join_repeated_elements(MshModel& model) {
  CellsByGroups by_groups(model.cells);
  std::vector<std::uint8_t> is_split;
  for (const MshCell& cell : model.cells) is_split.push_back(by_groups.is_split(cell) ? 1 : 0);
  if (std::find(is_split.begin(), is_split.end(), 1) == is_split.end()) return;
  for (std::size_t list = 0; list < kMshLists; ++list) {
    const auto corners = to_size_t(msh_type_of(list).corners);
    join(model.elements[list], corners, is_split, by_groups, model.cells);
  }
  for (MshCell& cell : model.cells) cell.is_dropped = true;
  for (const MshElements& list : model.elements) {
    for (const Index cell : list.cell) span_of(model.cells)[cell].is_dropped = false;
  }
}

}  // namespace tetune

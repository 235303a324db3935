// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "io/msh_format.hpp"
#include "io/registry.hpp"
#include "tetune/mesh.hpp"

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
  /// The positions in the list in ascending order of the numbers.
  const std::vector<Index>& order() const { return order_; }
  /// A number that occurs twice, or -1.
  std::int64_t repeated() const { return repeated_; }

 private:
  Index search(std::int64_t number) const;
  std::vector<Index> order_;
  std::int64_t first_ = 0, repeated_ = -1;
  std::vector<Index> table_;          ///< rank by number, from first_; empty where the numbers are sparse
  std::vector<std::int64_t> sorted_;  ///< otherwise
};

/// Elements of one entity and partition that are in the same physical groups.
struct MshCell {
  int dimension = 0;
  int entity = 0;
  int partition = 0;        ///< from 1; 0: none
  std::vector<int> groups;  ///< positive, ascending
  bool is_dropped = false;  ///< its elements are not kept (interfaces of partitions), or there are none
};

/// The elements of one list: corners, cell and number of each.
struct MshElements {
  std::vector<Index> corners;
  std::vector<Index> cell;
  std::vector<std::int64_t> number;
};

/// An entry of $PhysicalNames.
struct MshName {
  int dimension, number;
  std::string name;
};

/// Data on nodes or elements: one step of a view.
struct MshView {
  std::string name;
  bool on_nodes = false;
  int step = 0;
  int components = 1;
  std::vector<std::int64_t> numbers;
  std::vector<double> values;
  bool has_more_steps = false;
};

/// The contents of an .msh file.
struct MshModel {
  std::string dialect;
  std::vector<Point3> points;
  NumberIndex nodes;
  std::array<MshElements, kMshLists> elements;
  std::vector<MshCell> cells;
  std::vector<MshName> names;
  std::map<std::pair<int, int>, int> loose_tags;  ///< of entities in no group, by dimension and entity
  std::vector<PeriodicLink> periodic;
  std::vector<MshView> views;
  std::vector<Middle> middles;
};

/// Joins elements that version 2.2 lists once for each of their groups.
void join_repeated_elements(MshModel& model);

/// Makes a mesh of the contents: tags, groups, data. The texts of warnings name no file.
TetMesh mesh_of(MshModel model, const IoContext& context);

}  // namespace tetune

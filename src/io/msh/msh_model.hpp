// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "io/msh/msh_format.hpp"
#include "io/number_index.hpp"
#include "io/registry.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

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
  /// 1 for an edge, triangle or tetrahedron with mid-side nodes; shorter where the last ones have none.
  std::vector<std::uint8_t> has_middles;
};

/// MshName::dimension of a name that is for the groups of its number of all dimensions.
inline constexpr int kMshAnyDimension = -1;

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
  MiddleList middles;
  bool has_ghosts = false;  ///< elements of version 2.2 are ghosts in further partitions
};

/// Gives names without a dimension those of the elements in groups of their number.
void find_dimensions_of_names(MshModel& model);

/// Joins elements that version 2.2 lists once for each of their groups.
void join_repeated_elements(MshModel& model);

/// Makes a mesh of the contents: tags, groups, data. The texts of warnings name no file.
TetMesh mesh_of(MshModel model, const IoContext& context);

}  // namespace tetune

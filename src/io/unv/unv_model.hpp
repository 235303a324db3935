// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "io/unv/unv_elements.hpp"
#include "io/unv/unv_lines.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// An element whose nodes are not resolved.
struct UnvElement {
  const UnvElementKind* kind;
  std::int64_t line, number;
  std::size_t first_node;  ///< position in UnvModel::element_nodes
  int property, material;
  std::uint8_t nodes;
};

/// A group of nodes and elements, by their numbers.
struct UnvGroup {
  std::int64_t number;
  std::string name;
  std::vector<std::int64_t> nodes, elements;
};

/// The contents of a universal file.
struct UnvModel {
  std::vector<std::int64_t> node_numbers, node_lines;
  std::vector<Point3> points;
  std::vector<UnvElement> elements;
  std::vector<std::int64_t> element_nodes;
  std::vector<UnvGroup> groups;
  bool has_groups_of_gmsh = false;  ///< groups are in the data set that Gmsh writes
  /// The lines of the data set of units, each with the end of a line.
  std::string units;

  /// Numbers of data sets that are not read, in their order.
  std::vector<std::string> ignored_sets;
  std::map<std::int64_t, std::size_t> ignored_elements;  ///< number of elements by descriptor
  std::size_t beams_with_sections = 0, ignored_members = 0;
};

/// Reads data sets of nodes, elements, groups, units and coordinate systems. Throws FileError; `warnings` gets those of
/// coordinate systems, without the path.
UnvModel read_unv_model(UnvLines& lines, std::vector<std::string>& warnings);

}  // namespace tetune

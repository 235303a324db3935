// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "io/io_context.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// A group to be written: the elements of some tags, and a set of nodes.
struct UnvWrittenGroup {
  int number = 0;
  std::string name;
  std::vector<std::pair<int, int>> tags;              ///< dimensions and tags
  const std::vector<std::uint8_t>* in_set = nullptr;  ///< 1 per vertex of the set; null: none
};

/// The groups of a mesh, its sets of nodes, and a group for each tag in none; `properties`: the number of each tag, by
/// dimension. Groups and sets of nodes with the same number and name are one.
std::vector<UnvWrittenGroup> unv_groups_to_write(const TetMesh& mesh,
                                                 const std::array<std::map<int, int>, 4>& properties,
                                                 const IoContext& context);

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "io/second_order.hpp"
#include "plugin.hpp"

namespace tetune::plugin {

/// The elements of one kind and tag, which become a block.
struct OutBlock {
  int id;
  std::size_t kind;  ///< position in kKinds
  int dimension;
  int tag;
  std::vector<int> nodes;             ///< from 1
  std::vector<std::size_t> elements;  ///< positions in the mesh's list of the kind
};

/// A set of sides of elements, of triangles with one tag; or a set of nodes.
struct OutSet {
  int id = 0;
  int tag = 0;
  std::string name{};
  std::vector<int> entries{};  ///< elements or nodes, from 1
  std::vector<int> sides{};    ///< of the elements, from 1
};

/// The elements of a mesh as Exodus has them.
struct ExodusElements {
  std::vector<OutBlock> blocks;
  std::vector<OutSet> side_sets;  ///< without names
};

/// `middles`: of a mesh of second order, else null. Warns of tags that are not the numbers of their blocks and sets.
ExodusElements exodus_elements(const TetMesh& mesh, const Middles* middles, Warnings& warnings);

}  // namespace tetune::plugin

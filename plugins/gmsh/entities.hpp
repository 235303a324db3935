// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "gmsh_mesh.hpp"
#include "io/second_order.hpp"

namespace tetune::plugin {

/// The elements of one kind, to be written by Gmsh.
struct Kind {
  int dimension;
  int type;
  std::size_t corners;  ///< number of vertices of an element, without middle nodes
  std::vector<Index> element2vertex;
  const std::vector<int>* tags;
  const std::vector<DataArray>* data;
  std::vector<Pair> middles;
  std::vector<int> entities;
  std::size_t first_element = 0;  ///< number of the first one
  std::size_t size() const { return tags->size(); }
};

/// The elements of a mesh by kind.
std::vector<Kind> kinds_of(const TetMesh& mesh);

/// Assigns the elements of each tag of a dimension to an entity of Gmsh with the number of the tag; where that is not
/// possible, with minus that number, or with a free one. Returns the entities with their tags.
std::map<int, int> find_entities(std::vector<Kind>& kinds, int dimension, const std::vector<Group>& groups);

/// For each entity of a dimension the entities of the dimension below that share a side with it.
class Boundaries {
 public:
  Boundaries(const std::vector<Kind>& kinds, int dimension, std::size_t vertices);
  std::vector<int> of(int entity) const;

 private:
  std::map<int, std::set<int>> entity2sides_;
};

}  // namespace tetune::plugin

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "io/msh/msh_format.hpp"
#include "io/registry.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// The elements of one kind, to be written to an .msh file.
struct MshKind {
  const MshType* type;
  const Index* element2vertex;  ///< TetMesh's, without middle nodes
  const std::vector<int>* tags;
  const std::vector<DataArray>* data;
  std::vector<Index> entity{};  ///< position in MshLayout::entities, per element
  std::int64_t first_number = 1;
  std::size_t size() const { return tags->size(); }
  const Index* corners(std::size_t element) const { return element2vertex + element * to_size_t(type->corners); }
};

/// An entity to be written.
struct MshLayoutEntity {
  int dimension;
  int number;
  int tag;  ///< of its elements
  std::vector<int> groups{};
  std::vector<int> bounds{};  ///< numbers of the entities of the dimension below that share a side with it
  std::array<double, 6> box{};
  bool has_elements = true;  ///< false: only a periodic link names it
};

/// The elements, entities and groups of a mesh as an .msh file has them.
struct MshLayout {
  std::vector<MshKind> kinds;             ///< from the lowest dimension up
  std::vector<MshLayoutEntity> entities;  ///< ascending in dimension and number
  std::vector<Group> names;               ///< named groups
  std::vector<PeriodicLink> links;        ///< those of entities that the mesh still has
  /// The position of an entity that is in the list.
  Index find(int dimension, int number) const;
};

/// Assigns elements to entities and groups. The entities are those that the elements came from where they are known;
/// else each tag is one.
MshLayout lay_out(const TetMesh& mesh, const IoContext& context);

}  // namespace tetune

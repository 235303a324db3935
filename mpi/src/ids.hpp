// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tetune/types.hpp"

namespace tetune::mpi {

/// The number of a vertex or an element in the whole mesh.
using Id = std::int64_t;

/// A flag per vertex or element.
using Marks = std::vector<std::uint8_t>;

/// Entry i of a list, for the signed indices of meshes.
template <class List, class Integer>
decltype(auto) item(List& list, Integer i) {
  return list[static_cast<std::size_t>(i)];
}
/// The length of a list, or a position in one, as an index of a mesh, which is below 2^31.
template <class List>
Index index_count(const List& list) {
  return static_cast<Index>(list.size());
}
template <class List>
int int_size(const List& list) {
  return static_cast<int>(list.size());
}
inline Index to_index(std::size_t i) { return static_cast<Index>(i); }

/// The map from ids of the whole mesh to indices of a part.
class IdMap {
 public:
  IdMap() : slots_(16) {}
  explicit IdMap(const std::vector<Id>& ids);
  /// Returns -1 for an id that the map does not have.
  Index operator[](Id id) const { return slots_[find_slot(id)].index; }
  /// Gives the next index to an id that the map does not have; returns whether it did.
  bool add(Id id);

 private:
  struct Slot {
    Id id = -1;
    Index index = -1;
  };
  /// The slot of the id, or the free one for it.
  std::size_t find_slot(Id id) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = (std::uint64_t(id) * 0x9E3779B97F4A7C15U) >> 20U & mask;
    while (slots_[slot].index >= 0 && slots_[slot].id != id) slot = (slot + 1) & mask;
    return slot;
  }
  std::vector<Slot> slots_;  ///< their number is a power of two
  std::size_t count_ = 0;
};

}  // namespace tetune::mpi

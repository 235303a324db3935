// SPDX-License-Identifier: Apache-2.0
#include "ids.hpp"

#include <bit>
#include <utility>

namespace tetune::mpi {

IdMap::IdMap(const std::vector<Id>& ids) : slots_(std::bit_ceil(2 * ids.size() + 2)) {
  for (const Id id : ids) add(id);
}

bool IdMap::add(Id id) {
  std::size_t slot = find_slot(id);
  if (slots_[slot].index >= 0) return false;
  if (2 * (count_ + 1) > slots_.size()) {
    const std::vector<Slot> old = std::exchange(slots_, std::vector<Slot>(2 * slots_.size()));
    for (const Slot& s : old) {
      if (s.index >= 0) slots_[find_slot(s.id)] = s;
    }
    slot = find_slot(id);
  }
  slots_[slot] = {id, to_index(count_++)};
  return true;
}

}  // namespace tetune::mpi

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "mesh/tet.hpp"

namespace tetune {

/// A set of at most kCapacity ids in the memory of a thread; each id has a position, in the order of insertion.
template <int kCapacity>
class SmallSet {
 public:
  static constexpr int kAbsent = -1;
  TETUNE_HD int size() const { return size_; }
  TETUNE_HD Index operator[](int position) const { return items_[position]; }
  /// The position of an id, or kAbsent.
  TETUNE_HD int find(Index item) const {
    const int first = slots_[slot_of(item)];
    if (first == 0) return kAbsent;
    if (items_[first - 1] == item) return first - 1;
    for (int i = 0; i < size_; ++i) {
      if (items_[i] == item) return i;
    }
    return kAbsent;
  }
  /// Inserts an id that is not in the set; returns its position, or kAbsent where the set is full.
  TETUNE_HD int add(Index item) {
    if (size_ == kCapacity) return kAbsent;
    items_[size_] = item;
    std::uint8_t& slot = slots_[slot_of(item)];
    if (slot == 0) slot = static_cast<std::uint8_t>(size_ + 1);
    return size_++;
  }

 private:
  static constexpr int kSlots = 256;
  static_assert(kCapacity < kSlots);
  TETUNE_HD static unsigned slot_of(Index item) { return static_cast<unsigned>(item) % kSlots; }
  Index items_[kCapacity];
  std::uint8_t slots_[kSlots] = {};  ///< per hash: 1 + the position of its first id; 0: none
  int size_ = 0;
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "mesh/tet.hpp"

namespace tetune {

/// A set of at most kCapacity ids, which one thread changes; each id has a position, in the order of insertion. A hash
/// table with open addressing and linear probing (Knuth, "The Art of Computer Programming", vol. 3, sec. 6.4).
template <int kCapacity>
class SmallSet {
 public:
  static constexpr int kAbsent = -1;
  TETUNE_HD void clear() {
    for (std::uint64_t& slots : slots_) slots = 0;
    size_ = 0;
  }
  TETUNE_HD int size() const { return size_; }
  TETUNE_HD bool is_full() const { return size_ == kCapacity; }
  TETUNE_HD Index operator[](int position) const { return items_[position]; }
  /// The position of an id, or kAbsent.
  TETUNE_HD int find(Index item) const { return entry(slot_of(item)) - 1; }
  TETUNE_HD bool contains(Index item) const { return entry(slot_of(item)) != 0; }
  /// Inserts an id that is not in the set; returns its position, or kAbsent where the set is full.
  TETUNE_HD int add(Index item) {
    if (is_full()) return kAbsent;
    const unsigned slot = slot_of(item);
    items_[size_] = item;
    slots_[slot / 8] |= static_cast<std::uint64_t>(++size_) << 8 * (slot % 8);
    return size_ - 1;
  }

 private:
  /// At least twice the capacity, so that probes are short.
  static constexpr unsigned kSlots = kCapacity <= 64 ? 128 : 256;
  static_assert(2 * kCapacity <= int{kSlots});

  /// 1 + the position of the id in a slot; 0: the slot is empty.
  TETUNE_HD int entry(unsigned slot) const { return static_cast<int>(slots_[slot / 8] >> 8 * (slot % 8) & 0xff); }
  /// The slot of an id, or the empty one where it would be.
  TETUNE_HD unsigned slot_of(Index item) const {
    unsigned slot = static_cast<unsigned>(item) % kSlots;
    while (entry(slot) != 0 && items_[entry(slot) - 1] != item) slot = (slot + 1) % kSlots;
    return slot;
  }

  Index items_[kCapacity];
  std::uint64_t slots_[kSlots / 8] = {};  ///< eight in a word: nvcc would clear an array of bytes one by one
  int size_ = 0;
};

/// Values of at most kCapacity ids.
template <class Value, int kCapacity>
class SmallMap {
 public:
  /// The value of an id; null where it has none.
  TETUNE_HD const Value* find(Index item) const {
    const int i = ids_.find(item);
    return i < 0 ? nullptr : &values_[i];
  }
  /// The value of an id, which make(value) sets where there was none; null where the map is full.
  template <class Make>
  TETUNE_HD Value* find_or_make(Index item, const Make& make) {
    int i = ids_.find(item);
    if (i < 0) {
      i = ids_.add(item);
      if (i < 0) return nullptr;
      make(values_[i]);
    }
    return &values_[i];
  }

 private:
  SmallSet<kCapacity> ids_;
  Value values_[kCapacity];
};

}  // namespace tetune

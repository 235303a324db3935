// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "core/work_mesh.hpp"
#include "par/atomic.hpp"

/// What flips and revisions of vertices share: offers, of which every tetrahedron keeps the best, and slots for what
/// is made.
namespace tetune {

/// Orders offers by gain, then by id: the lower id wins. The gain is rounded to single precision, so that what is
/// equally good but for round-off counts as equal. 0 is none.
TETUNE_HD inline std::uint64_t make_offer(double gain, std::uint32_t id) {
  const auto rounded = static_cast<float>(gain);
  std::uint32_t bits = 0;
  static_assert(sizeof bits == sizeof rounded);
  std::memcpy(&bits, &rounded, sizeof bits);
  return (static_cast<std::uint64_t>(bits) << 32) | ~id;
}
TETUNE_HD inline std::uint32_t offer_id(std::uint64_t offer) {
  return ~static_cast<std::uint32_t>(offer & 0xffffffffU);
}

/// Each of the tetrahedra keeps the best of what it is offered.
TETUNE_HD inline void offer_to(const Index* tets, int count, std::uint64_t offer, Span<std::uint64_t> best) {
  for (int k = 0; k < count; ++k) par::atomic_max(best[tets[k]], offer);
}
/// What is offered is agreed when all the tetrahedra hold it as their best (Stroeter et al. 2022, Alg. 5, lines 21 to
/// 33).
TETUNE_HD inline bool all_hold(const Index* tets, int count, std::uint64_t offer, Span<const std::uint64_t> best) {
  for (int k = 0; k < count; ++k) {
    if (best[tets[k]] != offer) return false;
  }
  return true;
}

/// What changes add up to, as a scan needs it.
struct SlotCounts {
  std::uint32_t takes = 0;  ///< slots
  std::uint32_t frees = 0;  ///< slots

  SlotCounts() = default;
  /// Of a cavity: tetrahedra before and after.
  TETUNE_HD SlotCounts(int before, int after)
      : takes(static_cast<std::uint32_t>(after > before ? after - before : 0)),
        frees(static_cast<std::uint32_t>(after < before ? before - after : 0)) {}
  TETUNE_HD friend SlotCounts operator+(SlotCounts x, const SlotCounts& y) { return x += y; }
  TETUNE_HD SlotCounts& operator+=(const SlotCounts& y) {
    takes += y.takes;
    frees += y.frees;
    return *this;
  }
};

/// How the slots change: free ones are taken first, from the end of their list, then new ones.
struct SlotChange {
  Size slots;       ///< before
  Size free_count;  ///< before
  Size free_kept;   ///< of these
  Size needed;      ///< slots afterwards
  Size freed;       ///< to be listed after those that are kept

  template <class Backend>
  SlotChange(const WorkMesh<Backend>& mesh, const SlotCounts& counts)
      : slots(mesh.slots()),
        free_count(mesh.free_count),
        free_kept(std::max<Size>(0, free_count - counts.takes)),
        needed(slots + std::max<Size>(0, counts.takes - free_count)),
        freed(counts.frees) {}

  template <class Backend>
  void make_room(WorkMesh<Backend>& mesh) const {
    mesh.tet2vertex.grow(needed);
    mesh.tet2tet.grow(needed);
    mesh.tet2original.grow(needed);
    mesh.free_slots.grow(std::max(free_count, free_kept + freed));
  }
  /// When all are placed.
  template <class Backend>
  void finish(WorkMesh<Backend>& mesh) const {
    mesh.free_count = free_kept + freed;
  }

  /// The slot for the tetrahedron of this rank among those that take one.
  TETUNE_HD Index taken(Span<const Index> free_slots, Size rank) const {
    return rank < free_count ? free_slots[free_count - 1 - rank] : static_cast<Index>(slots + rank - free_count);
  }
};

}  // namespace tetune

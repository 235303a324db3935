// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "mesh/work_mesh.hpp"
#include "tetune/error.hpp"

/// Slots of tetrahedra: how many a set of cavities takes and frees, and which.
namespace tetune {

/// Candidates of one tetrahedron: four faces, six edges.
inline constexpr int kCandidates = 10;
/// The maximum number of slots: ids of candidates, slot * kCandidates + candidate, have 32 bits.
inline constexpr Size kMaxSlots = (Size{1} << 32) / kCandidates;
static_assert(4 * kMaxSlots <= Size{kLocked}, "half-faces must be able to address all slots");

/// Candidates 0 to 3 of a tetrahedron are its faces, 4 to 9 its edges.
TETUNE_HD inline std::uint32_t candidate_id(Index t, int candidate) {
  return static_cast<std::uint32_t>(t) * kCandidates + static_cast<std::uint32_t>(candidate);
}

/// Throws MeshError when a mesh would need more slots than there can be.
inline void check_slots(Size needed) {
  if (needed <= kMaxSlots) return;
  throw MeshError("flips would need room for " + std::to_string(needed) + " tetrahedra; there can be at most " +
                  std::to_string(kMaxSlots) + ". Use a smaller mesh, or flips that add fewer (max_ring 3).");
}

/// The slots that cavities take and free, and the vertices and triangles that they make and remove; a scan adds them
/// up.
struct ChangeCounts {
  std::uint32_t taken = 0;  ///< slots
  std::uint32_t freed = 0;  ///< slots
  std::uint32_t inserted = 0;
  std::uint32_t removed = 0;
  std::uint32_t triangles = 0;  ///< of the surface that are made beyond those replaced

  TETUNE_HD void add_tets(int before, int after) {
    if (after > before) taken += static_cast<std::uint32_t>(after - before);
    if (after < before) freed += static_cast<std::uint32_t>(before - after);
  }
  TETUNE_HD friend ChangeCounts operator+(ChangeCounts x, const ChangeCounts& y) { return x += y; }
  TETUNE_HD ChangeCounts& operator+=(const ChangeCounts& y) {
    taken += y.taken;
    freed += y.freed;
    inserted += y.inserted;
    removed += y.removed;
    triangles += y.triangles;
    return *this;
  }
};

/// The slots for new tetrahedra: free ones are taken first, from the end of their list, then new ones.
struct FreeSlots {
  Span<const Index> free;
  Size slots;

  template <class Backend>
  explicit FreeSlots(const WorkMesh<Backend>& mesh)
      : free(mesh.free_slots.span().data(), mesh.free_count), slots(mesh.slots()) {}

  /// The slot for the tetrahedron of this rank among those that take one.
  TETUNE_HD Index slot_of(Size rank) const {
    return rank < free.size() ? free[free.size() - 1 - rank] : to_index(slots + rank - free.size());
  }
};

/// How the slots change.
struct SlotChange {
  Size slots;       ///< before
  Size free_count;  ///< before
  Size free_kept;   ///< entries of the list of free slots that remain
  Size needed;      ///< slots afterwards
  Size freed;       ///< appended to the entries that remain

  template <class Backend>
  SlotChange(const WorkMesh<Backend>& mesh, const ChangeCounts& counts)
      : slots(mesh.slots()),
        free_count(mesh.free_count),
        free_kept(std::max<Size>(0, free_count - counts.taken)),
        needed(slots + std::max<Size>(0, counts.taken - free_count)),
        freed(counts.freed) {}

  template <class Backend>
  void make_room(const Backend& backend, WorkMesh<Backend>& mesh) const {
    mesh.tet2vertex.grow(backend, needed);
    mesh.tet2tet.grow(backend, needed);
    mesh.tet2original.grow(backend, needed);
    mesh.free_slots.grow(backend, std::max(free_count, free_kept + freed));
  }
  /// Called after all tetrahedra are written.
  template <class Backend>
  void finish(WorkMesh<Backend>& mesh) const {
    mesh.free_count = free_kept + freed;
  }
};

}  // namespace tetune

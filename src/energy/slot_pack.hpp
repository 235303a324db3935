// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/criterion.hpp"
#include "energy/harmonic.hpp"
#include "mesh/gather.hpp"

namespace tetune {

/// kLanes consecutive slots and their vertices, one slot per lane. Lanes of free slots and beyond the last slot hold
/// valid but meaningless vertices.
template <class Pack>
class SlotPack {
 public:
  TETUNE_HD TETUNE_INLINE SlotPack(const RatedMesh& mesh, Size pack)
      : mesh_(mesh),
        first_(kLanes * pack),
        count_(mesh.tet2vertex.size() - first_ < kLanes ? mesh.tet2vertex.size() - first_ : kLanes) {
    for (int l = 0; l < kLanes; ++l) {
      const Tet tet = mesh.tet2vertex[first_ + (l < count_ ? l : 0)];
      alive_[l] = tet[0] != kFreeSlot;
      for (int k = 0; k < 4; ++k) ids_[k][l] = alive_[l] ? tet[k] : 0;
    }
  }
  TETUNE_HD TETUNE_INLINE static Size pack_count(Size slots) { return (slots + kLanes - 1) / kLanes; }

  TETUNE_HD TETUNE_INLINE Vec3T<Pack> corner(int k, Span<const Point> points) const {
    return gather<Pack>(points, ids_[k]);
  }
  TETUNE_HD TETUNE_INLINE TetEnergyT<Pack> energy() const {
    return tet_energy(mesh_.objective, corner(0, mesh_.points), corner(1, mesh_.points), corner(2, mesh_.points),
                      corner(3, mesh_.points));
  }
  /// Stores one value per slot, 0 for free slots, and returns the sum.
  TETUNE_HD TETUNE_INLINE Sum<double> store_and_sum(const Pack& values, Span<double> to) const {
    Sum<double> total;
    for_each([&](Size slot, int l) {
      to[slot] = alive_[l] ? lane(values, l) : 0;
      total.merge({to[slot]});
    });
    return total;
  }
  /// Calls f(slot, lane) for each slot of the pack.
  template <class F>
  TETUNE_HD TETUNE_INLINE void for_each(const F& f) const {
    for (int l = 0; l < count_; ++l) f(first_ + l, l);
  }

 private:
  static constexpr int kLanes = kLanesOf<Pack>;
  const RatedMesh& mesh_;
  Size first_;
  Size count_;
  bool alive_[kLanes];
  Index ids_[4][kLanes];
};

}  // namespace tetune

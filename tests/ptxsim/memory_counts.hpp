// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ptxsim/warp.hpp"

namespace tetune::ptxsim {

/// Counts the accesses of one instruction of a warp: at its end, when the spaces of all lanes are known.
class AccessCounter {
 public:
  /// `kind`: what it is for the lanes that access global memory. `bytes`: of each lane.
  AccessCounter(Warp& warp, u32 bytes, Kind kind) : warp_(warp), bytes_(bytes), kind_(kind) {}
  AccessCounter(const AccessCounter&) = delete;
  AccessCounter& operator=(const AccessCounter&) = delete;
  ~AccessCounter();

  void add(u32 lane, u64 address, Space space) {
    const LaneMask bit = LaneMask{1} << lane;
    if (space == Space::global) {
      global_ |= bit;
      addresses_[lane] = address;
    } else if (space == Space::local) {
      local_ |= bit;
    } else if (space == Space::shared) {
      shared_ |= bit;
    } else {
      other_ |= bit;
    }
  }

 private:
  void count(LaneMask mask, Kind kind);
  void count_sectors();

  Warp& warp_;
  u32 bytes_;
  Kind kind_;
  LaneMask global_ = 0, local_ = 0, shared_ = 0, other_ = 0;
  u64 addresses_[kLanes];
};

}  // namespace tetune::ptxsim

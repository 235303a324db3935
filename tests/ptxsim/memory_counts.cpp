// SPDX-License-Identifier: Apache-2.0
#include "ptxsim/memory_counts.hpp"

#include <algorithm>

#include "ptxsim/global_memory.hpp"

namespace tetune::ptxsim {

AccessCounter::~AccessCounter() {
  count(global_, kind_);
  count(local_, Kind::local);
  count(shared_, Kind::shared);
  count(other_, Kind::parameter);
  if (global_ != 0) count_sectors();
}

void AccessCounter::count(LaneMask mask, Kind kind) {
  if (mask == 0) return;
  LaunchCounts& counts = warp_.launch->counts;
  ++counts.warp_instructions_of[static_cast<u32>(kind)];
  counts.lane_instructions_of[static_cast<u32>(kind)] += static_cast<u64>(std::popcount(mask));
}

void AccessCounter::count_sectors() {
  LaunchCounts& counts = warp_.launch->counts;
  ++counts.requests;
  u64 seen[2 * kLanes];
  u32 count = 0;
  const auto visit = [&](u64 sector) {
    if (std::find(seen, seen + count, sector) != seen + count) return;
    seen[count++] = sector;
    GlobalMemory::Region* const region = global_memory().find(sector * GlobalMemory::kSector);
    if (region == nullptr) return;
    u32& epoch = region->sector_epoch[sector - region->base / GlobalMemory::kSector];
    if (epoch != warp_.launch->number) ++counts.distinct_sectors;
    epoch = warp_.launch->number;
  };
  for_each_lane(global_, [&](u32 l) {
    const u64 first = addresses_[l] / GlobalMemory::kSector;
    const u64 last = (addresses_[l] + bytes_ - 1) / GlobalMemory::kSector;
    visit(first);
    if (last != first) visit(last);
  });
  counts.sectors += count;
}

}  // namespace tetune::ptxsim

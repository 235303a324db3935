// SPDX-License-Identifier: Apache-2.0
#include "ptxsim/global_memory.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cstring>

#include "ptxsim/settings.hpp"

namespace tetune::ptxsim {
namespace {

/// The content of memory that came into use or was released: NaN as a double, and not a valid index.
constexpr int kPoison = 0xfb;

ByteHistory* new_history(u64 bytes) {
  void* const memory = mmap(nullptr, bytes * sizeof(ByteHistory), PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) fatal("out of memory for the history of accesses");
  return static_cast<ByteHistory*>(memory);
}

u64 address_of(const void* memory) { return reinterpret_cast<u64>(memory); }

}  // namespace

GlobalMemory::Region* GlobalMemory::search(u64 address) {
  for (const auto& region : regions_) {
    if (address - region->base < region->bytes) return latest_ = region.get();
  }
  return nullptr;
}

GlobalMemory::Region& GlobalMemory::add(u64 base, u64 bytes) {
  auto region = std::make_unique<Region>();
  region->base = base;
  region->bytes = bytes;
  region->buffers.push_back({base, base + bytes, true});
  region->buffer_of.assign((bytes + kGranule - 1) / kGranule, 0);
  region->sector_epoch.assign(bytes / kSector + 2, 0);
  if (settings().unwritten) region->written.assign(bytes, 0);
  if (settings().races) region->history = new_history(bytes);
  regions_.push_back(std::move(region));
  return *regions_.back();
}

bool GlobalMemory::remove(u64 base) {
  const auto found =
      std::find_if(regions_.begin(), regions_.end(), [base](const auto& region) { return region->base == base; });
  if (found == regions_.end()) return false;
  if ((*found)->history != nullptr) munmap((*found)->history, (*found)->bytes * sizeof(ByteHistory));
  regions_.erase(found);
  latest_ = nullptr;
  return true;
}

bool GlobalMemory::is_in_buffer(u64 address, u64 bytes) {
  const Region* const region = find(address);
  if (region == nullptr) return false;
  const Buffer& buffer = region->buffer_at(address);
  return buffer.in_use && address >= buffer.begin && address + bytes <= buffer.end;
}

void GlobalMemory::mark_written(u64 address, u64 bytes) {
  Region* const region = find(address);
  if (region == nullptr || region->written.empty()) return;
  std::memset(&region->written[address - region->base], 1, bytes);
}

void GlobalMemory::copy_written(u64 to, u64 from, u64 bytes) {
  Region* const target = find(to);
  const Region* const source = find(from);
  if (target->written.empty()) return;
  std::memmove(&target->written[to - target->base], &source->written[from - source->base], bytes);
}

u64 GlobalMemory::count_unwritten(u64 address, u64 bytes) {
  const Region* const region = find(address);
  if (region->written.empty()) return 0;
  const u8* const first = &region->written[address - region->base];
  return static_cast<u64>(std::count(first, first + bytes, u8{0}));
}

void GlobalMemory::allocated(void* part, std::size_t bytes) noexcept {
  const u64 begin = address_of(part);
  Region* const region = find(begin);
  if (region == nullptr) return;  // of another pool, such as the emulation's
  if (!region->has_pool) region->buffers[0].in_use = false;
  region->has_pool = true;
  const auto id = static_cast<u32>(region->buffers.size());
  region->buffers.push_back({begin, begin + bytes, true});
  for (u64 g = (begin - region->base) / kGranule; g <= (begin + bytes - 1 - region->base) / kGranule; ++g) {
    region->buffer_of[g] = id;
  }
  std::memset(part, kPoison, bytes);
  const u64 offset = begin - region->base;
  if (!region->written.empty()) std::memset(&region->written[offset], 0, bytes);
  if (region->history != nullptr) std::memset(region->history + offset, 0, bytes * sizeof(ByteHistory));
}

void GlobalMemory::released(void* part) noexcept {
  const u64 begin = address_of(part);
  Region* const region = find(begin);
  if (region == nullptr) return;
  Buffer& buffer = region->buffers[region->buffer_of[(begin - region->base) / kGranule]];
  if (!buffer.in_use || buffer.begin != begin) fatal("a pool releases what it did not allocate");
  buffer.in_use = false;
  std::memset(part, kPoison, buffer.end - buffer.begin);
}

GlobalMemory& global_memory() {
  static GlobalMemory* const instance = new GlobalMemory;  // used until the process ends
  return *instance;
}

}  // namespace tetune::ptxsim

namespace tetune::backend {

PoolObserver* pool_observer() noexcept { return &ptxsim::global_memory(); }

}  // namespace tetune::backend

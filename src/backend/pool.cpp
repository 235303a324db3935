// SPDX-License-Identifier: Apache-2.0
#include "backend/pool.hpp"

#include <iterator>
#include <string>

#include "backend/macros.hpp"
#include "tetune/error.hpp"

namespace tetune::backend {

[[gnu::weak]] PoolObserver* pool_observer() noexcept { return nullptr; }

Pool::Pool(void* block, std::size_t bytes)
    : block_(static_cast<char*>(block)), block_bytes_(bytes / kAlignment * kAlignment), end_(block_) {}

Pool::~Pool() { TETUNE_ASSERT(in_use_ == 0); }

/// The smallest free part of at least `bytes`; else a new one at the end, or the last one grown if it is free.
Pool::ByAddress::iterator Pool::find_free(std::size_t bytes) {
  auto best = parts_.end();
  for (auto part = parts_.begin(); part != parts_.end(); ++part) {
    const Part& p = part->second;
    if (p.is_free && p.bytes >= bytes && (best == parts_.end() || p.bytes < best->second.bytes)) best = part;
  }
  if (best != parts_.end()) return best;
  const bool grows = !parts_.empty() && parts_.rbegin()->second.is_free;
  char* const begin = grows ? parts_.rbegin()->first : end_;
  if (bytes > block_bytes_ - static_cast<std::size_t>(begin - block_)) return parts_.end();
  end_ = begin + bytes;
  return parts_.insert_or_assign(begin, Part{bytes, true}).first;
}

void* Pool::allocate(std::size_t bytes) {
  if (bytes == 0) return nullptr;
  const std::size_t rounded = (bytes + kAlignment - 1) / kAlignment * kAlignment;
  const auto part = find_free(rounded);
  if (part == parts_.end()) {
    constexpr std::size_t kMiB = std::size_t{1} << 20;
    throw DeviceError("out of memory on the GPU: of " + std::to_string(block_bytes_ / kMiB) +
                      " MiB reserved for this run, " + std::to_string(in_use_ / kMiB) + " are in use, and " +
                      std::to_string(bytes / kMiB + 1) +
                      " more are needed in one piece. Use the CPU (device=cpu), or do less (effort=fast).");
  }
  if (part->second.bytes > rounded) parts_.emplace(part->first + rounded, Part{part->second.bytes - rounded, true});
  part->second = {rounded, false};
  in_use_ += rounded;
  if (PoolObserver* const observer = pool_observer()) observer->allocated(part->first, bytes);
  return part->first;
}

void Pool::release(void* memory) noexcept {
  if (PoolObserver* const observer = pool_observer()) observer->released(memory);
  const auto part = parts_.find(static_cast<char*>(memory));
  part->second.is_free = true;
  in_use_ -= part->second.bytes;
  if (const auto next = std::next(part); next != parts_.end() && next->second.is_free) {
    part->second.bytes += next->second.bytes;
    parts_.erase(next);
  }
  if (part == parts_.begin()) return;
  if (const auto previous = std::prev(part); previous->second.is_free) {
    previous->second.bytes += part->second.bytes;
    parts_.erase(part);
  }
}

}  // namespace tetune::backend

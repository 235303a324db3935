// SPDX-License-Identifier: Apache-2.0
#include "backend/pool.hpp"

#include <algorithm>
#include <iterator>
#include <string>

#include "backend/macros.hpp"
#include "tetune/error.hpp"

namespace tetune::backend {

[[gnu::weak]] PoolObserver* pool_observer() noexcept { return nullptr; }

namespace {

std::size_t round_up(std::size_t bytes) { return (bytes + Pool::kAlignment - 1) / Pool::kAlignment * Pool::kAlignment; }

constexpr std::size_t kMiB = std::size_t{1} << 20;
constexpr const char* kRemedy = "Use the CPU (device=cpu), or do less (effort=fast).";

[[noreturn]] void refuse(std::size_t bytes, std::size_t reserved, std::size_t in_use) {
  throw DeviceError("out of memory on the GPU: of " + std::to_string(reserved / kMiB) + " MiB reserved for this run, " +
                    std::to_string(in_use / kMiB) + " are in use, and " + std::to_string(bytes / kMiB + 1) +
                    " more are needed in one piece. " + kRemedy);
}

}  // namespace

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

void* Pool::allocate_if_it_fits(std::size_t bytes) {
  const std::size_t rounded = round_up(bytes);
  const auto part = rounded == 0 ? parts_.end() : find_free(rounded);
  if (part == parts_.end()) return nullptr;
  if (part->second.bytes > rounded) parts_.emplace(part->first + rounded, Part{part->second.bytes - rounded, true});
  part->second = {rounded, false};
  in_use_ += rounded;
  if (PoolObserver* const observer = pool_observer()) observer->allocated(part->first, bytes);
  return part->first;
}

void* Pool::allocate(std::size_t bytes) {
  void* const part = allocate_if_it_fits(bytes);
  if (part == nullptr && bytes > 0) refuse(bytes, block_bytes_, in_use_);
  return part;
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

GrowingPool::GrowingPool(const Device& device, std::size_t bytes) : device_(device), first_bytes_(bytes) {
  if (add(bytes)) return;
  throw DeviceError("out of memory on the GPU: " + std::to_string(bytes / kMiB + 1) + " MiB are needed in one piece. " +
                    kRemedy);
}

bool GrowingPool::add(std::size_t bytes) {
  void* const memory = device_.allocate(bytes);
  if (memory == nullptr) return false;
  blocks_.emplace_back(std::unique_ptr<void, void (*)(void*)>(memory, device_.free), bytes);
  return true;
}

void* GrowingPool::allocate(std::size_t bytes) {
  if (bytes == 0) return nullptr;
  std::size_t reserved = 0;
  std::size_t in_use = 0;
  for (Block& block : blocks_) {
    if (void* const part = block.pool.allocate_if_it_fits(bytes)) return part;
    reserved += block.pool.size();
    in_use += block.pool.in_use();
  }
  // Larger blocks than requested, as long as the device has them: a block's free parts serve later requests.
  if (!add(std::max(round_up(bytes), first_bytes_ / 4)) && !add(round_up(bytes))) refuse(bytes, reserved, in_use);
  return blocks_.back().pool.allocate(bytes);
}

void GrowingPool::release(void* part) noexcept {
  const auto holds = [part](const Block& block) { return block.pool.holds(part); };
  const auto block = std::find_if(blocks_.begin(), blocks_.end(), holds);
  TETUNE_ASSERT(block != blocks_.end());
  block->pool.release(part);
}

}  // namespace tetune::backend

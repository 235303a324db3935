// SPDX-License-Identifier: Apache-2.0
#include "par/block_cache.hpp"

#include <cstdlib>
#include <map>
#include <mutex>
#include <new>
#include <unordered_map>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace tetune::par::block_cache {
namespace {

constexpr std::size_t kHugePage = std::size_t{1} << 21;
/// Blocks from here on are kept; the C library keeps smaller ones itself. In steps of this, so that they serve again.
constexpr std::size_t kLeast = std::size_t{1} << 16;
/// Blocks that are kept have at most this part of the memory in use, as its inverse.
constexpr std::size_t kUsedPerKept = 4;

class Cache {
 public:
  void* allocate(std::size_t bytes) {
    const std::size_t step = 2 * bytes > kHugePage ? kHugePage : kLeast;
    bytes = (bytes + step - 1) / step * step;
    const std::lock_guard lock(mutex_);
    // Not much larger than asked for, or what is small would sit on what is large.
    if (const auto kept = kept_.lower_bound(bytes); kept != kept_.end() && kept->first <= bytes + bytes / 2) {
      const auto [size, memory] = *kept;
      used_.emplace(memory, size);
      kept_.erase(kept);
      bytes_kept_ -= size;
      bytes_used_ += size;
      return memory;
    }
    const std::size_t alignment = bytes >= kHugePage ? kHugePage : 64;
    void* memory = std::aligned_alloc(alignment, bytes);
    if (memory == nullptr) {
      drop(0);
      memory = std::aligned_alloc(alignment, bytes);
      if (memory == nullptr) throw std::bad_alloc();
    }
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    if (bytes >= kHugePage) madvise(memory, bytes, MADV_HUGEPAGE);
#endif
    try {
      used_.emplace(memory, bytes);
    } catch (...) {
      std::free(memory);
      throw;
    }
    bytes_used_ += bytes;
    return memory;
  }

  void release(void* memory) noexcept {
    const std::lock_guard lock(mutex_);
    const auto used = used_.find(memory);
    const std::size_t size = used->second;
    used_.erase(used);
    bytes_used_ -= size;
    try {
      kept_.emplace(size, memory);
      bytes_kept_ += size;
    } catch (...) {
      std::free(memory);
    }
    drop(sessions_ > 0 ? bytes_used_ / kUsedPerKept : 0);
  }

  void open() {
    const std::lock_guard lock(mutex_);
    ++sessions_;
  }
  void close() {
    const std::lock_guard lock(mutex_);
    if (--sessions_ == 0) drop(0);
  }

 private:
  /// The smallest first: the largest cost most to have anew.
  void drop(std::size_t most) noexcept {
    while (bytes_kept_ > most) {
      const auto smallest = kept_.begin();
      bytes_kept_ -= smallest->first;
      std::free(smallest->second);
      kept_.erase(smallest);
    }
  }

  std::mutex mutex_;
  int sessions_ = 0;
  std::size_t bytes_used_ = 0, bytes_kept_ = 0;
  std::unordered_map<void*, std::size_t> used_;
  std::multimap<std::size_t, void*> kept_;
};

/// Never destroyed: buffers may outlive what is static elsewhere.
Cache& cache() {
  static Cache& the = *new Cache;
  return the;
}

}  // namespace

void* allocate(std::size_t bytes) {
  if (bytes == 0) return nullptr;
  if (bytes >= kLeast) return cache().allocate(bytes);
  void* memory = std::aligned_alloc(64, (bytes + 63) / 64 * 64);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void release(void* memory, std::size_t bytes) noexcept {
  if (bytes >= kLeast) {
    cache().release(memory);
  } else {
    std::free(memory);
  }
}

Session::Session() { cache().open(); }
Session::~Session() { cache().close(); }

}  // namespace tetune::par::block_cache

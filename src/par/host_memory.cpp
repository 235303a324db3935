// SPDX-License-Identifier: Apache-2.0
#include "par/host_memory.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

#include "par/parts.hpp"

// Under the address sanitizer each array is a block of its own, so that it sees what is read or written beside them.
#if defined(__SANITIZE_ADDRESS__)
#define TETUNE_REGIONS 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define TETUNE_REGIONS 0
#endif
#endif
#if !defined(TETUNE_REGIONS)
#define TETUNE_REGIONS __has_include(<sys/mman.h>)
#endif
#if TETUNE_REGIONS
#include <sys/mman.h>
#include <sys/resource.h>
#endif

namespace tetune::par::host_memory {
namespace {

std::size_t rounded_up(std::size_t bytes, std::size_t step) { return (bytes + step - 1) / step * step; }

#if TETUNE_REGIONS

/// Arrays from here on lie in regions, in steps of this; the C library keeps smaller blocks itself.
constexpr std::size_t kLeast = std::size_t{1} << 16;
constexpr std::size_t kHugePage = std::size_t{1} << 21;

/// Address space: the system gives it memory page by page, as it is touched.
class Region {
 public:
  /// Nothing where the system refuses.
  explicit Region(std::size_t bytes) : parts_(bytes) {
    void* const mapped = mmap(nullptr, bytes + kHugePage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapped == MAP_FAILED) return;
    char* const begin = static_cast<char*>(mapped);
    base_ = reinterpret_cast<char*>(rounded_up(reinterpret_cast<std::size_t>(begin), kHugePage));
    if (base_ > begin) munmap(begin, static_cast<std::size_t>(base_ - begin));
    munmap(base_ + bytes, static_cast<std::size_t>(begin + kHugePage - base_));
#if defined(MADV_HUGEPAGE)
    // Small meshes stay below.
    if (bytes > 2 * kHugePage) madvise(base_ + 2 * kHugePage, bytes - 2 * kHugePage, MADV_HUGEPAGE);
#endif
  }
  Region(Region&& other) noexcept : parts_(std::move(other.parts_)), base_(std::exchange(other.base_, nullptr)) {}
  Region& operator=(Region&& other) noexcept {
    std::swap(parts_, other.parts_);
    std::swap(base_, other.base_);
    return *this;
  }
  Region(const Region&) = delete;
  Region& operator=(const Region&) = delete;
  ~Region() {
    if (base_ != nullptr) munmap(base_, parts_.block_bytes());
  }

  bool mapped() const { return base_ != nullptr; }
  std::size_t bytes() const { return parts_.block_bytes(); }
  bool in_use() const { return parts_.in_use() > 0; }
  bool has(const void* memory) const { return memory >= base_ && memory < base_ + parts_.block_bytes(); }
  /// Null where there is no room.
  void* take(std::size_t bytes) {
    const std::size_t begin = parts_.take(bytes);
    return begin == Parts::kNowhere ? nullptr : base_ + begin;
  }
  void give_back(void* memory) noexcept {
    parts_.give_back(static_cast<std::size_t>(static_cast<char*>(memory) - base_));
  }

 private:
  Parts parts_;
  char* base_ = nullptr;
};

class Regions {
 public:
  void* allocate(std::size_t bytes) {
    bytes = rounded_up(bytes, kLeast);
    const std::lock_guard lock(mutex_);
    for (Region& region : regions_) {
      if (void* memory = region.take(bytes)) return memory;
    }
    regions_.reserve(regions_.size() + 1);
    Region region(std::max(bytes, usual_size()));
    if (!region.mapped()) region = Region(bytes);
    if (!region.mapped()) {
      drop_unused();
      region = Region(bytes);
    }
    void* const memory = region.mapped() ? region.take(bytes) : nullptr;
    if (memory == nullptr) throw std::bad_alloc();
    regions_.push_back(std::move(region));
    return memory;
  }

  void release(void* memory) noexcept {
    const std::lock_guard lock(mutex_);
    const auto has_it = [memory](const Region& region) { return region.has(memory); };
    const auto region = std::find_if(regions_.begin(), regions_.end(), has_it);
    region->give_back(memory);
    // One made for a single large array may never serve another.
    if (!region->in_use() && (sessions_ == 0 || region->bytes() > usual_size())) regions_.erase(region);
  }

  void open() {
    const std::lock_guard lock(mutex_);
    ++sessions_;
  }
  void close() {
    const std::lock_guard lock(mutex_);
    if (--sessions_ == 0) drop_unused();
  }

 private:
  /// Nothing where address space is limited: the rest of the process needs it as well, so each array gets what it
  /// takes.
  static std::size_t usual_size() {
    for (const int resource : {RLIMIT_AS, RLIMIT_DATA}) {
      rlimit limit{};
      if (getrlimit(resource, &limit) != 0 || limit.rlim_cur != RLIM_INFINITY) return 0;
    }
    return std::size_t{1} << 30;
  }
  void drop_unused() noexcept {
    const auto unused = [](const Region& region) { return !region.in_use(); };
    regions_.erase(std::remove_if(regions_.begin(), regions_.end(), unused), regions_.end());
  }

  std::mutex mutex_;
  int sessions_ = 0;
  std::vector<Region> regions_;
};

/// Never destroyed: arrays may outlive what is static elsewhere.
Regions& regions() {
  static Regions& the = *new Regions;
  return the;
}

#endif

}  // namespace

void* allocate(std::size_t bytes) {
  if (bytes == 0) return nullptr;
  if (bytes > std::numeric_limits<std::size_t>::max() / 2) throw std::bad_alloc();
#if TETUNE_REGIONS
  if (bytes >= kLeast) return regions().allocate(bytes);
#endif
  void* memory = std::aligned_alloc(64, rounded_up(bytes, 64));
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void release(void* memory, [[maybe_unused]] std::size_t bytes) noexcept {
#if TETUNE_REGIONS
  if (bytes >= kLeast) return regions().release(memory);
#endif
  std::free(memory);
}

#if TETUNE_REGIONS
Session::Session() { regions().open(); }
Session::~Session() { regions().close(); }
#else
Session::Session() = default;
Session::~Session() = default;
#endif

}  // namespace tetune::par::host_memory

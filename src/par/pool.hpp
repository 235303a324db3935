// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>

namespace tetune::par {

/// Hands out parts of one large block, without touching it: memory of a device, whose own allocator waits for the
/// device. Best fit; neighbours are joined when they are given back. What lies beyond all that was ever in use comes
/// last, so that where a part lies depends on the calls alone, and not on the size of the block.
///
/// While there is one, it is the pool of the thread that made it; they must go in the reverse order.
class Pool {
 public:
  /// Each part begins at a multiple of it, as cudaMalloc's do.
  static constexpr std::size_t kAlignment = 256;

  Pool(void* block, std::size_t bytes);
  ~Pool();
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  /// The calling thread's last; there must be one.
  static Pool& current() { return *current_; }

  /// Throws DeviceError where there is no room. Null for no bytes.
  void* allocate(std::size_t bytes);
  /// Not null.
  void release(void* part) noexcept;

  std::size_t in_use() const { return in_use_; }
  /// The size of a block that would have done.
  std::size_t peak() const { return end_; }

 private:
  struct Part {
    std::size_t bytes;
    bool is_free;
  };
  using Parts = std::map<std::size_t, Part>;
  Parts::iterator find_room(std::size_t bytes);

  static thread_local Pool* current_;
  Pool* outer_;
  char* block_;
  std::size_t size_;
  /// By where they begin; they fill the block from its start to `end_`. There are never many.
  Parts parts_;
  std::size_t end_ = 0;
  std::size_t in_use_ = 0;
};

}  // namespace tetune::par

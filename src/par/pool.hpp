// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "par/parts.hpp"

namespace tetune::par {

/// Hands out parts of one large block, without touching it: memory of a device, whose own allocator waits for the
/// device.
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

  std::size_t in_use() const { return parts_.in_use(); }
  /// The size of a block that would have done.
  std::size_t peak() const { return parts_.peak(); }

 private:
  static thread_local Pool* current_;
  Pool* outer_;
  char* block_;
  Parts parts_;
};

}  // namespace tetune::par

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <memory>
#include <utility>

namespace tetune::backend {

/// Is called with each part of a pool that comes into use and that is released, so that a checker of memory accesses
/// knows which bytes of the block may be accessed.
class PoolObserver {
 public:
  /// `bytes`: as requested, not rounded up. The content of the part is unspecified.
  virtual void allocated(void* part, std::size_t bytes) noexcept = 0;
  virtual void released(void* part) noexcept = 0;

 protected:
  ~PoolObserver() = default;
};

/// The observer of all pools of the process: none in the library. The function is weak, so that a program may define it
/// once more: tests/ptxsim does.
PoolObserver* pool_observer() noexcept;

/// A free-list allocator over one large block of device memory. It does not access the block, and unlike the allocator
/// of the device it does not synchronize with the device.
///
/// Best fit; adjacent free parts are merged. The memory beyond all parts allocated so far is used last, so that the
/// position of a part depends on the sequence of calls alone, and not on the size of the block.
class Pool {
 public:
  /// The alignment of each part, as of cudaMalloc.
  static constexpr std::size_t kAlignment = 256;

  Pool(void* block, std::size_t bytes);
  /// Requires that all parts are released.
  ~Pool();
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  /// Null for 0 bytes. Throws DeviceError where no free part is large enough.
  void* allocate(std::size_t bytes);
  /// Same as allocate(), but returns null where no free part is large enough.
  void* allocate_if_it_fits(std::size_t bytes);
  /// Requires a part that is in use.
  void release(void* part) noexcept;

  std::size_t size() const { return block_bytes_; }
  std::size_t in_use() const { return in_use_; }
  bool holds(const void* part) const { return part >= block_ && part < end_; }
  /// The size of the smallest block for which all allocations would have succeeded; memory_needed_on_device() is
  /// fitted to it.
  std::size_t peak() const { return static_cast<std::size_t>(end_ - block_); }

 private:
  struct Part {
    std::size_t bytes;
    bool is_free;
  };
  using ByAddress = std::map<char*, Part>;
  ByAddress::iterator find_free(std::size_t bytes);

  char* block_;
  std::size_t block_bytes_;
  std::size_t in_use_ = 0;
  /// The parts cover the block from its start to `end_`. Their number is small.
  ByAddress parts_;
  char* end_;
};

/// A pool that takes another block from the device where those it has are too small: the size of the first is an
/// estimate.
class GrowingPool {
 public:
  /// How blocks are allocated and freed. `allocate` returns null where the device does not have enough memory.
  struct Device {
    void* (*allocate)(std::size_t bytes);
    void (*free)(void* block);
  };

  /// Throws DeviceError where the device does not have enough memory.
  GrowingPool(const Device& device, std::size_t bytes);
  GrowingPool(const GrowingPool&) = delete;
  GrowingPool& operator=(const GrowingPool&) = delete;

  /// Null for 0 bytes. Throws DeviceError where the device has no more memory.
  void* allocate(std::size_t bytes);
  /// Requires a part that is in use.
  void release(void* part) noexcept;

 private:
  struct Block {
    Block(std::unique_ptr<void, void (*)(void*)> allocated, std::size_t bytes)
        : memory(std::move(allocated)), pool(memory.get(), bytes) {}
    std::unique_ptr<void, void (*)(void*)> memory;
    Pool pool;
  };
  /// Takes a block from the device. Returns false where the device does not have enough memory.
  bool add(std::size_t bytes);

  Device device_;
  std::size_t first_bytes_;
  std::list<Block> blocks_;
};

}  // namespace tetune::backend

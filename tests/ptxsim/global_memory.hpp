// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "backend/pool.hpp"
#include "ptxsim/access_history.hpp"
#include "ptxsim/types.hpp"

namespace tetune::ptxsim {

/// The device's memory: which addresses there are, which of them are in a buffer in use, which bytes were written, and
/// by which thread. The content itself is in the memory of the process, at the same addresses.
class GlobalMemory final : public backend::PoolObserver {
 public:
  struct Buffer {
    u64 begin, end;
    bool in_use;
  };
  /// The unit in which addresses are assigned to buffers, not more than the alignment of a pool.
  static constexpr u32 kGranule = backend::Pool::kAlignment;
  static constexpr u32 kSector = 32;

  /// Memory of one cudaMalloc(), or a variable of a module.
  struct Region {
    u64 base, bytes;
    std::vector<Buffer> buffers;     ///< the first one is the whole region until a pool reports parts
    std::vector<u32> buffer_of;      ///< of each granule
    std::vector<u8> written;         ///< of each byte; empty if unwritten memory is not searched for
    std::vector<u32> sector_epoch;   ///< of each sector: the latest launch that accessed it
    ByteHistory* history = nullptr;  ///< of each byte; null if races are not searched for
    bool has_pool = false;

    const Buffer& buffer_at(u64 address) const { return buffers[buffer_of[(address - base) / kGranule]]; }
  };

  /// Null where there is none.
  Region* find(u64 address) {
    if (latest_ != nullptr && address - latest_->base < latest_->bytes) return latest_;
    return search(address);
  }
  /// Memory of the process becomes memory of the device.
  Region& add(u64 base, u64 bytes);
  /// Whether there was such a region.
  bool remove(u64 base);
  /// Whether the bytes are in one buffer in use.
  bool is_in_buffer(u64 address, u64 bytes);
  void mark_written(u64 address, u64 bytes);
  /// As many bytes as a copy makes written or unwritten.
  void copy_written(u64 to, u64 from, u64 bytes);
  u64 count_unwritten(u64 address, u64 bytes);

  void allocated(void* part, std::size_t bytes) noexcept override;
  void released(void* part) noexcept override;

 private:
  Region* search(u64 address);

  std::vector<std::unique_ptr<Region>> regions_;
  Region* latest_ = nullptr;
};

/// The memory of the one device.
GlobalMemory& global_memory();

}  // namespace tetune::ptxsim

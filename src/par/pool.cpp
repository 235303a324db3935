// SPDX-License-Identifier: Apache-2.0
#include "par/pool.hpp"

#include <string>

#include "par/macros.hpp"
#include "tetune/error.hpp"

namespace tetune::par {

thread_local Pool* Pool::current_ = nullptr;

Pool::Pool(void* block, std::size_t bytes)
    : outer_(current_), block_(static_cast<char*>(block)), parts_(bytes / kAlignment * kAlignment) {
  current_ = this;
}

Pool::~Pool() {
  TETUNE_ASSERT(in_use() == 0);
  current_ = outer_;
}

void* Pool::allocate(std::size_t bytes) {
  if (bytes == 0) return nullptr;
  const std::size_t begin = parts_.take((bytes + kAlignment - 1) / kAlignment * kAlignment);
  if (begin == Parts::kNowhere) {
    constexpr std::size_t kMiB = std::size_t{1} << 20;
    throw DeviceError("out of memory on the GPU: of " + std::to_string(parts_.block_bytes() / kMiB) +
                      " MiB set aside for this run, " + std::to_string(in_use() / kMiB) + " are in use, and " +
                      std::to_string(bytes / kMiB + 1) +
                      " more are needed in one piece. Use the CPU (--device cpu), or do less (--effort fast).");
  }
  return block_ + begin;
}

void Pool::release(void* part) noexcept {
  parts_.give_back(static_cast<std::size_t>(static_cast<char*>(part) - block_));
}

}  // namespace tetune::par

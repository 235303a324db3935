// SPDX-License-Identifier: Apache-2.0
#include "par/pool.hpp"

#include <iterator>
#include <string>

#include "par/macros.hpp"
#include "tetune/error.hpp"

namespace tetune::par {

thread_local Pool* Pool::current_ = nullptr;

Pool::Pool(void* block, std::size_t bytes)
    : outer_(current_), block_(static_cast<char*>(block)), size_(bytes / kAlignment * kAlignment) {
  current_ = this;
}

Pool::~Pool() {
  TETUNE_ASSERT(in_use_ == 0);
  current_ = outer_;
}

Pool::Parts::iterator Pool::find_room(std::size_t bytes) {
  auto best = parts_.end();
  for (auto part = parts_.begin(); part != parts_.end(); ++part) {
    const Part& p = part->second;
    if (p.is_free && p.bytes >= bytes && (best == parts_.end() || p.bytes < best->second.bytes)) best = part;
  }
  if (best != parts_.end()) return best;
  const auto last = parts_.empty() || !parts_.rbegin()->second.is_free ? parts_.end() : std::prev(parts_.end());
  const std::size_t begin = last == parts_.end() ? end_ : last->first;
  if (bytes > size_ - begin) {
    constexpr std::size_t kMiB = std::size_t{1} << 20;
    throw DeviceError("out of memory on the GPU: of " + std::to_string(size_ / kMiB) + " MiB set aside for this run, " +
                      std::to_string(in_use_ / kMiB) + " are in use, and " + std::to_string(bytes / kMiB + 1) +
                      " more are needed in one piece. Use the CPU (--device cpu), or do less (--effort fast).");
  }
  const auto room = last == parts_.end() ? parts_.emplace(begin, Part{bytes, true}).first : last;
  room->second.bytes = bytes;
  end_ = begin + bytes;
  return room;
}

void* Pool::allocate(std::size_t bytes) {
  if (bytes == 0) return nullptr;
  bytes = (bytes + kAlignment - 1) / kAlignment * kAlignment;
  const auto room = find_room(bytes);
  if (room->second.bytes > bytes) parts_.emplace(room->first + bytes, Part{room->second.bytes - bytes, true});
  room->second = {bytes, false};
  in_use_ += bytes;
  return block_ + room->first;
}

void Pool::release(void* part) noexcept {
  auto here = parts_.find(static_cast<std::size_t>(static_cast<char*>(part) - block_));
  here->second.is_free = true;
  in_use_ -= here->second.bytes;
  if (const auto next = std::next(here); next != parts_.end() && next->second.is_free) {
    here->second.bytes += next->second.bytes;
    parts_.erase(next);
  }
  if (here == parts_.begin()) return;
  if (const auto previous = std::prev(here); previous->second.is_free) {
    previous->second.bytes += here->second.bytes;
    parts_.erase(here);
  }
}

}  // namespace tetune::par

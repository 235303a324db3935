// SPDX-License-Identifier: Apache-2.0
#include "par/parts.hpp"

#include <iterator>

namespace tetune::par {

Parts::ByBegin::iterator Parts::find_room(std::size_t bytes) {
  auto best = parts_.end();
  for (auto part = parts_.begin(); part != parts_.end(); ++part) {
    const Part& p = part->second;
    if (p.is_free && p.bytes >= bytes && (best == parts_.end() || p.bytes < best->second.bytes)) best = part;
  }
  if (best != parts_.end()) return best;
  const auto last = parts_.empty() || !parts_.rbegin()->second.is_free ? parts_.end() : std::prev(parts_.end());
  const std::size_t begin = last == parts_.end() ? end_ : last->first;
  if (bytes > block_bytes_ - begin) return parts_.end();
  const auto room = last == parts_.end() ? parts_.emplace(begin, Part{bytes, true}).first : last;
  room->second.bytes = bytes;
  end_ = begin + bytes;
  return room;
}

std::size_t Parts::take(std::size_t bytes) {
  const auto room = find_room(bytes);
  if (room == parts_.end()) return kNowhere;
  if (room->second.bytes > bytes) parts_.emplace(room->first + bytes, Part{room->second.bytes - bytes, true});
  room->second = {bytes, false};
  in_use_ += bytes;
  return room->first;
}

void Parts::give_back(std::size_t begin) noexcept {
  auto here = parts_.find(begin);
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

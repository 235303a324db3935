// SPDX-License-Identifier: Apache-2.0
#include "ptxsim/access_history.hpp"

#include <algorithm>
#include <cstring>

namespace tetune::ptxsim {
namespace {

constexpr u32 kStrong = 0x80000000U;
constexpr u32 kSeveral = 0x7fffffffU;  // threads

u32 thread_of(u32 entry) { return entry & ~kStrong; }

bool conflicts(u32 epoch, u32 entry, const Accessor& a) {
  const bool both_strong = (entry & kStrong) != 0 && a.strong;
  return epoch == a.epoch && thread_of(entry) != a.thread && !both_strong;
}

u32 entry_of(u32 thread, bool strong) { return thread | (strong ? kStrong : 0); }

void record_read(ByteHistory& byte, const Accessor& a) {
  if (byte.read_epoch != a.epoch) {
    byte.read_epoch = a.epoch;
    byte.reader = entry_of(a.thread, a.strong);
    return;
  }
  const bool strong = (byte.reader & kStrong) != 0 && a.strong;
  byte.reader = entry_of(thread_of(byte.reader) == a.thread ? a.thread : kSeveral, strong);
}

Race record_byte(ByteHistory& byte, const Accessor& a, Access access) {
  Race race;
  if (conflicts(byte.write_epoch, byte.writer, a)) {
    race = {true, access == Access::read ? "is read that another thread writes" : "is written by two threads"};
  } else if (access != Access::read && conflicts(byte.read_epoch, byte.reader, a)) {
    race = {true, "is written that another thread reads"};
  }
  if (access != Access::write) record_read(byte, a);
  if (access != Access::read) {
    byte.write_epoch = a.epoch;
    byte.writer = entry_of(a.thread, a.strong);
  }
  return race;
}

bool are_equal(const ByteHistory* bytes, u32 count) {
  return std::memcmp(bytes, bytes + 1, (count - 1) * sizeof *bytes) == 0;
}

}  // namespace

Race record(ByteHistory* bytes, u32 count, const Accessor& a, Access access) {
  if (are_equal(bytes, count)) {
    // As a rule the bytes of a value were accessed together.
    const ByteHistory before = bytes[0];
    const Race race = record_byte(bytes[0], a, access);
    if (std::memcmp(&before, bytes, sizeof before) != 0) std::fill(bytes + 1, bytes + count, bytes[0]);
    return race;
  }
  Race first;
  for (u32 i = 0; i < count; ++i) {
    const Race race = record_byte(bytes[i], a, access);
    if (race.found && !first.found) first = race;
  }
  return first;
}

}  // namespace tetune::ptxsim

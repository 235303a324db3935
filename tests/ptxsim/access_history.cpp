// SPDX-License-Identifier: Apache-2.0
#include "ptxsim/access_history.hpp"

#include <algorithm>
#include <cstring>

namespace tetune::ptxsim {
namespace {

constexpr u32 kStrong = 0x80000000U;
constexpr u32 kSeveral = 0x7fffffffU;  // threads of several blocks

u32 thread_of(u32 entry) { return entry & ~kStrong; }
u32 block_of(u32 thread) { return thread / kThreadNumbers; }
/// Stands for several threads of a block.
u32 several_of(u32 block) { return thread_number(block, kThreadNumbers - 1); }

/// Whether no barrier lies between an earlier access and this one.
bool is_unordered(u32 epoch, u32 thread, const Accessor& a) {
  if (epoch == a.epoch) return true;
  return epoch / kBlockEpochs == a.epoch / kBlockEpochs && block_of(thread) != block_of(a.thread);
}

bool conflicts(u32 epoch, u32 entry, const Accessor& a) {
  const bool both_strong = (entry & kStrong) != 0 && a.strong;
  return thread_of(entry) != a.thread && !both_strong && is_unordered(epoch, thread_of(entry), a);
}

u32 entry_of(u32 thread, bool strong) { return thread | (strong ? kStrong : 0); }

void record_read(ByteHistory& byte, const Accessor& a) {
  const u32 before = thread_of(byte.reader);
  const bool joins = is_unordered(byte.read_epoch, before, a);
  byte.read_epoch = a.epoch;
  if (!joins) {
    byte.reader = entry_of(a.thread, a.strong);
    return;
  }
  const bool strong = (byte.reader & kStrong) != 0 && a.strong;
  const u32 reader = before == a.thread                       ? a.thread
                     : block_of(before) == block_of(a.thread) ? several_of(block_of(a.thread))
                                                              : kSeveral;
  byte.reader = entry_of(reader, strong);
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

// SPDX-License-Identifier: Apache-2.0
#include "ptxsim/access_history.hpp"

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

}  // namespace

Race record(ByteHistory* bytes, u32 count, const Accessor& a, Access access) {
  Race race;
  for (u32 i = 0; i < count; ++i) {
    ByteHistory& byte = bytes[i];
    const bool after_write = conflicts(byte.write_epoch, byte.writer, a);
    const bool after_read = access != Access::read && conflicts(byte.read_epoch, byte.reader, a);
    if (after_write && !race.found) {
      race = {true, access == Access::read ? "is read that another thread writes" : "is written by two threads"};
    }
    if (after_read && !race.found) race = {true, "is written that another thread reads"};
    if (access != Access::write) record_read(byte, a);
    if (access != Access::read) {
      byte.write_epoch = a.epoch;
      byte.writer = entry_of(a.thread, a.strong);
    }
  }
  return race;
}

}  // namespace tetune::ptxsim

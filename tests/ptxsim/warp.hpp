// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <memory>
#include <vector>

#include "ptxsim/access_history.hpp"
#include "ptxsim/launch.hpp"
#include "ptxsim/program.hpp"

namespace tetune::ptxsim {

/// Generic addresses have the space in their uppermost byte; those of global memory have none.
inline constexpr u64 kSharedTag = u64{1} << 56, kLocalTag = u64{2} << 56, kParameterTag = u64{3} << 56;
inline constexpr u64 kTagMask = u64{0xff} << 56;

inline constexpr u32 kStackBytes = 64 * 1024;  ///< per lane
/// From one lane's stack to the next one's. Equal offsets of all lanes are in different sets of a processor's cache.
inline constexpr u32 kStackStride = kStackBytes + 64;
inline constexpr u32 kBarriers = 16;  ///< per block

/// A barrier of a block.
struct Barrier {
  u32 arrived = 0, expected = 0;  ///< threads; 0 expected: all that still run
  bool any = false, all = true;
  u32 count = 0;
};

/// A block of threads that runs.
struct Block {
  u32 index[3] = {};
  u32 number = 0;
  std::vector<char> shared;
  std::vector<ByteHistory> history;  ///< of `shared`
  u32 epoch = 1;                     ///< advanced by barriers
  std::vector<std::unique_ptr<Warp>> warps;
  Barrier barriers[kBarriers];
  u32 running = 0;  ///< threads
};

enum class LaneState : u8 { running, at_barrier, at_warp_sync, ended };

/// Where a lane returns to.
struct CallFrame {
  u32 pc, register_base, stack_begin, stack_end;
  const Instruction* call;
};

struct Lane {
  LaneState state = LaneState::ended;
  u32 pc = 0;
  u32 register_base = 0;
  u32 stack_begin = 0, stack_end = 0;  ///< the frame of the running function
  u32 thread[3] = {};
  u32 barrier = 0;
  u64* barrier_result = nullptr;  ///< where the result of the awaited barrier goes, if it has one
  LaneMask awaited = 0;           ///< the lanes that an operation of the warp waits for
  std::vector<CallFrame> calls;
};

/// 32 threads. Those of them that are at the same instruction run it together: the active lanes.
struct Warp {
  alignas(64) u64 active_bits[kLanes];  ///< all ones for active lanes, else 0
  LaneMask active = 0;
  LaneMask not_ended = 0;
  u32 pc = 0, next_pc = 0;
  u32 register_base = 0;
  u32 lowest_other_pc = 0;   ///< of running lanes that are not active, at the same depth of calls
  bool must_choose = false;  ///< the active lanes must be chosen again
  bool pauses = false;       ///< the next warp is to run
  u64 instructions = 0;
  u64* registers = nullptr;
  u32 register_rows = 0;
  char* stacks = nullptr;
  const u64* constants = nullptr;
  const Instruction* code = nullptr;
  Block* block = nullptr;
  Launch* launch = nullptr;
  u32 id = 0;  ///< in its block
  Lane lanes[kLanes];

  u64* row(Row r) {
    if ((r & kConstantRow) != 0) return const_cast<u64*>(constants) + std::size_t{r & ~kConstantRow} * kLanes;
    return registers + (std::size_t{register_base} + r) * kLanes;
  }
  u64* row_or_null(Row r) { return r == kNoRow ? nullptr : row(r); }
  char* stack(u32 lane) { return stacks + std::size_t{lane} * kStackStride; }
  u32 first_active() const { return static_cast<u32>(std::countr_zero(active)); }
  u32 thread_in_block(u32 lane) const { return id * kLanes + lane; }
  void set_active(LaneMask mask) {
    active = mask;
    for (u32 l = 0; l < kLanes; ++l) active_bits[l] = (mask >> l & 1U) != 0 ? ~u64{0} : 0;
  }
};

/// Calls f(lane) for each lane of a mask.
template <class F>
void for_each_lane(LaneMask mask, const F& f) {
  for (; mask != 0; mask &= mask - 1) f(static_cast<u32>(std::countr_zero(mask)));
}

/// "kernel, block, thread": of a lane.
std::string thread_name(const Warp& warp, u32 lane);

/// The active lanes end.
void end_lanes(Warp& warp);
/// Lets the threads continue that wait at a barrier at which all expected ones have arrived.
void release_if_complete(Block& block, u32 barrier);
/// Called where a barrier orders the accesses of all threads of a block.
void advance_epoch(Block& block);

/// Runs up to `budget` instructions. Returns whether any lane could run.
bool run(Warp& warp, u64 budget);

/// See resolve(), for all spaces.
char* resolve_any(Warp& warp, u32 lane, u64 address, u32 bytes, Access access, const Instruction& instruction,
                  Space& space);

/// The memory behind an address that a lane accesses, after all checks, and its space. Where a check fails this is
/// memory that nothing else uses.
inline char* resolve(Warp& warp, u32 lane, u64 address, u32 bytes, Access access, const Instruction& instruction,
                     Space& space) {
  // Most accesses are to the lane's own stack.
  space = instruction.space;
  u64 offset = address;
  if (space == Space::generic && (address & kTagMask) == kLocalTag) {
    space = Space::local;
    offset &= ~kTagMask;
  }
  const bool on_stack = space == Space::local || space == Space::frame;
  if (on_stack && (offset & (bytes - 1)) == 0 && offset + bytes <= warp.lanes[lane].stack_end) {
    return warp.stack(lane) + offset;
  }
  return resolve_any(warp, lane, address, bytes, access, instruction, space);
}

}  // namespace tetune::ptxsim

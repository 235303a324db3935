// SPDX-License-Identifier: Apache-2.0
// The order in which the lanes of a warp run where they diverge: those in the deepest call first, then those at the
// lowest address, so that all converge behind the branch at which they diverged.
#include "ptxsim/warp.hpp"

namespace tetune::ptxsim {
namespace {

/// Resumes lanes that wait for lanes which have ended meanwhile. Returns whether there are any.
bool resume_waiting_lanes(Warp& w) {
  for (u32 l = 0; l < kLanes; ++l) {
    const Lane& lane = w.lanes[l];
    if (lane.state != LaneState::at_warp_sync) continue;
    LaneMask waiting = 0;
    for (u32 k = 0; k < kLanes; ++k) {
      const Lane& other = w.lanes[k];
      const bool waits_there = other.state == LaneState::at_warp_sync && other.pc == lane.pc &&
                               other.awaited == lane.awaited && other.register_base == lane.register_base;
      waiting |= waits_there ? LaneMask{1} << k : 0;
    }
    const LaneMask awaited = lane.awaited & w.not_ended;
    if ((waiting & awaited) != awaited) continue;
    for_each_lane(waiting, [&w](u32 k) { w.lanes[k].state = LaneState::running; });
    return true;
  }
  return false;
}

/// Whether the first lane runs before the second.
bool precedes(const Lane& a, const Lane& b) {
  return a.register_base != b.register_base ? a.register_base > b.register_base : a.pc < b.pc;
}

/// Chooses the active lanes. Returns whether any lane can run.
bool choose_active(Warp& w) {
  const Lane* first = nullptr;
  for (const Lane& lane : w.lanes) {
    if (lane.state == LaneState::running && (first == nullptr || precedes(lane, *first))) first = &lane;
  }
  if (first == nullptr) return resume_waiting_lanes(w) && choose_active(w);
  LaneMask active = 0;
  w.lowest_other_pc = ~u32{0};
  for (u32 l = 0; l < kLanes; ++l) {
    const Lane& lane = w.lanes[l];
    if (lane.state != LaneState::running || lane.register_base != first->register_base) continue;
    if (lane.pc == first->pc) {
      active |= LaneMask{1} << l;
    } else {
      w.lowest_other_pc = std::min(w.lowest_other_pc, lane.pc);
    }
  }
  w.set_active(active);
  w.pc = first->pc;
  w.register_base = first->register_base;
  return true;
}

void execute_guarded(Warp& w, const Instruction& i) {
  const u64* const predicate = w.row(i.guard);
  LaneMask runs = 0;
  for (u32 l = 0; l < kLanes; ++l) runs |= static_cast<LaneMask>(((predicate[l] & 1U) != 0) != i.guard_negated) << l;
  const LaneMask all = w.active;
  if ((runs & all) == 0) return;
  w.set_active(runs & all);
  i.execute(w, i);
  w.set_active(all);
}

/// Runs the active lanes until they diverge, reach others, end, wait, or reach the instruction number given.
void run_active(Warp& w, u64 last_instruction) {
  LaunchCounts& counts = w.launch->counts;
  const auto lanes = static_cast<u64>(std::popcount(w.active));
  for (;;) {
    const Instruction& i = w.code[w.pc];
    ++w.instructions;
    ++counts.warp_instructions;
    counts.lane_instructions += lanes;
    if (i.kind != Kind::parameter) {
      ++counts.warp_instructions_of[static_cast<u32>(i.kind)];
      counts.lane_instructions_of[static_cast<u32>(i.kind)] += lanes;
    }
    if (w.launch->profile != nullptr) ++(*w.launch->profile)[w.pc];
    w.next_pc = w.pc + 1;
    if (i.guard != kNoRow && !i.is_control) {
      execute_guarded(w, i);
    } else {
      i.execute(w, i);
    }
    if (w.must_choose) return;
    w.pc = w.next_pc;
    if (w.pc >= w.lowest_other_pc || w.instructions >= last_instruction || w.pauses) {
      for_each_lane(w.active, [&w](u32 l) { w.lanes[l].pc = w.pc; });
      return;
    }
  }
}

}  // namespace

bool run(Warp& w, u64 budget) {
  bool any = false;
  const u64 last_instruction = w.instructions + budget;
  w.pauses = false;
  while (!w.pauses && w.instructions < last_instruction && choose_active(w)) {
    any = true;
    w.must_choose = false;
    run_active(w, last_instruction);
  }
  return any;
}

std::string thread_name(const Warp& w, u32 lane) {
  return formatted("block %u, thread %u of %s", w.block->number, w.thread_in_block(lane),
                   demangled(w.launch->kernel->name).c_str());
}

}  // namespace tetune::ptxsim

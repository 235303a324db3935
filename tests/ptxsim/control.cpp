// SPDX-License-Identifier: Apache-2.0
#include <cstring>

#include "ptxsim/lanes.hpp"
#include "ptxsim/problems.hpp"
#include "ptxsim/statement.hpp"

namespace tetune::ptxsim {
namespace {

/// The function that device code calls where an assertion fails, with the addresses of its text and file, and the line.
constexpr const char* kAssertFail = "__assertfail";

void report_assertion(Warp& w, const Instruction& i) {
  const u32 lane = w.first_active();
  const char* const frame = w.stack(lane) + w.lanes[lane].stack_begin;
  const char* condition = nullptr;
  const char* file = nullptr;
  u32 line = 0;
  std::memcpy(&condition, frame + i.arguments[0], sizeof condition);
  std::memcpy(&file, frame + i.arguments[1], sizeof file);
  std::memcpy(&line, frame + i.arguments[2], sizeof line);
  problems().report(Fault::assertion, &i, [&] {
    return formatted("assertion failed: %s, %s:%u\n  %s", condition, file, line, thread_name(w, lane).c_str());
  });
}

void execute_trap(Warp& w, const Instruction& i) {
  problems().report(Fault::trap, &i,
                    [&] { return "trap\n  " + thread_name(w, w.first_active()) + "\n  " + place_of(i); });
  end_lanes(w);
}

void execute_exit(Warp& w, const Instruction&) { end_lanes(w); }

/// Fences, prefetches: without effect where memory is sequentially consistent and has no cache.
void execute_nothing(Warp&, const Instruction&) {}

void execute_pause(Warp& w, const Instruction&) { w.pauses = true; }

/// The combined predicate that threads at a barrier receive.
enum Reduction : u8 { kCount, kAny, kAll };

bool decode_exit(const Statement&, Scope&, Instruction& i) {
  i.execute = execute_exit;
  i.kind = Kind::branch;
  i.is_control = true;
  return i.guard == kNoRow;
}

bool decode_return(const Statement&, Scope&, Instruction& i) {
  i.execute = execute_return;
  i.kind = Kind::branch;
  i.is_control = true;
  return i.guard == kNoRow;
}

bool decode_trap(const Statement&, Scope&, Instruction& i) {
  i.execute = execute_trap;
  i.is_control = true;
  return i.guard == kNoRow;
}

bool decode_nothing(const Statement&, Scope&, Instruction& i) {
  i.execute = execute_nothing;
  i.kind = Kind::sync;
  return true;
}

bool decode_sleep(const Statement&, Scope&, Instruction& i) {
  i.execute = execute_pause;
  i.kind = Kind::sync;
  return true;
}

/// Threads arrive at a barrier of their block: `a` is its number, `b` how many it awaits, `c` a predicate to reduce.
void execute_barrier(Warp& w, const Instruction& i) {
  Block& block = *w.block;
  const u64* const number = w.row(i.a);
  const u64* const expected = w.row_or_null(i.b);
  const u64* const predicate = w.row_or_null(i.c);
  u64* const to = w.row_or_null(i.to);
  u32 id = 0;
  for_each_lane(w.active, [&](u32 l) {
    id = static_cast<u32>(number[l]) % kBarriers;
    Barrier& barrier = block.barriers[id];
    ++barrier.arrived;
    if (expected != nullptr) barrier.expected = static_cast<u32>(expected[l]);
    if (predicate != nullptr) {
      const bool holds = ((predicate[l] & 1U) != 0) != i.negated;
      barrier.any |= holds;
      barrier.all &= holds;
      barrier.count += holds ? 1 : 0;
    }
    w.lanes[l].barrier = id;
    w.lanes[l].barrier_result = to == nullptr ? nullptr : to + l;
    w.lanes[l].state = LaneState::at_barrier;
    w.lanes[l].pc = w.pc + 1;
  });
  w.must_choose = true;
  release_if_complete(block, id);
}

}  // namespace

void release_if_complete(Block& block, u32 id) {
  Barrier& barrier = block.barriers[id];
  const u32 expected = barrier.expected != 0 ? barrier.expected : block.running;
  if (barrier.arrived == 0 || barrier.arrived < expected) return;
  for (const auto& w : block.warps) {
    for (Lane& lane : w->lanes) {
      if (lane.state != LaneState::at_barrier || lane.barrier != id) continue;
      lane.state = LaneState::running;
      if (lane.barrier_result == nullptr) continue;
      const u8 reduction = w->code[lane.pc - 1].variant;
      *lane.barrier_result = reduction == kAny   ? u64{barrier.any}
                             : reduction == kAll ? u64{barrier.all}
                                                 : u64{barrier.count};
    }
  }
  barrier = {};
  advance_epoch(block);
}

void advance_epoch(Block& block) { ++block.epoch; }

void end_lanes(Warp& w) {
  for_each_lane(w.active, [&w](u32 l) {
    w.lanes[l].state = LaneState::ended;
    --w.block->running;
  });
  w.not_ended &= ~w.active;
  w.must_choose = true;
  for (u32 id = 0; id < kBarriers; ++id) release_if_complete(*w.block, id);
}

bool decode_block_barrier(const Statement& s, Scope&, Instruction& i) {
  i.execute = execute_barrier;
  i.kind = Kind::sync;
  i.is_control = true;
  if (i.guard != kNoRow) return false;
  const std::vector<Operand>& o = s.operands;
  if (s.has("sync")) {
    i.a = o[0].row;
    if (o.size() > 1) i.b = o[1].row;
    return true;
  }
  if (!s.has("red")) return false;
  i.variant = s.has("or") ? kAny : s.has("and") ? kAll : kCount;
  i.to = o[0].row;
  i.a = o[1].row;
  i.c = o.back().row;
  i.negated = o.back().negated;
  if (o.size() == 4) i.b = o[2].row;
  return true;
}

void execute_branch(Warp& w, const Instruction& i) {
  const auto target = static_cast<u32>(i.immediate);
  LaneMask taken = w.active;
  if (i.guard != kNoRow) {
    const u64* const predicate = w.row(i.guard);
    LaneMask holds = 0;
    for (u32 l = 0; l < kLanes; ++l) holds |= static_cast<LaneMask>(predicate[l] & 1U) << l;
    taken &= i.guard_negated ? ~holds : holds;
  }
  if (taken == w.active) {
    w.next_pc = target;
  } else if (taken != 0) {
    for_each_lane(w.active, [&](u32 l) { w.lanes[l].pc = (taken >> l & 1U) != 0 ? target : w.pc + 1; });
    w.must_choose = true;
  }
}

void execute_call(Warp& w, const Instruction& i) {
  const Function& callee = *i.callee;
  if (callee.name == kAssertFail) {
    report_assertion(w, i);
    end_lanes(w);
    return;
  }
  if (!callee.is_defined) fatal("call of " + callee.name + ", which has no code");
  const Function& caller = *i.function;
  for_each_lane(w.active, [&](u32 l) {
    Lane& lane = w.lanes[l];
    const u32 begin = aligned(lane.stack_begin + caller.frame_bytes, 16);
    if (begin + callee.frame_bytes > kStackBytes) fatal("the stack is too small");
    char* const stack = w.stack(l);
    for (std::size_t k = 0; k < callee.parameters.size(); ++k) {
      const Slot& parameter = callee.parameters[k];
      std::memcpy(stack + begin + parameter.offset, stack + lane.stack_begin + i.arguments[k], parameter.bytes);
    }
    lane.calls.push_back({w.pc + 1, lane.register_base, lane.stack_begin, lane.stack_end, &i});
    lane.register_base += caller.registers;
    lane.stack_begin = begin;
    lane.stack_end = begin + callee.frame_bytes;
    lane.pc = callee.begin;
    w.launch->counts.stack_bytes = std::max<u64>(w.launch->counts.stack_bytes, lane.stack_end);
  });
  if (w.register_base + caller.registers + callee.registers > w.register_rows) fatal("too few registers");
  w.must_choose = true;
}

void execute_return(Warp& w, const Instruction& i) {
  if (w.lanes[w.first_active()].calls.empty()) {
    end_lanes(w);
    return;
  }
  const std::vector<Slot>& results = i.function->results;
  for_each_lane(w.active, [&](u32 l) {
    Lane& lane = w.lanes[l];
    const CallFrame caller = lane.calls.back();
    lane.calls.pop_back();
    char* const stack = w.stack(l);
    for (std::size_t k = 0; k < results.size(); ++k) {
      const u32 to = caller.call->arguments[i.function->parameters.size() + k];
      std::memcpy(stack + caller.stack_begin + to, stack + lane.stack_begin + results[k].offset, results[k].bytes);
    }
    lane.pc = caller.pc;
    lane.register_base = caller.register_base;
    lane.stack_begin = caller.stack_begin;
    lane.stack_end = caller.stack_end;
  });
  w.must_choose = true;
}

void execute_unsupported(Warp&, const Instruction& i) { fatal("not supported: " + place_of(i)); }

void add_control(DecodeTable& table) {
  table["ret"] = decode_return;
  table["exit"] = decode_exit;
  table["trap"] = decode_trap;
  table["nanosleep"] = decode_sleep;
  for (const char* name : {"membar", "fence", "prefetch", "prefetchu", "brkpt", "discard"})
    table[name] = decode_nothing;
}

}  // namespace tetune::ptxsim

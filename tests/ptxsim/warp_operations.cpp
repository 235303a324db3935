// SPDX-License-Identifier: Apache-2.0
// Operations in which the lanes of a warp exchange values. Each names the lanes that take part.
#include "ptxsim/lanes.hpp"
#include "ptxsim/problems.hpp"
#include "ptxsim/statement.hpp"

namespace tetune::ptxsim {
namespace {

/// The lanes of `among` whose operand names `mask`.
LaneMask lanes_that_name(const u64* named, LaneMask mask, LaneMask among) {
  LaneMask lanes = 0;
  for_each_lane(among,
                [&](u32 l) { lanes |= static_cast<LaneMask>(named[l]) == mask ? LaneMask{1} << l : LaneMask{0}; });
  return lanes;
}

/// Whether all lanes of a group, which name `mask`, are active. If not, the active ones wait for the others, or all of
/// them run where the others wait here already.
bool group_arrived(Warp& w, LaneMask group, LaneMask mask, const Instruction& i) {
  if ((group & ~mask) != 0) {
    problems().report(Fault::unnamed_lane, &i, [&] {
      return formatted("an operation of the lanes %08x is run by the lanes %08x\n  %s\n  %s", mask, group,
                       thread_name(w, static_cast<u32>(std::countr_zero(group))).c_str(), place_of(i).c_str());
    });
    return true;
  }
  const LaneMask awaited = mask & w.not_ended;
  if ((group & awaited) == awaited) return true;
  LaneMask here = group;
  for (u32 l = 0; l < kLanes; ++l) {
    const Lane& lane = w.lanes[l];
    const bool waits = lane.state == LaneState::at_warp_sync && lane.pc == w.pc && lane.awaited == mask &&
                       lane.register_base == w.register_base;
    here |= waits ? LaneMask{1} << l : 0;
  }
  const bool complete = (here & awaited) == awaited;
  for_each_lane(here, [&](u32 l) {
    w.lanes[l].state = complete ? LaneState::running : LaneState::at_warp_sync;
    w.lanes[l].awaited = mask;
  });
  return false;
}

/// Whether all lanes that take part are here, in each of the groups of active lanes that name the same lanes. If not,
/// the active lanes are chosen again.
bool all_arrived(Warp& w, Row row, const Instruction& i) {
  const u64* const named = w.row(row);
  bool all = true;
  for (LaneMask rest = w.active; rest != 0;) {
    const auto mask = static_cast<LaneMask>(named[std::countr_zero(rest)]);
    const LaneMask group = lanes_that_name(named, mask, rest);
    all = group_arrived(w, group, mask, i) && all;
    rest &= ~group;
  }
  if (all) return true;
  for_each_lane(w.active, [&w](u32 l) { w.lanes[l].pc = w.pc; });
  w.must_choose = true;
  return false;
}

/// In a block of one warp, a barrier of all threads orders their accesses as a barrier of the block does.
void execute_warp_barrier(Warp& w, const Instruction& i) {
  const auto named = static_cast<LaneMask>(w.row(i.a)[w.first_active()]);
  if (all_arrived(w, i.a, i) && w.block->warps.size() == 1 && (w.not_ended & ~named) == 0) advance_epoch(*w.block);
}

enum Shuffle : u8 { kUp, kDown, kButterfly, kIndexed };

/// The lane that a shuffle reads, and whether it is in the segment; else a lane reads itself.
struct Source {
  u32 lane;
  bool in_segment;
};
Source source_of(u32 lane, u32 b, u32 clamp, u8 shuffle) {
  const u32 offset = b & 31U;
  const u32 segment = clamp >> 8U & 31U;
  const u32 limit = (lane & segment) | (clamp & 31U & ~segment);
  u32 source = 0;
  bool in_segment = false;
  if (shuffle == kUp) {
    source = lane - offset;
    in_segment = lane >= offset && source >= limit;
  } else {
    source = shuffle == kDown        ? lane + offset
             : shuffle == kButterfly ? lane ^ offset
                                     : (lane & segment) | (offset & ~segment);
    in_segment = source <= limit;
  }
  return {in_segment ? source : lane, in_segment};
}

void execute_shuffle(Warp& w, const Instruction& i) {
  if (!all_arrived(w, i.d, i)) return;
  const u64* const a = w.row(i.a);
  const u64* const b = w.row(i.b);
  const u64* const clamp = w.row(i.c);
  const u64* const named = w.row(i.d);
  u64 value[kLanes] = {};
  bool in_segment[kLanes] = {};
  for_each_lane(w.active, [&](u32 l) {
    const Source source = source_of(l, static_cast<u32>(b[l]), static_cast<u32>(clamp[l]), i.variant);
    if (((w.active & named[l]) >> source.lane & 1U) == 0) {
      problems().report(Fault::absent_lane, &i, [&] {
        return formatted("a shuffle reads lane %u, which does not take part\n  %s\n  %s", source.lane,
                         thread_name(w, l).c_str(), place_of(i).c_str());
      });
    }
    value[l] = static_cast<u32>(a[source.lane]);
    in_segment[l] = source.in_segment;
  });
  u64* const to = w.row_or_null(i.to);
  u64* const valid = w.row_or_null(i.second_to);
  for_each_lane(w.active, [&](u32 l) {
    if (to != nullptr) to[l] = value[l];
    if (valid != nullptr) valid[l] = in_segment[l] ? 1 : 0;
  });
}

enum Vote : u8 { kAll, kAny, kUniform, kBallot };

void execute_vote(Warp& w, const Instruction& i) {
  if (!all_arrived(w, i.b, i)) return;
  const u64* const predicate = w.row(i.a);
  LaneMask votes = 0;
  for_each_lane(w.active,
                [&](u32 l) { votes |= ((predicate[l] & 1U) != 0) != i.negated ? LaneMask{1} << l : LaneMask{0}; });
  const u64* const named = w.row(i.b);
  u64* const to = w.row(i.to);
  for_each_lane(w.active, [&](u32 l) {
    const LaneMask group = w.active & static_cast<LaneMask>(named[l]);
    const LaneMask own = votes & group;
    to[l] = i.variant == kBallot ? u64{own}
            : i.variant == kAll  ? u64{own == group}
            : i.variant == kAny  ? u64{own != 0}
                                 : u64{own == group || own == 0};
  });
}

void execute_match(Warp& w, const Instruction& i) {
  if (!all_arrived(w, i.b, i)) return;
  const u64* const a = w.row(i.a);
  const u64 compared = i.bytes == 8 ? ~u64{0} : 0xffffffffU;
  u64 equal[kLanes] = {};
  const u64* const named = w.row(i.b);
  for_each_lane(w.active, [&](u32 l) {
    const LaneMask group = w.active & static_cast<LaneMask>(named[l]);
    for_each_lane(group, [&](u32 other) { equal[l] |= ((a[l] ^ a[other]) & compared) == 0 ? u64{1} << other : 0; });
  });
  u64* const to = w.row(i.to);
  for_each_lane(w.active, [&](u32 l) { to[l] = equal[l]; });
}

void execute_active_mask(Warp& w, const Instruction& i) {
  u64* const to = w.row(i.to);
  for_each_lane(w.active, [&](u32 l) { to[l] = w.active; });
}

bool decode_synchronizing(Execute execute, u32 operands, const Statement& s, Instruction& i) {
  i.execute = execute;
  i.kind = Kind::sync;
  i.is_control = true;
  return s.has("sync") && i.guard == kNoRow && take_rows(s, operands, i);
}

bool decode_shuffle(const Statement& s, Scope&, Instruction& i) {
  i.variant = s.has("up") ? kUp : s.has("down") ? kDown : s.has("bfly") ? kButterfly : kIndexed;
  i.second_to = s.operands[0].second_row;
  return decode_synchronizing(execute_shuffle, 5, s, i);
}

bool decode_vote(const Statement& s, Scope&, Instruction& i) {
  i.variant = s.has("all") ? kAll : s.has("any") ? kAny : s.has("uni") ? kUniform : kBallot;
  i.negated = s.operands[1].negated;
  return decode_synchronizing(execute_vote, 3, s, i);
}

bool decode_match(const Statement& s, Scope&, Instruction& i) {
  i.bytes = static_cast<u8>(s.type().bits / 8);
  return s.has("any") && decode_synchronizing(execute_match, 3, s, i);
}

bool decode_active_mask(const Statement& s, Scope&, Instruction& i) {
  i.execute = execute_active_mask;
  i.kind = Kind::sync;
  return take_rows(s, 1, i);
}

bool decode_barrier(const Statement& s, Scope& scope, Instruction& i) {
  if (!s.has("warp")) return decode_block_barrier(s, scope, i);
  i.execute = execute_warp_barrier;
  i.kind = Kind::sync;
  i.is_control = true;
  i.a = s.operands[0].row;
  return i.guard == kNoRow;
}

}  // namespace

void add_warp_operations(DecodeTable& table) {
  table["bar"] = decode_barrier;
  table["barrier"] = decode_barrier;
  table["shfl"] = decode_shuffle;
  table["vote"] = decode_vote;
  table["match"] = decode_match;
  table["activemask"] = decode_active_mask;
}

}  // namespace tetune::ptxsim

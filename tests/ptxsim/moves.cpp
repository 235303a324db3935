// SPDX-License-Identifier: Apache-2.0
#include "ptxsim/lanes.hpp"
#include "ptxsim/statement.hpp"

namespace tetune::ptxsim {
namespace {

struct Copy {
  static u64 of(u64 a) { return a; }
};
struct CopyPredicate {
  static u64 of(u64 a) { return a != 0 ? 1 : 0; }
};

/// The address of a variable in the frame.
void frame_address(Warp& w, const Instruction& i) {
  u64* const to = w.row(i.to);
  for_each_lane(w.active, [&](u32 l) { to[l] = w.lanes[l].stack_begin + static_cast<u64>(i.immediate); });
}

void add_immediate(Warp& w, const Instruction& i) {
  const u64* const a = w.row(i.a);
  map_lanes(w, i.to, [a, &i](u32 l) { return a[l] + static_cast<u64>(i.immediate); });
}

u64 element_mask(u32 bytes) { return bytes == 8 ? ~u64{0} : (u64{1} << (8 * bytes)) - 1; }

void pack(Warp& w, const Instruction& i) {
  u64* const to = w.row(i.to);
  for_each_lane(w.active, [&](u32 l) {
    u64 packed = 0;
    for (u32 k = 0; k < i.elements; ++k) packed |= (w.row(i.vector[k])[l] & element_mask(i.bytes)) << (8 * k * i.bytes);
    to[l] = packed;
  });
}

void unpack(Warp& w, const Instruction& i) {
  const u64* const a = w.row(i.a);
  for_each_lane(w.active, [&](u32 l) {
    const u64 packed = a[l];
    for (u32 k = 0; k < i.elements; ++k) {
      if (i.vector[k] != kNoRow) w.row(i.vector[k])[l] = packed >> (8 * k * i.bytes) & element_mask(i.bytes);
    }
  });
}

u64 tag_of(Space space) {
  return space == Space::shared      ? kSharedTag
         : space == Space::local     ? kLocalTag
         : space == Space::parameter ? kParameterTag
                                     : 0;
}

void is_in_space(Warp& w, const Instruction& i) {
  const u64* const a = w.row(i.a);
  const u64 tag = tag_of(i.space);
  map_lanes(w, i.to, [a, tag](u32 l) { return u64{(a[l] & kTagMask) == tag}; });
}

using ReadSpecial = u64 (*)(const Warp&, u32 lane);

u64 bit(u32 lane) { return u64{1} << lane; }

const std::map<std::string_view, ReadSpecial>& special_registers() {
  static const std::map<std::string_view, ReadSpecial> registers = {
      {"%tid.x", [](const Warp& w, u32 l) -> u64 { return w.lanes[l].thread[0]; }},
      {"%tid.y", [](const Warp& w, u32 l) -> u64 { return w.lanes[l].thread[1]; }},
      {"%tid.z", [](const Warp& w, u32 l) -> u64 { return w.lanes[l].thread[2]; }},
      {"%ntid.x", [](const Warp& w, u32) -> u64 { return w.launch->block.x; }},
      {"%ntid.y", [](const Warp& w, u32) -> u64 { return w.launch->block.y; }},
      {"%ntid.z", [](const Warp& w, u32) -> u64 { return w.launch->block.z; }},
      {"%ctaid.x", [](const Warp& w, u32) -> u64 { return w.block->index[0]; }},
      {"%ctaid.y", [](const Warp& w, u32) -> u64 { return w.block->index[1]; }},
      {"%ctaid.z", [](const Warp& w, u32) -> u64 { return w.block->index[2]; }},
      {"%nctaid.x", [](const Warp& w, u32) -> u64 { return w.launch->grid.x; }},
      {"%nctaid.y", [](const Warp& w, u32) -> u64 { return w.launch->grid.y; }},
      {"%nctaid.z", [](const Warp& w, u32) -> u64 { return w.launch->grid.z; }},
      {"%laneid", [](const Warp&, u32 l) -> u64 { return l; }},
      {"%warpid", [](const Warp& w, u32) -> u64 { return w.id; }},
      {"%lanemask_lt", [](const Warp&, u32 l) -> u64 { return bit(l) - 1; }},
      {"%lanemask_le", [](const Warp&, u32 l) -> u64 { return bit(l + 1) - 1; }},
      {"%lanemask_gt", [](const Warp&, u32 l) -> u64 { return ~u32{0} & ~(bit(l + 1) - 1); }},
      {"%lanemask_ge", [](const Warp&, u32 l) -> u64 { return ~u32{0} & ~(bit(l) - 1); }},
      {"%lanemask_eq", [](const Warp&, u32 l) -> u64 { return bit(l); }},
      {"%clock", [](const Warp& w, u32) -> u64 { return w.instructions; }},
      {"%clock64", [](const Warp& w, u32) -> u64 { return w.instructions; }},
      {"%smid", [](const Warp&, u32) -> u64 { return 0; }}};
  return registers;
}

/// `immediate` is the function that reads the register.
void read_special(Warp& w, const Instruction& i) {
  const auto read = reinterpret_cast<ReadSpecial>(i.immediate);
  u64* const to = w.row(i.to);
  for_each_lane(w.active, [&](u32 l) { to[l] = read(w, l); });
}

/// `offset` is added to the address.
bool decode_address(const Operand& symbol, u64 offset, Scope& scope, Instruction& i) {
  if (const auto special = special_registers().find(symbol.name); special != special_registers().end()) {
    i.execute = read_special;
    i.immediate = reinterpret_cast<i64>(special->second);
    return true;
  }
  if (const Slot* const variable = scope.frame_variable(symbol.name)) {
    i.execute = frame_address;
    i.immediate = static_cast<i64>(variable->offset + symbol.value + offset);
    return true;
  }
  u64 address = 0;
  if (!scope.address_of(symbol.name, address)) return false;
  i.execute = &unary<u64, Copy>;
  i.a = scope.constant(address + symbol.value + offset);
  return true;
}

void take_elements(const Operand& vector, u32 bytes, Instruction& i) {
  i.elements = static_cast<u8>(vector.elements.size());
  i.bytes = static_cast<u8>(bytes / i.elements);
  for (u32 k = 0; k < i.elements; ++k) i.vector[k] = vector.elements[k].row;
}

bool decode_move(const Statement& s, Scope& scope, Instruction& i) {
  i.kind = Kind::move;
  const Operand& to = s.operands[0];
  const Operand& from = s.operands[1];
  const Type t = s.type();
  if (to.elements.size() > kMaxVector || from.elements.size() > kMaxVector) return false;
  if (to.form == Operand::Form::vector) {
    i.execute = unpack;
    i.a = from.row;
    take_elements(to, t.bits / 8, i);
    return true;
  }
  i.to = to.row;
  if (from.form == Operand::Form::vector) {
    i.execute = pack;
    take_elements(from, t.bits / 8, i);
    return true;
  }
  if (from.form == Operand::Form::symbol) return decode_address(from, 0, scope, i);
  i.a = from.row;
  i.execute = t.kind == 'p' ? &unary<u64, CopyPredicate> : &unary<u64, Copy>;
  return true;
}

Space space_named_in(const Statement& s) {
  return s.has("shared")  ? Space::shared
         : s.has("local") ? Space::local
         : s.has("param") ? Space::parameter
                          : Space::global;
}

/// To and from generic addresses.
bool decode_convert_address(const Statement& s, Scope& scope, Instruction& i) {
  i.kind = Kind::move;
  const u64 tag = tag_of(space_named_in(s));
  const u64 offset = s.has("to") ? 0 - tag : tag;
  i.to = s.operands[0].row;
  if (s.operands[1].form == Operand::Form::symbol) return decode_address(s.operands[1], offset, scope, i);
  i.execute = add_immediate;
  i.immediate = static_cast<i64>(offset);
  return take_rows(s, 2, i);
}

bool decode_is_in_space(const Statement& s, Scope&, Instruction& i) {
  i.execute = is_in_space;
  i.space = space_named_in(s);
  return take_rows(s, 2, i);
}

}  // namespace

void add_moves(DecodeTable& table) {
  table["mov"] = decode_move;
  table["cvta"] = decode_convert_address;
  table["isspacep"] = decode_is_in_space;
}

}  // namespace tetune::ptxsim

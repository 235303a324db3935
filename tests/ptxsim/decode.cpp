// SPDX-License-Identifier: Apache-2.0
#include <charconv>

#include "ptxsim/statement.hpp"

namespace tetune::ptxsim {
namespace {

const DecodeTable& decode_table() {
  static const DecodeTable table = [] {
    DecodeTable all;
    for (const auto add : {add_arithmetic, add_comparisons, add_bit_operations, add_conversions, add_moves,
                           add_memory_accesses, add_atomics, add_control, add_warp_operations}) {
      add(all);
    }
    return all;
  }();
  return table;
}

}  // namespace

const char* name_of(Kind kind) {
  static const char* const names[kKinds] = {"integer", "f64",    "f64_division", "f32",    "move", "load",     "store",
                                            "local",   "shared", "atomic",       "branch", "sync", "parameter"};
  return names[static_cast<u32>(kind)];
}

Type type_of(std::string_view text) {
  if (text == "pred") return {'p', 1};
  if (text.size() < 2 || std::string_view("usbf").find(text[0]) == std::string_view::npos) return {};
  Type type{text[0], 0};
  const auto [end, error] = std::from_chars(text.data() + 1, text.data() + text.size(), type.bits);
  return error == std::errc() && end == text.data() + text.size() ? type : Type{};
}

bool take_rows(const Statement& s, u32 count, Instruction& i) {
  Row* const rows[] = {&i.to, &i.a, &i.b, &i.c, &i.d};
  if (s.operands.size() < count) return false;
  for (u32 k = 0; k < count; ++k) {
    if (s.operands[k].form != Operand::Form::row) return false;
    *rows[k] = s.operands[k].row;
  }
  return true;
}

bool take_address(const Operand& address, Scope& scope, Instruction& i) {
  if (address.form != Operand::Form::address) return false;
  i.immediate = static_cast<i64>(address.value);
  if (address.name.empty()) {
    i.a = address.row;
    return true;
  }
  if (const Slot* const variable = scope.frame_variable(address.name)) {
    i.space = Space::frame;
    i.immediate += variable->offset;
    return true;
  }
  u64 symbol = 0;
  if (!scope.address_of(address.name, symbol)) return false;
  i.immediate += static_cast<i64>(symbol);
  return true;
}

bool decode(const Statement& s, Scope& scope, Instruction& i) {
  const auto found = decode_table().find(s.operation);
  return found != decode_table().end() && found->second(s, scope, i) && i.execute != nullptr;
}

}  // namespace tetune::ptxsim

// SPDX-License-Identifier: Apache-2.0
#include <cstring>

#include "ptxsim/global_memory.hpp"
#include "ptxsim/lanes.hpp"
#include "ptxsim/memory_counts.hpp"
#include "ptxsim/statement.hpp"

namespace tetune::ptxsim {
namespace {

u64 address_of(const Warp& w, const Instruction& i, const u64* base, u32 lane) {
  const u64 address = (base == nullptr ? 0 : base[lane]) + static_cast<u64>(i.immediate);
  return i.space == Space::frame ? address + w.lanes[lane].stack_begin : address;
}

/// Of `elements` values of type T per lane, which one check covers; signed values are extended by their sign.
template <class T, u32 elements>
struct Load {
  static void run(Warp& w, const Instruction& i) {
    constexpr u32 bytes = elements * sizeof(T);
    const u64* const base = w.row_or_null(i.a);
    u64* to[elements];
    for (u32 k = 0; k < elements; ++k) to[k] = w.row_or_null(i.vector[k]);
    AccessCounter counter(w, bytes, Kind::load);
    for_each_lane(w.active, [&](u32 l) {
      const u64 address = address_of(w, i, base, l);
      Space space{};
      const char* from = resolve(w, l, address, bytes, Access::read, i, space);
      counter.add(l, address, space);
      T values[elements];
      std::memcpy(values, from, bytes);
      for (u32 k = 0; k < elements; ++k) {
        if (to[k] != nullptr) to[k][l] = static_cast<u64>(values[k]);
      }
    });
  }
};

template <class T, u32 elements>
struct Store {
  static void run(Warp& w, const Instruction& i) {
    constexpr u32 bytes = elements * sizeof(T);
    const u64* const base = w.row_or_null(i.a);
    const u64* from[elements];
    for (u32 k = 0; k < elements; ++k) from[k] = w.row(i.vector[k]);
    AccessCounter counter(w, bytes, Kind::store);
    for_each_lane(w.active, [&](u32 l) {
      const u64 address = address_of(w, i, base, l);
      Space space{};
      char* const to = resolve(w, l, address, bytes, Access::write, i, space);
      counter.add(l, address, space);
      T values[elements];
      for (u32 k = 0; k < elements; ++k) values[k] = static_cast<T>(from[k][l]);
      std::memcpy(to, values, bytes);
    });
  }
};

template <template <class, u32> class Operation, class T>
Execute access_of(u32 elements) {
  return elements == 4 ? &Operation<T, 4>::run : elements == 2 ? &Operation<T, 2>::run : &Operation<T, 1>::run;
}

/// The function for elements of a size; unsigned for stores, which cut.
template <template <class, u32> class Operation>
Execute access_of(u32 bytes, bool is_signed, u32 elements) {
  switch (bytes) {
    case 8:
      return access_of<Operation, u64>(elements);
    case 4:
      return is_signed ? access_of<Operation, i32>(elements) : access_of<Operation, u32>(elements);
    case 2:
      return is_signed ? access_of<Operation, i16>(elements) : access_of<Operation, u16>(elements);
    default:
      return is_signed ? access_of<Operation, i8>(elements) : access_of<Operation, u8>(elements);
  }
}

Space space_of(const Statement& s) {
  if (s.has("global") || s.has("const")) return Space::global;
  if (s.has("shared") || s.has("shared::cta")) return Space::shared;
  if (s.has("local")) return Space::local;
  return s.has("param") ? Space::parameter : Space::generic;
}

bool decode_access(const Statement& s, const Operand& address, const Operand& value, Scope& scope, Instruction& i) {
  const Type t = s.type();
  // Counted where the space of the addresses is known.
  i.kind = Kind::parameter;
  i.strong = s.has("volatile") || s.has("relaxed") || s.has("acquire") || s.has("release");
  i.bytes = static_cast<u8>(t.kind == 'p' ? 1 : t.bits / 8);
  i.is_signed = t.is_signed();
  i.elements = s.has("v4") ? 4 : s.has("v2") ? 2 : 1;
  i.space = space_of(s);
  if (address.form != Operand::Form::address || t.bits > 64 || value.form == Operand::Form::symbol) return false;
  if (value.form == Operand::Form::vector) {
    if (value.elements.size() != i.elements) return false;
    for (u32 k = 0; k < i.elements; ++k) i.vector[k] = value.elements[k].row;
  } else {
    i.vector[0] = value.row;
  }
  return take_address(address, scope, i);
}

bool decode_load(const Statement& s, Scope& scope, Instruction& i) {
  if (!decode_access(s, s.operands[1], s.operands[0], scope, i)) return false;
  i.execute = access_of<Load>(i.bytes, i.is_signed, i.elements);
  return true;
}

bool decode_store(const Statement& s, Scope& scope, Instruction& i) {
  if (!decode_access(s, s.operands[0], s.operands[1], scope, i)) return false;
  i.execute = access_of<Store>(i.bytes, false, i.elements);
  return true;
}

// -- Atomic operations --

enum Atomic : u8 { kAdd, kMin, kMax, kAnd, kOr, kXor, kExchange, kCompareExchange, kIncrement, kDecrement };

template <class T>
T updated(T old, T value, T other, u8 operation) {
  switch (operation) {
    case kMin:
      return value < old ? value : old;
    case kMax:
      return value > old ? value : old;
    case kExchange:
      return value;
    case kCompareExchange:
      return old == value ? other : old;
    case kAdd:
      if constexpr (std::is_floating_point_v<T>)
        return old + value;
      else
        return static_cast<T>(static_cast<u64>(old) + static_cast<u64>(value));
    default:
      break;
  }
  if constexpr (std::is_integral_v<T>) {
    switch (operation) {
      case kAnd:
        return static_cast<T>(old & value);
      case kOr:
        return static_cast<T>(old | value);
      case kXor:
        return static_cast<T>(old ^ value);
      case kIncrement:
        return old >= value ? T{0} : static_cast<T>(old + 1);
      case kDecrement:
        return old == 0 || old > value ? value : static_cast<T>(old - 1);
      default:
        break;
    }
  }
  return old;
}

/// Returns the old value.
template <class T>
u64 update(char* memory, u64 value, u64 other, u8 operation) {
  T old{};
  std::memcpy(&old, memory, sizeof old);
  const T result = updated(old, value_of<T>(value), value_of<T>(other), operation);
  std::memcpy(memory, &result, sizeof result);
  return bits_of(old);
}

using Update = u64 (*)(char*, u64, u64, u8);
Update update_for(const Instruction& i) {
  if (i.type == 'f') return i.bytes == 8 ? &update<double> : &update<float>;
  if (i.type == 's') return i.bytes == 8 ? &update<i64> : &update<i32>;
  return i.bytes == 8 ? &update<u64> : i.bytes == 4 ? &update<u32> : &update<u16>;
}

void execute_atomic(Warp& w, const Instruction& i) {
  const u64* const base = w.row_or_null(i.a);
  const u64* const value = w.row(i.b);
  const u64* const other = w.row_or_null(i.c);
  u64* const to = w.row_or_null(i.to);
  const Update update = update_for(i);
  AccessCounter counter(w, i.bytes, Kind::atomic);
  for_each_lane(w.active, [&](u32 l) {
    const u64 address = address_of(w, i, base, l);
    Space space{};
    char* const memory = resolve(w, l, address, i.bytes, Access::atomic, i, space);
    counter.add(l, address, space);
    const u64 old = update(memory, value[l], other == nullptr ? 0 : other[l], i.variant);
    if (to != nullptr) to[l] = old;
  });
}

bool decode_atomic(const Statement& s, Scope& scope, Instruction& i) {
  static const std::pair<const char*, Atomic> operations[] = {
      {"add", kAdd},       {"min", kMin},      {"max", kMax},       {"and", kAnd},
      {"or", kOr},         {"xor", kXor},      {"exch", kExchange}, {"cas", kCompareExchange},
      {"inc", kIncrement}, {"dec", kDecrement}};
  const auto* const found =
      std::find_if(std::begin(operations), std::end(operations), [&s](const auto& o) { return s.has(o.first); });
  const Type t = s.type();
  if (found == std::end(operations) || t.bits < 16 || t.bits > 64) return false;
  i.execute = execute_atomic;
  i.kind = Kind::parameter;
  i.variant = found->second;
  i.bytes = static_cast<u8>(t.bits / 8);
  i.type = t.kind;
  i.space = space_of(s);
  std::size_t operand = 0;
  if (s.operation == "atom") i.to = s.operands[operand++].row;
  const Operand& address = s.operands[operand++];
  i.b = s.operands[operand++].row;
  if (operand < s.operands.size()) i.c = s.operands[operand].row;
  return take_address(address, scope, i);
}

}  // namespace

void add_memory_accesses(DecodeTable& table) {
  table["ld"] = decode_load;
  table["ldu"] = decode_load;
  table["st"] = decode_store;
}

void add_atomics(DecodeTable& table) {
  table["atom"] = decode_atomic;
  table["red"] = decode_atomic;
}

}  // namespace tetune::ptxsim

// SPDX-License-Identifier: Apache-2.0
#include "ptxsim/lanes.hpp"
#include "ptxsim/statement.hpp"

namespace tetune::ptxsim {
namespace {

struct And {
  template <class T>
  static T of(T a, T b) {
    return static_cast<T>(a & b);
  }
};
struct Or {
  template <class T>
  static T of(T a, T b) {
    return static_cast<T>(a | b);
  }
};
struct Xor {
  template <class T>
  static T of(T a, T b) {
    return static_cast<T>(a ^ b);
  }
};
struct Not {
  template <class T>
  static T of(T a) {
    return static_cast<T>(~a);
  }
};
struct NotPredicate {
  static u64 of(u64 a) { return (a & 1U) ^ 1U; }
};
struct IsZero {
  template <class T>
  static T of(T a) {
    return a == 0 ? T{1} : T{0};
  }
};
struct CountOnes {
  template <class T>
  static u32 of(T a) {
    return static_cast<u32>(std::popcount(a));
  }
};
struct CountLeadingZeros {
  template <class T>
  static u32 of(T a) {
    return static_cast<u32>(std::countl_zero(a));
  }
};
struct Reverse {
  template <class T>
  static T of(T a) {
    T reversed = 0;
    for (u32 bit = 0; bit < 8 * sizeof(T); ++bit) reversed = static_cast<T>(reversed << 1U | (a >> bit & 1U));
    return reversed;
  }
};
/// The position of the highest bit that is not the sign; all ones if there is none.
struct FindHighest {
  template <class T>
  static u32 of(T a) {
    using U = std::make_unsigned_t<T>;
    const U x = static_cast<U>(a < 0 ? ~a : a);
    return x == 0 ? ~u32{0} : static_cast<u32>(8 * sizeof(T)) - 1 - static_cast<u32>(std::countl_zero(x));
  }
};
/// The left shift that would bring that bit to the top.
struct ShiftOfHighest {
  template <class T>
  static u32 of(T a) {
    const u32 highest = FindHighest::of(a);
    return highest == ~u32{0} ? highest : static_cast<u32>(8 * sizeof(T)) - 1 - highest;
  }
};
/// Shifts by the number of bits or more give zero, or the sign.
struct ShiftLeft {
  template <class T>
  static T of(T a, u32 n) {
    return n >= 8 * sizeof(T) ? T{0} : static_cast<T>(a << n);
  }
};
struct ShiftRight {
  template <class T>
  static T of(T a, u32 n) {
    constexpr u32 kBits = 8 * sizeof(T);
    if (n < kBits) return static_cast<T>(a >> n);
    return std::is_signed_v<T> ? static_cast<T>(a >> (kBits - 1)) : T{0};
  }
};

u64 low_bits(u32 n) { return n >= 64 ? ~u64{0} : (u64{1} << n) - 1; }

/// Calls f(a, b, c, d) for active lanes; operands that the instruction lacks are zero.
template <class F>
void map_active(Warp& w, const Instruction& i, const F& f) {
  const u64* const rows[4] = {w.row_or_null(i.a), w.row_or_null(i.b), w.row_or_null(i.c), w.row_or_null(i.d)};
  u64* const to = w.row(i.to);
  const auto value = [&rows](u32 operand, u32 l) { return rows[operand] == nullptr ? 0 : rows[operand][l]; };
  for_each_lane(w.active, [&](u32 l) { to[l] = f(value(0, l), value(1, l), value(2, l), value(3, l)); });
}

void execute_insert(Warp& w, const Instruction& i) {
  const u32 bits = 8U * i.bytes;
  map_active(w, i, [bits](u64 a, u64 b, u64 c, u64 d) {
    const u32 position = c & 0xffU;
    const u64 field = position < bits ? low_bits(d & 0xffU) << position : 0;
    return ((b & ~field) | (position < bits ? a << position & field : 0)) & low_bits(bits);
  });
}

void execute_extract(Warp& w, const Instruction& i) {
  const u32 bits = 8U * i.bytes;
  const bool is_signed = i.is_signed;
  map_active(w, i, [bits, is_signed](u64 a, u64 b, u64 c, u64) {
    const u32 position = b & 0xffU;
    const u32 length = c & 0xffU;
    if (length == 0) return u64{0};
    const u64 x = a & low_bits(bits);
    const u32 top = std::min(position + length, bits) - 1;  // of the field, within the register
    const bool fill = is_signed && (x >> std::min(top, bits - 1) & 1U) != 0;
    const u32 taken = position < bits ? std::min(length, bits - position) : 0;
    const u64 field = taken == 0 ? 0 : x >> position & low_bits(taken);
    return (fill ? field | ~low_bits(taken) : field) & low_bits(bits);
  });
}

void execute_mask(Warp& w, const Instruction& i) {
  map_active(w, i, [](u64 a, u64 b, u64, u64) {
    const u32 position = static_cast<u32>(a);
    const u64 mask = low_bits(std::min(static_cast<u32>(b), 32U));
    return position >= 32 ? 0 : mask << position & low_bits(32);
  });
}

void execute_permute(Warp& w, const Instruction& i) {
  map_active(w, i, [](u64 a, u64 b, u64 c, u64) {
    const u64 bytes = (a & low_bits(32)) | b << 32U;
    u64 result = 0;
    for (u32 k = 0; k < 4; ++k) {
      const u32 selector = static_cast<u32>(c >> (4 * k) & 0xfU);
      u64 byte = bytes >> (8 * (selector & 7U)) & 0xffU;
      if ((selector & 8U) != 0) byte = (byte & 0x80U) != 0 ? 0xff : 0;  // the sign, in all bits
      result |= byte << (8 * k);
    }
    return result;
  });
}

/// `immediate` is the truth table.
void execute_logic(Warp& w, const Instruction& i) {
  const auto table = static_cast<u32>(i.immediate);
  map_active(w, i, [table](u64 a, u64 b, u64 c, u64) {
    u64 result = 0;
    for (u32 k = 0; k < 8; ++k) {
      if ((table >> k & 1U) == 0) continue;
      result |= ((k & 4U) != 0 ? a : ~a) & ((k & 2U) != 0 ? b : ~b) & ((k & 1U) != 0 ? c : ~c);
    }
    return result & low_bits(32);
  });
}

enum FunnelShift : u8 { kLeftClamped, kRightClamped, kLeftWrapped, kRightWrapped };
void execute_funnel_shift(Warp& w, const Instruction& i) {
  const bool right = i.variant == kRightClamped || i.variant == kRightWrapped;
  const bool wraps = i.variant == kLeftWrapped || i.variant == kRightWrapped;
  map_active(w, i, [right, wraps](u64 a, u64 b, u64 c, u64) {
    const u32 n = wraps ? static_cast<u32>(c) & 31U : std::min(static_cast<u32>(c), 32U);
    const u64 x = (a & low_bits(32)) | b << 32U;
    return right ? x >> n & low_bits(32) : x << n >> 32U;
  });
}

/// Predicates are registers with the value 0 or 1.
template <class Operation>
bool decode_logical(const Statement& s, Scope&, Instruction& i) {
  const Type t = s.type();
  i.execute = t.kind == 'p' ? &binary<u64, Operation> : for_integer<Binary, Operation>(t.bits, false);
  return take_rows(s, 3, i);
}

/// Of one operand, unsigned unless the type says otherwise.
template <class Operation>
bool decode_one(const Statement& s, Scope&, Instruction& i) {
  const Type t = s.type();
  if constexpr (std::is_same_v<Operation, FindHighest> || std::is_same_v<Operation, ShiftOfHighest>) {
    i.execute = for_integer<Unary, Operation>(t.bits, t.is_signed());
  } else {
    i.execute = t.bits == 64   ? &unary<u64, Operation>
                : t.bits == 32 ? &unary<u32, Operation>
                : t.bits == 16 ? &unary<u16, Operation>
                               : nullptr;
  }
  return take_rows(s, 2, i);
}

bool decode_not(const Statement& s, Scope& scope, Instruction& i) {
  if (s.type().kind != 'p') return decode_one<Not>(s, scope, i);
  i.execute = &unary<u64, NotPredicate>;
  return take_rows(s, 2, i);
}

bool decode_find_highest(const Statement& s, Scope& scope, Instruction& i) {
  return s.has("shiftamt") ? decode_one<ShiftOfHighest>(s, scope, i) : decode_one<FindHighest>(s, scope, i);
}

template <class Operation>
bool decode_shift(const Statement& s, Scope&, Instruction& i) {
  i.execute = for_integer<Shift, Operation>(s.type().bits, s.type().is_signed());
  return take_rows(s, 3, i);
}

template <Execute kExecute, u32 kOperands>
bool decode_with(const Statement& s, Scope&, Instruction& i) {
  i.execute = kExecute;
  i.bytes = static_cast<u8>(s.type().bits / 8);
  i.is_signed = s.type().is_signed();
  return take_rows(s, kOperands, i);
}

bool decode_logic(const Statement& s, Scope&, Instruction& i) {
  i.execute = execute_logic;
  if (s.modifiers.size() != 1 || s.operands.size() != 5) return false;
  i.immediate = static_cast<i64>(s.operands[4].value);
  return take_rows(s, 4, i);
}

bool decode_permute(const Statement& s, Scope& scope, Instruction& i) {
  return s.modifiers.size() == 1 && decode_with<execute_permute, 4>(s, scope, i);
}

bool decode_funnel_shift(const Statement& s, Scope&, Instruction& i) {
  i.execute = execute_funnel_shift;
  i.variant = s.has("wrap") ? (s.has("r") ? kRightWrapped : kLeftWrapped) : s.has("r") ? kRightClamped : kLeftClamped;
  return take_rows(s, 4, i);
}

}  // namespace

void add_bit_operations(DecodeTable& table) {
  table["and"] = decode_logical<And>;
  table["or"] = decode_logical<Or>;
  table["xor"] = decode_logical<Xor>;
  table["not"] = decode_not;
  table["cnot"] = decode_one<IsZero>;
  table["popc"] = decode_one<CountOnes>;
  table["clz"] = decode_one<CountLeadingZeros>;
  table["brev"] = decode_one<Reverse>;
  table["bfind"] = decode_find_highest;
  table["shl"] = decode_shift<ShiftLeft>;
  table["shr"] = decode_shift<ShiftRight>;
  table["bfi"] = decode_with<execute_insert, 5>;
  table["bfe"] = decode_with<execute_extract, 4>;
  table["bmsk"] = decode_with<execute_mask, 3>;
  table["prmt"] = decode_permute;
  table["lop3"] = decode_logic;
  table["shf"] = decode_funnel_shift;
}

}  // namespace tetune::ptxsim

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <type_traits>

#include "ptxsim/warp.hpp"

/// Operations on all lanes of a warp. The loops run over all 32 lanes, to be vectorized, and keep the results of those
/// that are active.
namespace tetune::ptxsim {

/// The value of type T in a register.
template <class T>
T value_of(u64 bits) {
  if constexpr (std::is_same_v<T, double>) {
    return std::bit_cast<double>(bits);
  } else if constexpr (std::is_same_v<T, float>) {
    return std::bit_cast<float>(static_cast<u32>(bits));
  } else {
    return static_cast<T>(bits);
  }
}

/// A register that holds a value; the bits above it are zero.
template <class T>
u64 bits_of(T value) {
  if constexpr (std::is_same_v<T, double>) {
    return std::bit_cast<u64>(value);
  } else if constexpr (std::is_same_v<T, float>) {
    return std::bit_cast<u32>(value);
  } else if constexpr (std::is_same_v<T, bool>) {
    return value ? 1 : 0;
  } else {
    return static_cast<std::make_unsigned_t<T>>(value);
  }
}

/// Calls f(lane), which returns a register, for all lanes.
template <class F>
void map_lanes(Warp& w, Row to, const F& f) {
  u64* const result = w.row(to);
  for (u32 l = 0; l < kLanes; ++l) result[l] = (f(l) & w.active_bits[l]) | (result[l] & ~w.active_bits[l]);
}

template <class T, class Operation>
void unary(Warp& w, const Instruction& i) {
  const u64* const a = w.row(i.a);
  map_lanes(w, i.to, [a](u32 l) { return bits_of(Operation::of(value_of<T>(a[l]))); });
}

template <class T, class Operation>
void binary(Warp& w, const Instruction& i) {
  const u64* const a = w.row(i.a);
  const u64* const b = w.row(i.b);
  map_lanes(w, i.to, [a, b](u32 l) { return bits_of(Operation::of(value_of<T>(a[l]), value_of<T>(b[l]))); });
}

template <class T, class Operation>
void ternary(Warp& w, const Instruction& i) {
  const u64* const a = w.row(i.a);
  const u64* const b = w.row(i.b);
  const u64* const c = w.row(i.c);
  map_lanes(w, i.to, [a, b, c](u32 l) {
    return bits_of(Operation::of(value_of<T>(a[l]), value_of<T>(b[l]), value_of<T>(c[l])));
  });
}

/// The second operand is a number of bits.
template <class T, class Operation>
void shift(Warp& w, const Instruction& i) {
  const u64* const a = w.row(i.a);
  const u64* const b = w.row(i.b);
  map_lanes(w, i.to, [a, b](u32 l) { return bits_of(Operation::of(value_of<T>(a[l]), static_cast<u32>(b[l]))); });
}

/// The function for a type of 16, 32 or 64 bits; null for other sizes.
template <template <class, class> class Apply, class Operation>
Execute for_integer(u32 bits, bool is_signed) {
  switch (bits) {
    case 16:
      return is_signed ? &Apply<i16, Operation>::run : &Apply<u16, Operation>::run;
    case 32:
      return is_signed ? &Apply<i32, Operation>::run : &Apply<u32, Operation>::run;
    case 64:
      return is_signed ? &Apply<i64, Operation>::run : &Apply<u64, Operation>::run;
    default:
      return nullptr;
  }
}
template <template <class, class> class Apply, class Operation>
Execute for_float(u32 bits) {
  return bits == 64 ? &Apply<double, Operation>::run : bits == 32 ? &Apply<float, Operation>::run : nullptr;
}

template <class T, class Operation>
struct Unary {
  static void run(Warp& w, const Instruction& i) { unary<T, Operation>(w, i); }
};
template <class T, class Operation>
struct Binary {
  static void run(Warp& w, const Instruction& i) { binary<T, Operation>(w, i); }
};
template <class T, class Operation>
struct Ternary {
  static void run(Warp& w, const Instruction& i) { ternary<T, Operation>(w, i); }
};
template <class T, class Operation>
struct Shift {
  static void run(Warp& w, const Instruction& i) { shift<T, Operation>(w, i); }
};

}  // namespace tetune::ptxsim

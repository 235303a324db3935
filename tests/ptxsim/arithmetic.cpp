// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "ptxsim/lanes.hpp"
#include "ptxsim/statement.hpp"

namespace tetune::ptxsim {
namespace {

/// The integer type with twice the bits; for 64 bits, the same one unless products need more.
template <class T>
struct Wider;
template <>
struct Wider<i16> {
  using type = i32;
};
template <>
struct Wider<u16> {
  using type = u32;
};
template <>
struct Wider<i32> {
  using type = i64;
};
template <>
struct Wider<u32> {
  using type = u64;
};
__extension__ typedef __int128 i128;
__extension__ typedef unsigned __int128 u128;
template <>
struct Wider<i64> {
  using type = i128;
};
template <>
struct Wider<u64> {
  using type = u128;
};
template <class T>
using WiderOf = typename Wider<T>::type;

/// Signed overflow wraps around.
template <class T, class F>
T wrapped(T a, T b, const F& f) {
  if constexpr (std::is_floating_point_v<T>) {
    return f(a, b);
  } else {
    return static_cast<T>(f(static_cast<u64>(a), static_cast<u64>(b)));
  }
}

struct Add {
  template <class T>
  static T of(T a, T b) {
    return wrapped(a, b, [](auto x, auto y) { return x + y; });
  }
};
struct Subtract {
  template <class T>
  static T of(T a, T b) {
    return wrapped(a, b, [](auto x, auto y) { return x - y; });
  }
};
struct Multiply {
  template <class T>
  static T of(T a, T b) {
    return wrapped(a, b, [](auto x, auto y) { return x * y; });
  }
};
struct MultiplyHigh {
  template <class T>
  static T of(T a, T b) {
    using W = WiderOf<T>;
    return static_cast<T>((static_cast<W>(a) * static_cast<W>(b)) >> (8 * sizeof(T)));
  }
};
struct MultiplyWide {
  template <class T>
  static WiderOf<T> of(T a, T b) {
    using W = WiderOf<T>;
    return static_cast<W>(static_cast<W>(a) * static_cast<W>(b));
  }
};
template <class Product>
struct ThenAdd {
  template <class T>
  static T of(T a, T b, T c) {
    return Add::of(Product::of(a, b), c);
  }
};
struct FusedMultiplyAdd {
  template <class T>
  static T of(T a, T b, T c) {
    return std::fma(a, b, c);
  }
};
/// Division by zero gives all ones.
struct Divide {
  template <class T>
  static T of(T a, T b) {
    if constexpr (std::is_floating_point_v<T>) {
      return a / b;
    } else {
      if (b == 0) return static_cast<T>(-1);
      if (std::is_signed_v<T> && b == static_cast<T>(-1)) return Subtract::of(T{0}, a);
      return static_cast<T>(a / b);
    }
  }
};
struct Remainder {
  template <class T>
  static T of(T a, T b) {
    if (b == 0) return a;
    if (std::is_signed_v<T> && b == static_cast<T>(-1)) return T{0};
    return static_cast<T>(a % b);
  }
};
/// Of a number and NaN the number; -0 is below +0.
struct Min {
  template <class T>
  static T of(T a, T b) {
    if (a < b) return a;
    if (b < a) return b;
    if constexpr (std::is_floating_point_v<T>) {
      if (std::isnan(a)) return b;
      if (std::isnan(b)) return a;
      return std::signbit(a) ? a : b;
    }
    return a;
  }
};
struct Max {
  template <class T>
  static T of(T a, T b) {
    if (a > b) return a;
    if (b > a) return b;
    if constexpr (std::is_floating_point_v<T>) {
      if (std::isnan(a)) return b;
      if (std::isnan(b)) return a;
      return std::signbit(a) ? b : a;
    }
    return a;
  }
};
struct Negate {
  template <class T>
  static T of(T a) {
    if constexpr (std::is_floating_point_v<T>) {
      return -a;
    } else {
      return Subtract::of(T{0}, a);
    }
  }
};
struct Absolute {
  template <class T>
  static T of(T a) {
    if constexpr (std::is_floating_point_v<T>) {
      return std::fabs(a);
    } else {
      return a < 0 ? Negate::of(a) : a;
    }
  }
};
struct SquareRoot {
  template <class T>
  static T of(T a) {
    return std::sqrt(a);
  }
};
struct Reciprocal {
  template <class T>
  static T of(T a) {
    return T{1} / a;
  }
};

/// For operations that are slow enough that inactive lanes are left out.
template <class T, class Operation>
struct ActiveBinary {
  static void run(Warp& w, const Instruction& i) {
    const u64* const a = w.row(i.a);
    const u64* const b = w.row(i.b);
    u64* const to = w.row(i.to);
    for_each_lane(w.active, [&](u32 l) { to[l] = bits_of(Operation::of(value_of<T>(a[l]), value_of<T>(b[l]))); });
  }
};
template <class T>
struct MultiplyWideThenAdd {
  static void run(Warp& w, const Instruction& i) {
    const u64* const a = w.row(i.a);
    const u64* const b = w.row(i.b);
    const u64* const c = w.row(i.c);
    map_lanes(w, i.to, [a, b, c](u32 l) {
      const auto product = MultiplyWide::of(value_of<T>(a[l]), value_of<T>(b[l]));
      return bits_of(Add::of(product, value_of<WiderOf<T>>(c[l])));
    });
  }
};

Kind kind_of(Type t) { return !t.is_float() ? Kind::integer : t.bits == 64 ? Kind::f64 : Kind::f32; }

/// Modifiers that change the result and that nvcc does not emit for this library.
bool has_unsupported_modifier(const Statement& s) {
  return s.has("cc") || s.has("sat") || s.has("ftz") || s.has("rz") || s.has("rm") || s.has("rp") || s.has("approx");
}

template <class Operation>
bool decode_binary(const Statement& s, Scope&, Instruction& i) {
  const Type t = s.type();
  i.kind = kind_of(t);
  i.execute =
      t.is_float() ? for_float<Binary, Operation>(t.bits) : for_integer<Binary, Operation>(t.bits, t.is_signed());
  return !has_unsupported_modifier(s) && take_rows(s, 3, i);
}

template <class Operation>
bool decode_unary(const Statement& s, Scope&, Instruction& i) {
  const Type t = s.type();
  i.kind = kind_of(t);
  i.execute = t.is_float() ? for_float<Unary, Operation>(t.bits) : for_integer<Unary, Operation>(t.bits, true);
  return !has_unsupported_modifier(s) && take_rows(s, 2, i);
}

bool decode_multiply(const Statement& s, Scope& scope, Instruction& i) {
  const Type t = s.type();
  if (t.is_float() || s.has("lo")) return decode_binary<Multiply>(s, scope, i);
  if (s.has("hi")) {
    i.execute = for_integer<Binary, MultiplyHigh>(t.bits, t.is_signed());
  } else if (t.bits == 16) {
    i.execute = t.is_signed() ? &binary<i16, MultiplyWide> : &binary<u16, MultiplyWide>;
  } else {
    i.execute = t.is_signed() ? &binary<i32, MultiplyWide> : &binary<u32, MultiplyWide>;
  }
  return take_rows(s, 3, i);
}

bool decode_multiply_add(const Statement& s, Scope&, Instruction& i) {
  const Type t = s.type();
  i.kind = kind_of(t);
  if (t.is_float()) {
    i.execute = for_float<Ternary, FusedMultiplyAdd>(t.bits);
  } else if (s.has("lo")) {
    i.execute = for_integer<Ternary, ThenAdd<Multiply>>(t.bits, t.is_signed());
  } else if (s.has("hi")) {
    i.execute = for_integer<Ternary, ThenAdd<MultiplyHigh>>(t.bits, t.is_signed());
  } else if (t.bits == 16) {
    i.execute = t.is_signed() ? &MultiplyWideThenAdd<i16>::run : &MultiplyWideThenAdd<u16>::run;
  } else {
    i.execute = t.is_signed() ? &MultiplyWideThenAdd<i32>::run : &MultiplyWideThenAdd<u32>::run;
  }
  return !has_unsupported_modifier(s) && take_rows(s, 4, i);
}

template <class Operation>
bool decode_divide(const Statement& s, Scope&, Instruction& i) {
  const Type t = s.type();
  if (t.is_float()) {
    i.kind = t.bits == 64 ? Kind::f64_division : Kind::f32;
    if constexpr (std::is_same_v<Operation, Divide>) i.execute = for_float<Binary, Divide>(t.bits);
    return s.has("rn") && take_rows(s, 3, i);
  }
  i.execute = for_integer<ActiveBinary, Operation>(t.bits, t.is_signed());
  return take_rows(s, 3, i);
}

template <class Operation>
bool decode_root(const Statement& s, Scope&, Instruction& i) {
  const Type t = s.type();
  i.kind = t.bits == 64 ? Kind::f64_division : Kind::f32;
  i.execute = for_float<Unary, Operation>(t.bits);
  return s.has("rn") && take_rows(s, 2, i);
}

}  // namespace

void add_arithmetic(DecodeTable& table) {
  table["add"] = decode_binary<Add>;
  table["sub"] = decode_binary<Subtract>;
  table["min"] = decode_binary<Min>;
  table["max"] = decode_binary<Max>;
  table["mul"] = decode_multiply;
  table["mad"] = decode_multiply_add;
  table["fma"] = decode_multiply_add;
  table["div"] = decode_divide<Divide>;
  table["rem"] = decode_divide<Remainder>;
  table["abs"] = decode_unary<Absolute>;
  table["neg"] = decode_unary<Negate>;
  table["sqrt"] = decode_root<SquareRoot>;
  table["rcp"] = decode_root<Reciprocal>;
}

}  // namespace tetune::ptxsim

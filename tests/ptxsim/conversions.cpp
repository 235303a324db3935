// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "ptxsim/lanes.hpp"
#include "ptxsim/statement.hpp"

namespace tetune::ptxsim {
namespace {

// Fields of the instruction: `bytes` is the size of the source in bytes, `elements` that of the result; `is_signed`
// whether the source is signed, `negated` whether the result is.

u64 truncated(u64 x, u32 bits) { return x << (64 - bits) >> (64 - bits); }
i64 sign_extended(u64 x, u32 bits) { return static_cast<i64>(x << (64 - bits)) >> (64 - bits); }

void convert_integer(Warp& w, const Instruction& i) {
  const u64* const a = w.row(i.a);
  const u32 from = 8U * i.bytes;
  const u32 to = 8U * i.elements;
  if (i.is_signed) {
    map_lanes(w, i.to, [=](u32 l) { return truncated(static_cast<u64>(sign_extended(a[l], from)), to); });
  } else {
    map_lanes(w, i.to, [=](u32 l) { return truncated(truncated(a[l], from), to); });
  }
}

enum Rounding : u8 { kNone, kNearest, kToZero, kDown, kUp };

double rounded(double x, u8 rounding) {
  switch (rounding) {
    case kNearest:
      return std::nearbyint(x);
    case kDown:
      return std::floor(x);
    case kUp:
      return std::ceil(x);
    case kToZero:
      return std::trunc(x);
    default:
      return x;
  }
}

/// The nearest value of the type; of NaN 0, or the lowest value with 64 bits.
u64 to_integer(double x, u32 bits, bool is_signed) {
  if (is_signed) {
    const double limit = std::ldexp(1.0, static_cast<int>(bits) - 1);
    const u64 lowest = ~u64{0} << (bits - 1);
    if (std::isnan(x)) return bits == 64 ? lowest : 0;
    const u64 value = x < -limit ? lowest : x >= limit ? ~lowest : static_cast<u64>(static_cast<i64>(x));
    return truncated(value, bits);
  }
  if (std::isnan(x)) return bits == 64 ? u64{1} << 63U : 0;
  if (x <= 0) return 0;
  return x >= std::ldexp(1.0, static_cast<int>(bits)) ? truncated(~u64{0}, bits) : static_cast<u64>(x);
}

template <class From>
void convert_float_to_integer(Warp& w, const Instruction& i) {
  const u64* const a = w.row(i.a);
  u64* const to = w.row(i.to);
  const u8 rounding = i.variant == kNone ? u8{kToZero} : i.variant;
  for_each_lane(w.active, [&](u32 l) {
    to[l] = to_integer(rounded(static_cast<double>(value_of<From>(a[l])), rounding), 8U * i.elements, i.negated);
  });
}

template <class To>
void convert_integer_to_float(Warp& w, const Instruction& i) {
  const u64* const a = w.row(i.a);
  u64* const to = w.row(i.to);
  const u32 bits = 8U * i.bytes;
  for_each_lane(w.active, [&](u32 l) {
    to[l] = i.is_signed ? bits_of(static_cast<To>(sign_extended(a[l], bits)))
                        : bits_of(static_cast<To>(truncated(a[l], bits)));
  });
}

template <class From, class To>
void convert_float(Warp& w, const Instruction& i) {
  const u64* const a = w.row(i.a);
  u64* const to = w.row(i.to);
  for_each_lane(w.active, [&](u32 l) {
    to[l] = bits_of(static_cast<To>(rounded(static_cast<double>(value_of<From>(a[l])), i.variant)));
  });
}

u8 integer_rounding(const Statement& s) {
  return s.has("rni") ? kNearest : s.has("rzi") ? kToZero : s.has("rmi") ? kDown : s.has("rpi") ? kUp : kNone;
}

Execute float_conversion(Type from, Type to) {
  if (from.is_float() && to.is_float()) {
    if (from.bits == 64) return to.bits == 64 ? &convert_float<double, double> : &convert_float<double, float>;
    return to.bits == 64 ? &convert_float<float, double> : &convert_float<float, float>;
  }
  if (from.is_float()) return from.bits == 64 ? &convert_float_to_integer<double> : &convert_float_to_integer<float>;
  return to.bits == 64 ? &convert_integer_to_float<double> : &convert_integer_to_float<float>;
}

bool decode_convert(const Statement& s, Scope&, Instruction& i) {
  i.kind = Kind::move;
  if (s.modifiers.size() < 2) return false;
  const Type from = s.type();
  const Type to = type_of(s.modifiers[s.modifiers.size() - 2]);
  if (from.bits < 8 || to.bits < 8) return false;
  const bool has_half = (from.is_float() && from.bits == 16) || (to.is_float() && to.bits == 16);
  if (has_half || s.has("sat") || s.has("ftz") || s.has("rz") || s.has("rm") || s.has("rp")) return false;
  i.bytes = static_cast<u8>(from.bits / 8);
  i.elements = static_cast<u8>(to.bits / 8);
  i.is_signed = from.is_signed();
  i.negated = to.is_signed();
  i.variant = integer_rounding(s);
  if (!from.is_float() && !to.is_float()) {
    i.execute = convert_integer;
  } else {
    i.kind = from.bits == 64 || to.bits == 64 ? Kind::f64 : Kind::f32;
    i.execute = float_conversion(from, to);
  }
  return take_rows(s, 2, i);
}

}  // namespace

void add_conversions(DecodeTable& table) { table["cvt"] = decode_convert; }

}  // namespace tetune::ptxsim

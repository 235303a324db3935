// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "backend/pack.hpp"
#include "math/angle.hpp"

/// Elementary functions with the same bits on every platform; those of C libraries differ in the last one. Results are
/// rounded from about 100 bits, and so are the nearest doubles but for near ties. They consist of additions,
/// multiplications, divisions and square roots, which IEEE 754 defines to the bit. For the host, not for kernels.
namespace tetune::elementary {

/// The unevaluated sum of two doubles, the second at most half a unit in the last place of the first (Dekker 1971).
/// Real is double or a pack of doubles.
template <class Real>
struct DoubleDoubleT {
  Real high, low;
};
using DoubleDouble = DoubleDoubleT<double>;

/// high + low, exactly, where |high| >= |low|.
inline DoubleDouble fast_sum(double high, double low) {
  const double sum = high + low;
  return {sum, low - (sum - high)};
}
/// a + b, exactly (Knuth's two-sum).
inline DoubleDouble sum(double a, double b) {
  const double s = a + b;
  const double b_part = s - a;
  return {s, (a - (s - b_part)) + (b - b_part)};
}
/// a * b, exactly, in the absence of overflow and underflow (Dekker 1971): without fused multiply-adds, which some
/// processors lack.
template <class Real>
TETUNE_INLINE DoubleDoubleT<Real> product(Real a, Real b) {
  constexpr double kSplitter = 134217729;  // 2^27 + 1
  const Real a_big = kSplitter * a;
  const Real b_big = kSplitter * b;
  const Real a_high = a_big - (a_big - a);
  const Real b_high = b_big - (b_big - b);
  const Real a_low = a - a_high;
  const Real b_low = b - b_high;
  const Real p = a * b;
  return {p, ((a_high * b_high - p) + a_high * b_low + a_low * b_high) + a_low * b_low};
}

inline DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble high = sum(a.high, b.high);
  const DoubleDouble low = sum(a.low, b.low);
  const DoubleDouble s = fast_sum(high.high, high.low + low.high);
  return fast_sum(s.high, s.low + low.low);
}
inline DoubleDouble operator-(DoubleDouble a) { return {-a.high, -a.low}; }
inline DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble p = product(a.high, b.high);
  return fast_sum(p.high, p.low + (a.high * b.low + a.low * b.high));
}
inline DoubleDouble operator/(DoubleDouble a, double b) {
  const double quotient = a.high / b;
  const DoubleDouble back = product(quotient, b);
  return fast_sum(quotient, ((a.high - back.high) - back.low + a.low) / b);
}

struct SineCosine {
  DoubleDouble sine, cosine;
};

/// Sine and cosine of an angle in [-7, 7], by Taylor series about the nearest multiple of pi / 2.
inline SineCosine sine_cosine(double angle) {
  constexpr double kHalfPi[3] = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54, -0x1.f1976b7ed8fbcp-110};
  const double quarters = std::floor(angle / kHalfPi[0] + 0.5);
  const int turns = int(quarters);
  DoubleDouble r{angle, 0};
  for (const double part : kHalfPi) r = r + product(-quarters, part);
  const DoubleDouble minus_r2 = -(r * r);
  SineCosine result{r, {1, 0}};
  DoubleDouble odd = r;
  DoubleDouble even{1, 0};
  for (double n = 1; n < 28; n += 2) {
    even = even * minus_r2 / (n * (n + 1));
    odd = odd * minus_r2 / ((n + 1) * (n + 2));
    result.cosine = result.cosine + even;
    result.sine = result.sine + odd;
  }
  const SineCosine quarter{result.cosine, -result.sine};  // of the angle plus pi / 2
  if (turns % 2 != 0) result = quarter;
  return ((turns % 4) + 4) % 4 < 2 ? result : SineCosine{-result.sine, -result.cosine};
}

/// Requires an angle in [-7, 7].
inline double cos(double angle) { return sine_cosine(angle).cosine.high; }
inline double sin(double angle) { return sine_cosine(angle).sine.high; }

/// atan2(y, x) for y >= 0, of numbers whose squares neither overflow nor underflow: a step of Newton's method from
/// upper_atan2().
inline double atan2(double y, double x) {
  const double angle = upper_atan2(y, x);
  if (y == 0 || x == 0) return angle;
  const SineCosine at = sine_cosine(angle);
  const DoubleDouble across = DoubleDouble{y, 0} * at.cosine + -(DoubleDouble{x, 0} * at.sine);
  return angle + across.high / (x * at.cosine.high + y * at.sine.high);
}

/// x^(2^log2_power).
inline double repeated_square(double x, int log2_power) {
  DoubleDouble power{x, 0};
  for (int i = 0; i < log2_power; ++i) power = power * power;
  return power.high;
}

/// The cube root of a normal number or 0, by Halley's method from the exponent divided by three, and a step of Newton's
/// with an exact residual. Real is double or a pack of doubles.
template <class Real>
TETUNE_INLINE Real cbrt(Real x) {
  constexpr std::uint64_t kBias = 0x2a9f7893'00000000;  // two thirds of the bias of exponents, with the mean error
  const Real a = x < 0 ? -x : x;
  backend::BitsOf<Real> bits;
  std::memcpy(&bits, &a, sizeof bits);
  bits = bits / 3 + kBias;
  Real root;
  std::memcpy(&root, &bits, sizeof root);
  for (int i = 0; i < 3; ++i) {
    const Real cube = root * root * root;
    root = root * ((cube + 2 * a) / (2 * cube + a));
  }
  const DoubleDoubleT<Real> square = product(root, root);
  const DoubleDoubleT<Real> cube = product(square.high, root);
  const Real residual = ((a - cube.high) - cube.low) - square.low * root;
  root += residual / (3 * square.high);
  root = x < 0 ? -root : root;
  root = a > 0 ? root : x;
  return a > std::numeric_limits<double>::max() ? x : root;
}

}  // namespace tetune::elementary

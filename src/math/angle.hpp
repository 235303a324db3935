// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

#include "backend/macros.hpp"

namespace tetune {

inline constexpr double kDegreesPerRadian = 180 / std::numbers::pi;

/// atan2(y, x) for y >= 0: the angle in [0, pi] of the direction (x, y), 0 for the null vector. Real is double or a
/// pack of doubles. Accurate to about 1e-15, without branches and calls, and with the same bits on every platform. The
/// polynomial is the minimax approximation of atan(r) / r in r^2 for |r| <= tan(pi / 8).
template <class Real>
TETUNE_HD TETUNE_INLINE Real upper_atan2(Real y, Real x) {
  const Real zero{};
  const Real abs_x = x < 0 ? -x : x;
  const Real low = y < abs_x ? y : abs_x;
  const Real high = y < abs_x ? abs_x : y;
  const auto reduced = low > (std::numbers::sqrt2 - 1) * high;
  const Real numerator = reduced ? low - high : low;
  const Real denominator = reduced ? low + high : high;
  const Real r = numerator / (denominator > 0 ? denominator : zero + 1);
  const Real s = r * r;
  Real p = s * -0.02531647957377647565;
  p = p + 0.050247621189401280324;
  p = p * s - 0.065059829671708399157;
  p = p * s + 0.076735354281832860176;
  p = p * s - 0.090895299565623073577;
  p = p * s + 0.11111048853751295683;
  p = p * s - 0.14285712661684793837;
  p = p * s + 0.19999999978392662056;
  p = p * s - 0.33333333333221434047;
  p = p * s + 0.9999999999999990408;
  Real angle = p * r + (reduced ? zero + std::numbers::pi / 4 : zero);
  angle = y > abs_x ? std::numbers::pi / 2 - angle : angle;
  return x < 0 ? std::numbers::pi - angle : angle;
}

}  // namespace tetune

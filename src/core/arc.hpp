// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include "par/macros.hpp"

namespace tetune {

/// The angle in [0, pi] with cosine x and sine y >= 0, both times any one factor; 0 where both are 0. To 1e-15 or so,
/// as std::atan2, but without a branch or a call, so that loops over it become vector code. The polynomial is the
/// minimax one of atan(r) / r in r^2 for |r| <= tan(pi / 8).
TETUNE_HD TETUNE_INLINE double arc(double y, double x) {
  const double side = std::fabs(x);
  const double low = y < side ? y : side;
  const double high = y < side ? side : y;
  const bool turned = low > (std::numbers::sqrt2 - 1) * high;
  const double up = turned ? low - high : low;
  const double down = turned ? low + high : high;
  const double r = up / (down > 0 ? down : 1);
  const double s = r * r;
  double p = -0.02531647957377647565;
  p = p * s + 0.050247621189401280324;
  p = p * s - 0.065059829671708399157;
  p = p * s + 0.076735354281832860176;
  p = p * s - 0.090895299565623073577;
  p = p * s + 0.11111048853751295683;
  p = p * s - 0.14285712661684793837;
  p = p * s + 0.19999999978392662056;
  p = p * s - 0.33333333333221434047;
  p = p * s + 0.9999999999999990408;
  double angle = p * r + (turned ? std::numbers::pi / 4 : 0);
  angle = y > side ? std::numbers::pi / 2 - angle : angle;
  return x < 0 ? std::numbers::pi - angle : angle;
}

}  // namespace tetune

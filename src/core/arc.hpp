// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include "par/macros.hpp"

namespace tetune {

/// The angle in [0, pi] with cosine x and sine y >= 0, both times any one factor; 0 where both are 0; of packs, in each
/// lane. To 1e-15 or so, as std::atan2, but without a branch or a call. The polynomial is the minimax one of
/// atan(r) / r in r^2 for |r| <= tan(pi / 8).
template <class Real>
TETUNE_HD TETUNE_INLINE Real arc(Real y, Real x) {
  const Real none{};
  const Real side = x < 0 ? -x : x;
  const Real low = y < side ? y : side;
  const Real high = y < side ? side : y;
  const auto turned = low > (std::numbers::sqrt2 - 1) * high;
  const Real up = turned ? low - high : low;
  const Real down = turned ? low + high : high;
  const Real r = up / (down > 0 ? down : none + 1);
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
  Real angle = p * r + (turned ? none + std::numbers::pi / 4 : none);
  angle = y > side ? std::numbers::pi / 2 - angle : angle;
  return x < 0 ? std::numbers::pi - angle : angle;
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "par/macros.hpp"

namespace tetune {

/// The curve's grid has kHilbertCells cells a side.
inline constexpr int kHilbertBitsPerAxis = 16;
inline constexpr int kHilbertBits = 3 * kHilbertBitsPerAxis;
inline constexpr double kHilbertCells = 1 << kHilbertBitsPerAxis;

/// Position along the three-dimensional Hilbert curve of a grid cell, coordinates in [0, kHilbertCells).
/// After Skilling, "Programming the Hilbert curve", AIP Conf. Proc. 707, 2004.
TETUNE_HD inline std::uint64_t hilbert_index(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  std::uint32_t axis[3] = {x, y, z};
  for (std::uint32_t bit = 1U << (kHilbertBitsPerAxis - 1); bit > 1; bit >>= 1) {
    const std::uint32_t below = bit - 1;
    for (int i = 0; i < 3; ++i) {
      if ((axis[i] & bit) != 0) {
        axis[0] ^= below;
      } else {
        const std::uint32_t swapped = (axis[0] ^ axis[i]) & below;
        axis[0] ^= swapped;
        axis[i] ^= swapped;
      }
    }
  }
  axis[1] ^= axis[0];
  axis[2] ^= axis[1];
  std::uint32_t flip = 0;
  for (std::uint32_t bit = 1U << (kHilbertBitsPerAxis - 1); bit > 1; bit >>= 1) {
    if ((axis[2] & bit) != 0) flip ^= bit - 1;
  }
  std::uint64_t index = 0;
  for (int b = kHilbertBitsPerAxis - 1; b >= 0; --b) {
    for (int i = 0; i < 3; ++i) index = (index << 1) | (((axis[i] ^ flip) >> b) & 1U);
  }
  return index;
}

}  // namespace tetune

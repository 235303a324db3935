// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "backend/macros.hpp"

namespace tetune {

/// The bits of a coordinate of a cell, and of the position along the curve.
inline constexpr int kHilbertBitsPerAxis = 16;
inline constexpr int kHilbertBits = 3 * kHilbertBitsPerAxis;
/// The number of cells of the grid along each axis.
inline constexpr double kHilbertCells = 1 << kHilbertBitsPerAxis;

/// Moves bit i of a number below kHilbertCells to bit 3 i.
TETUNE_HD inline std::uint64_t every_third_bit(std::uint32_t number) {
  static_assert(kHilbertBitsPerAxis == 16);
  std::uint64_t bits = number;
  bits = (bits | bits << 16) & 0x0000'ff00'00ffULL;
  bits = (bits | bits << 8) & 0x00f0'0f00'f00fULL;
  bits = (bits | bits << 4) & 0x0c30'c30c'30c3ULL;
  bits = (bits | bits << 2) & 0x2492'4924'9249ULL;
  return bits;
}

/// The position of a grid cell, coordinates in [0, kHilbertCells), along the three-dimensional Hilbert curve.
/// See Skilling, "Programming the Hilbert curve", AIP Conf. Proc. 707, 2004.
TETUNE_HD inline std::uint64_t hilbert_index(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  std::uint32_t axis[3] = {x, y, z};
  for (int bit = kHilbertBitsPerAxis - 1; bit > 0; --bit) {
    const std::uint32_t below = (1U << bit) - 1;
    for (int i = 0; i < 3; ++i) {
      // If the bit is set, the lower bits of the first axis are inverted, otherwise exchanged with those of axis i;
      // without branches, which would be unpredictable.
      const std::uint32_t set = 0U - ((axis[i] >> bit) & 1U);
      const std::uint32_t change = below & (set | (axis[0] ^ axis[i]));
      axis[0] ^= change;
      axis[i] ^= change & ~set;
    }
  }
  axis[1] ^= axis[0];
  axis[2] ^= axis[1];
  std::uint32_t flip = axis[2] >> 1;
  for (int bits = 1; bits < kHilbertBitsPerAxis; bits *= 2) flip ^= flip >> bits;
  return every_third_bit(axis[0] ^ flip) << 2 | every_third_bit(axis[1] ^ flip) << 1 | every_third_bit(axis[2] ^ flip);
}

}  // namespace tetune

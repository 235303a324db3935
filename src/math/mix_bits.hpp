// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "backend/macros.hpp"

namespace tetune {

/// A hash of a 64-bit number, also for numbers with a pattern: the finalizer of Steele, Lea and Flood, "Fast splittable
/// pseudorandom number generators", 2014, Fig. 16.
TETUNE_HD inline std::uint64_t mix_bits(std::uint64_t z) {
  constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15;
  z += kStep;
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
  z = (z ^ z >> 27) * 0x94d049bb133111eb;
  return z ^ z >> 31;
}

}  // namespace tetune

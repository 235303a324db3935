// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>

#include "math/vec3.hpp"

/// Random numbers that are the same with every standard library.
namespace tetune::test {

/// In [0, 1).
inline double uniform(std::mt19937& random) { return static_cast<double>(random()) / 4294967296.0; }

/// In [-1, 1)^3.
inline Vec3 random_vec(std::mt19937& random) {
  const double x = 2 * uniform(random) - 1;
  const double y = 2 * uniform(random) - 1;
  return {x, y, 2 * uniform(random) - 1};
}

}  // namespace tetune::test

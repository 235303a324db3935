// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/constants.hpp"
#include "tetune/optimize.hpp"

/// Options and targets that several tests pass.
namespace tetune::test {

/// The target of a vertex that may move freely.
inline constexpr Point3 kFree{kNan, kNan, kNan};

inline Options options_of(Effort effort, Boundary boundary, int threads) {
  Options options;
  options.effort = effort;
  options.boundary = boundary;
  options.threads = threads;
  return options;
}

}  // namespace tetune::test

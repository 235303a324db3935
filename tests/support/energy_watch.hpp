// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "tetune/optimize.hpp"

namespace tetune::test {

/// Expects that no sweep and no flip pass raises the energy, and that improve-worst phases raise it by at most 2 %.
inline Context energy_watch() {
  Context context;
  context.progress = [last = 1e300](const Progress& p) mutable {
    const bool on_whole_mesh = std::string(p.phase) == "sweep" || std::string(p.phase) == "flips";
    EXPECT_LE(p.energy, last * (on_whole_mesh ? 1 + 1e-12 : 1.02));
    last = p.energy;
    return true;
  };
  return context;
}

}  // namespace tetune::test

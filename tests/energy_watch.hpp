// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "tetune/optimize.hpp"

namespace tetune::test {

/// Expects that no sweep and no flips raise the energy; work on the few worst may give some of it back.
inline Context energy_watch() {
  Context context;
  context.progress = [last = 1e300](const Progress& p) mutable {
    const bool on_all = std::string(p.phase) == "sweep" || std::string(p.phase) == "flips";
    EXPECT_LE(p.energy, last * (on_all ? 1 + 1e-12 : 1.02));
    last = p.energy;
    return true;
  };
  return context;
}

}  // namespace tetune::test

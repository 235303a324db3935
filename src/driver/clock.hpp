// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

#include "tetune/optimize.hpp"

namespace tetune {

/// Adds the time of pieces of work to a report, by phase.
class Clock {
 public:
  explicit Clock(Report& report) : report_(report) {}

  /// Runs `work` and returns its seconds.
  template <class F>
  double measure(const char* phase, const F& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    for (PhaseTime& p : report_.phases) {
      if (p.phase == phase) {
        p.seconds += seconds;
        return seconds;
      }
    }
    report_.phases.push_back({phase, seconds});
    return seconds;
  }

 private:
  Report& report_;
};

}  // namespace tetune

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
    const std::size_t at = position(phase);  // takes memory, so before the work: what is done then stays done
    const auto start = std::chrono::steady_clock::now();
    work();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    report_.phases[at].seconds += seconds;
    return seconds;
  }

 private:
  std::size_t position(const char* phase) {
    std::size_t at = 0;
    while (at < report_.phases.size() && report_.phases[at].phase != phase) ++at;
    if (at == report_.phases.size()) report_.phases.push_back({phase, 0});
    return at;
  }

  Report& report_;
};

}  // namespace tetune

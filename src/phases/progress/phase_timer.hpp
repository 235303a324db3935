// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

#include "backend/processor_model.hpp"
#include "phases/progress/phase.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// Adds up the wall-clock time of each phase of a run in Report::phases.
class PhaseTimer {
 public:
  using SteadyClock = backend::SteadyClock;

  explicit PhaseTimer(Report& report) : report_(report) {}

  Report& report() const { return report_; }
  /// When this timer was made: the start of the run.
  SteadyClock::time_point start() const { return start_; }

  static double seconds_since(SteadyClock::time_point start) {
    return std::chrono::duration<double>(SteadyClock::now() - start).count();
  }

  /// Runs `work` and returns its time in seconds.
  template <class F>
  double measure(Phase phase, const F& work) {
    // Allocates memory before the work is done: nothing may fail afterwards.
    const std::size_t entry = entry_of(report_, name_of(phase));
    const auto start = SteadyClock::now();
    work();
    const double seconds = seconds_since(start);
    report_.phases[entry].seconds += seconds;
    return seconds;
  }

  /// The position in Report::phases of a phase, which is added where it is not there yet.
  static std::size_t entry_of(Report& report, const std::string& phase) {
    std::size_t entry = 0;
    while (entry < report.phases.size() && report.phases[entry].phase != phase) ++entry;
    if (entry == report.phases.size()) report.phases.push_back({phase, 0});
    return entry;
  }

 private:
  Report& report_;
  SteadyClock::time_point start_ = SteadyClock::now();
};

}  // namespace tetune

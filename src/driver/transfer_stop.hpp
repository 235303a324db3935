// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "phases/progress/phase_timer.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// The condition to give up a conservative transfer that begins now: a stop is requested, and it has taken as long as
/// the run before it, which began at `start`. So a run takes at most about twice its time limit. `stop` must outlive
/// the result.
inline std::function<bool()> transfer_stop(const std::function<bool()>& stop,
                                           PhaseTimer::SteadyClock::time_point start) {
  if (!stop) return {};
  const auto now = PhaseTimer::SteadyClock::now();
  const auto end = now + (now - start);
  return [&stop, end] { return stop() && PhaseTimer::SteadyClock::now() >= end; };
}

/// Reports a transfer that was given up.
inline void report_transfer_given_up(Report& report) {
  report.stop = StopReason::cancelled;
  report.transfer_stopped = true;
  report.warnings.emplace_back(
      "data=conserve: the run was stopped, and the transfer took longer than the run before it; data are those of "
      "data=interpolate, so totals have changed");
}

}  // namespace tetune

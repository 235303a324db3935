// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tetune/optimize.hpp"

namespace tetune {

/// The energy must fall by this part in a sweep for another one to follow: docs/benchmarks/cpu.md, "When to stop".
inline double least_decrease(const Options& options) {
  return options.effort == Effort::fast ? 2e-2 : options.effort == Effort::best ? 1e-4 : 2e-3;
}

/// When to look for flips, and when to stop (Sect. 4.5). Ask after each sweep.
class Schedule {
 public:
  explicit Schedule(const Options& options)
      : paper_(options.termination == Termination::paper),
        least_decrease_(least_decrease(options)),
        little_gain_(options.effort == Effort::best ? 1e-4 : 3e-3),
        once_(options.effort == Effort::fast && options.flips && !paper_) {}

  /// Whether the sweep just done is to be followed by flips.
  bool flips_due(int iteration) const { return !(once_ && looked_) && iteration >= next_flips_; }

  /// Tells how many flips were found after this sweep, and which part of the energy they took away.
  void flips_found(int iteration, std::int64_t flips, double gain);

  /// Whether to stop after this sweep (and the flips that followed it, if any), and why.
  bool stop(const SweepReport& sweep, double energy_before_round, double energy, StopReason& reason);

 private:
  bool paper_;
  double least_decrease_;
  double little_gain_;  ///< flips that take away less than this part of the energy are not worth an earlier look
  bool once_;           ///< one look for flips is all
  int interval_ = 1;    ///< the paper's k_f: sweeps from one look for flips to the next
  int next_flips_ = 1;
  bool looked_ = false;
  double threshold_ = -1;  ///< the paper's eps_c
  double last_gradient_ = -1;
};

}  // namespace tetune

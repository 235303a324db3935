// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tetune/optimize.hpp"

namespace tetune {

/// When to look for flips, and when to stop (Sect. 4.5). Ask after each sweep.
class Schedule {
 public:
  explicit Schedule(const Options& options)
      : paper_(options.termination == Termination::paper),
        max_(options.max_iterations),
        least_decrease_(options.effort == Effort::fast ? 1e-3 : 1e-4),
        interval_(options.effort == Effort::fast && !paper_ ? 2 : 1),
        next_flips_(interval_) {}

  /// Whether the sweep just done is to be followed by flips.
  bool flips_due(int iteration) const { return iteration >= next_flips_; }

  /// Tells how many flips were found after this sweep, and which part of the energy they took away.
  void flips_found(int iteration, std::int64_t flips, double gain);

  /// Whether to stop after this sweep (and the flips that followed it, if any), and why.
  bool stop(const SweepReport& sweep, double energy_before_round, double energy, StopReason& reason);

 private:
  bool paper_;
  int max_;
  double least_decrease_;  ///< the energy must fall by this part in a sweep to go on
  int interval_ = 1;       ///< the paper's k_f: sweeps from one look for flips to the next
  int next_flips_;
  double threshold_ = -1;  ///< the paper's eps_c
  double last_gradient_ = -1;
};

}  // namespace tetune

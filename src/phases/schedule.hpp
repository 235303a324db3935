// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "phases/tuning.hpp"
#include "tetune/options.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// Determines after each sweep whether flips follow and whether the alternation ends (Sect. 4.5).
class Schedule {
 public:
  explicit Schedule(const Options& options)
      : paper_(options.termination == Termination::paper),
        parameters_(tuning_of(options.effort).alternation),
        once_(parameters_.flips_once && options.flips && !paper_) {}

  /// Whether flips follow this sweep.
  bool flips_due(int iteration) const { return !(once_ && has_flipped_) && iteration >= next_flips_; }

  /// Records the number of flips made after this sweep, and the part by which they decreased the energy.
  void record_flips(int iteration, std::int64_t flips, double decrease);

  /// Whether the alternation ends after this sweep and the flips that followed it, and for which reason.
  bool stop(const SweepReport& sweep, double energy_before_round, double energy, StopReason& reason);

 private:
  bool stop_as_in_paper(const SweepReport& sweep, StopReason& reason);

  bool paper_;
  const AlternationParameters& parameters_;
  bool once_;
  int interval_ = 1;  ///< number of sweeps between flips: k_f of the paper
  int next_flips_ = 1;
  bool has_flipped_ = false;
  double threshold_ = -1;  ///< eps_c of the paper; negative until the first sweep
  double last_gradient_ = -1;
};

}  // namespace tetune

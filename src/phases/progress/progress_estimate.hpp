// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "phases/tuning.hpp"
#include "tetune/options.hpp"

namespace tetune {

/// Estimates which part of a run is done. Two assumptions: each phase takes about the same share of the time on every
/// mesh, and the decrease per sweep falls geometrically until it is below the tolerance.
class ProgressEstimate {
 public:
  explicit ProgressEstimate(const Options& options)
      : paper_(options.termination == Termination::paper),
        tolerance_(tuning_of(options.effort).alternation.min_sweep_decrease),
        max_iterations_(std::max(1, options.max_iterations)) {
    const bool best = options.effort == Effort::best;
    worst_begin_ = !improves_worst(options) ? 1 : best ? kBestWorstBegin : kWorstBegin;
    angles_begin_ = best ? worst_begin_ + kWorstShare : 1;
    restarts_begin_ = best ? worst_begin_ + (kWorstShare + kAnglesShare) : 1;
    polish_begin_ = best ? worst_begin_ + (kWorstShare + kAnglesShare + kRestartsShare) : 1;
  }

  void finish_first_flips(int pass) {
    raise_to(kLoadShare + kFirstFlipsShare * (worst_begin_ - kLoadShare) * (1 - std::exp2(-pass)));
  }

  /// `decrease` is the relative decrease of the energy by this sweep and the flips before it.
  void finish_sweep(int iteration, double decrease) {
    if (iteration == 1) first_decrease_ = decrease;
    double done = static_cast<double>(iteration) / max_iterations_;
    if (!paper_ && first_decrease_ > tolerance_ && decrease > 0) {
      done = std::max(done, std::log(first_decrease_ / decrease) / std::log(first_decrease_ / tolerance_));
    }
    raise_to(kLoadShare +
             (worst_begin_ - kLoadShare) * (kFirstFlipsShare + (1 - kFirstFlipsShare) * std::min(1.0, done)));
  }

  void finish_worst_round(int round) {
    raise_to(worst_begin_ + (angles_begin_ - worst_begin_) * (1 - std::exp2(-round)));
  }
  void finish_angle_round(int round, int rounds) { raise_between(angles_begin_, restarts_begin_, round, rounds); }
  void finish_restart_round(int round, int rounds) { raise_between(restarts_begin_, polish_begin_, round, rounds); }
  void finish_polish_sweep(int sweep, int sweeps) { raise_between(polish_begin_, 1, sweep, sweeps); }

  /// The part that is done, 0 to 1; never decreases.
  double fraction() const { return fraction_; }

 private:
  /// Measured shares of the time (docs/command-line.md, "Progress"): of loading in the whole run, of the first flips in
  /// the alternation, of what precedes the work on the worst elements, and of the phases after that with Effort::best.
  static constexpr double kLoadShare = 0.15;
  static constexpr double kFirstFlipsShare = 0.25;
  static constexpr double kWorstBegin = 0.95, kBestWorstBegin = 0.35;
  static constexpr double kWorstShare = 0.05, kAnglesShare = 0.2, kRestartsShare = 0.35;

  void raise_between(double begin, double end, int step, int steps) { raise_to(begin + (end - begin) * step / steps); }
  void raise_to(double fraction) { fraction_ = std::max(fraction_, std::min(fraction, 1.0)); }

  bool paper_;
  double tolerance_;
  int max_iterations_;
  double worst_begin_, angles_begin_, restarts_begin_, polish_begin_;  ///< the fractions at which these phases begin
  double first_decrease_ = 0;
  double fraction_ = kLoadShare;
};

}  // namespace tetune

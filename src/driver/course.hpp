// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "driver/schedule.hpp"
#include "tetune/optimize.hpp"

namespace tetune {

/// How far a run is, as a guess: the parts take about the same share of the time of every mesh, and what a sweep takes
/// away falls geometrically until it is little enough to stop.
class Course {
 public:
  Course(const Options& options, bool works_on_worst)
      : paper_(options.termination == Termination::paper),
        tolerance_(least_decrease(options)),
        max_(std::max(1, options.max_iterations)) {
    worst_ = works_on_worst ? (options.effort == Effort::best ? 0.6 : 0.95) : 1;
    angles_ = options.effort == Effort::best ? worst_ + 0.05 : 1;
  }

  void first_flips(int pass) { reach(kLoaded + kFirstFlips * (worst_ - kLoaded) * (1 - std::exp2(-pass))); }

  /// `decrease` is that of the energy, relative, in this sweep and the flips before it.
  void sweep(int iteration, double decrease) {
    if (iteration == 1) first_decrease_ = decrease;
    double done = static_cast<double>(iteration) / max_;
    if (!paper_ && first_decrease_ > tolerance_ && decrease > 0) {
      done = std::max(done, std::log(first_decrease_ / decrease) / std::log(first_decrease_ / tolerance_));
    }
    reach(kLoaded + (worst_ - kLoaded) * (kFirstFlips + (1 - kFirstFlips) * std::min(1.0, done)));
  }

  void worst(int round) { reach(worst_ + (angles_ - worst_) * (1 - std::exp2(-round))); }
  /// `step` of `steps`.
  void angles(int step, int steps) { reach(angles_ + (1 - angles_) * step / steps); }

  double fraction() const { return fraction_; }

 private:
  /// Shares of the time: docs/command-line.md, "Progress".
  static constexpr double kLoaded = 0.15;
  static constexpr double kFirstFlips = 0.25;

  void reach(double fraction) { fraction_ = std::max(fraction_, std::min(fraction, 1.0)); }

  bool paper_;
  double tolerance_;
  int max_;
  double worst_, angles_;  ///< the fractions at which these parts begin
  double first_decrease_ = 0;
  double fraction_ = kLoaded;
};

}  // namespace tetune

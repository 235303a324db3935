// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "math/angle.hpp"
#include "phases/progress/phase_timer.hpp"
#include "phases/progress/progress_estimate.hpp"
#include "tetune/context.hpp"
#include "tetune/options.hpp"

namespace tetune {

/// Calls the caller's hooks between two steps.
class ProgressReporter {
 public:
  using SteadyClock = PhaseTimer::SteadyClock;

  ProgressReporter(const Context& context, const Options& options, SteadyClock::time_point start)
      : estimate(options), context_(context), start_(start) {}

  ProgressEstimate estimate;

  /// Replaces the estimate by the part of the run that is done, 0 to 1.
  void set_done(double part) { done_ = part; }

  /// The angle of a cotangent, in degrees.
  static double degrees(double cot) { return std::atan2(1, cot) * kDegreesPerRadian; }

  /// The cotangent of the smallest dihedral angle, and the time in seconds that measuring it takes.
  void set_smallest_angle(double cot, double seconds) {
    angle_ = degrees(cot);
    angle_cost_ = seconds;
  }

  /// Returns false when the caller cancels. `find_cot` measures the angle again; it is called while that costs little.
  template <class FindCot>
  bool proceed(Phase phase, int iteration, double energy, double energy_before, const FindCot& find_cot) {
    if (context_.stop && context_.stop()) return false;
    if (!context_.progress) return true;
    const double seconds = PhaseTimer::seconds_since(start_);
    if (angle_cost_sum_ + angle_cost_ <= kMaxAngleShare * seconds) {
      const auto before = SteadyClock::now();
      const double cot = find_cot();
      set_smallest_angle(cot, PhaseTimer::seconds_since(before));
      angle_cost_sum_ += angle_cost_;
    }
    const double done = done_ < 0 ? estimate.fraction() : done_;
    const double left = iteration > 0 && done > 0 ? seconds * (1 - done) / done : -1;
    return context_.progress({progress_name_of(phase), iteration, energy, energy_before, angle_, done, seconds, left});
  }

 private:
  /// Measuring the angle for reports takes at most this part of the time.
  static constexpr double kMaxAngleShare = 0.01;

  const Context& context_;
  SteadyClock::time_point start_;
  double done_ = -1;                            ///< negative: estimated
  double angle_ = 0;                            ///< degrees
  double angle_cost_ = 0, angle_cost_sum_ = 0;  ///< seconds: of the last measurement, of all
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "phases/schedule.hpp"

#include <algorithm>
#include <cmath>

namespace tetune {
namespace {

constexpr double kPaperEpsilon = 1e-5;
constexpr int kPaperMaxInterval = 1 << 3;  // 2^N, N = 3

}  // namespace

void Schedule::record_flips(int iteration, std::int64_t flips, double decrease) {
  const bool relevant = paper_ ? flips > 0 : decrease > parameters_.min_flip_decrease;
  interval_ = relevant ? (interval_ + 1) / 2 : 2 * interval_;
  next_flips_ = iteration + interval_;
  has_flipped_ = true;
}

bool Schedule::stop(const SweepReport& sweep, double energy_before_round, double energy, StopReason& reason) {
  if (paper_) return stop_as_in_paper(sweep, reason);
  // The negation also stops a mesh without tetrahedra, whose energy is 0.
  if (!(energy_before_round - energy > parameters_.min_sweep_decrease * energy)) {
    reason = StopReason::converged;
    return true;
  }
  return false;
}

bool Schedule::stop_as_in_paper(const SweepReport& sweep, StopReason& reason) {
  const double gradient = sweep.gradient_norm2;
  const double last = last_gradient_;
  last_gradient_ = gradient;
  if (threshold_ < 0) threshold_ = std::max(kPaperEpsilon, kPaperEpsilon * gradient);  // Eq. 17
  if (gradient < threshold_) {
    reason = StopReason::gradient_small;
  } else if (last >= 0 && std::fabs(gradient - last) < threshold_) {
    reason = StopReason::gradient_stationary;
  } else if (interval_ >= kPaperMaxInterval) {
    reason = StopReason::no_flips;
  } else {
    return false;
  }
  return true;
}

}  // namespace tetune

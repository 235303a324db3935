// SPDX-License-Identifier: Apache-2.0
#include "driver/schedule.hpp"

#include <algorithm>
#include <cmath>

namespace tetune {
namespace {

constexpr double kPaperEpsilon = 1e-5;
constexpr int kPaperMaxInterval = 1 << 3;  // 2^N, N = 3

}  // namespace

void Schedule::flips_found(int iteration, std::int64_t flips, double gain) {
  const bool found = paper_ ? flips > 0 : gain > little_gain_;
  interval_ = found ? (interval_ + 1) / 2 : 2 * interval_;
  next_flips_ = iteration + interval_;
  looked_ = true;
}

bool Schedule::stop(const SweepReport& sweep, double energy_before_round, double energy, StopReason& reason) {
  if (paper_) {
    const double gradient = sweep.gradient_norm;
    const double last = last_gradient_;
    last_gradient_ = gradient;
    if (threshold_ < 0) threshold_ = std::max(kPaperEpsilon, kPaperEpsilon * gradient);  // Eq. 17
    if (gradient < threshold_) {
      reason = StopReason::gradient_small;
      return true;
    }
    if (last >= 0 && std::fabs(gradient - last) < threshold_) {
      reason = StopReason::gradient_stationary;
      return true;
    }
    if (interval_ >= kPaperMaxInterval) {
      reason = StopReason::no_flips;
      return true;
    }
  } else if (!(energy_before_round - energy > least_decrease_ * energy)) {  // as where there is no element
    reason = StopReason::converged;
    return true;
  }
  return false;
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cmath>

#include "driver/course.hpp"
#include "tetune/optimize.hpp"

namespace tetune {

/// Tells the caller how far a run is, and hears whether to stop.
class Monitor {
 public:
  using Time = std::chrono::steady_clock;

  Monitor(const Context& context, const Options& options, bool works_on_worst, Time::time_point start)
      : course(options, works_on_worst), context_(context), start_(start) {}

  Course course;

  /// The angle of a cotangent.
  static double degrees(double cot) { return std::atan2(1, cot) * 57.295779513082320877; }

  /// The cotangent of the smallest dihedral angle, and what finding it takes.
  void set_worst(double cot, double seconds) {
    angle_ = degrees(cot);
    cost_ = seconds;
  }

  /// False when the caller wants an end. `find_cot` is called where there is time for it.
  template <class FindCot>
  bool proceed(const char* phase, int iteration, double energy, double energy_before, const FindCot& find_cot) {
    if (context_.stop && context_.stop()) return false;
    if (!context_.progress) return true;
    const double seconds = seconds_since(start_);
    if (spent_ + cost_ <= kPartForAngle * seconds) {
      const auto before = Time::now();
      const double cot = find_cot();
      set_worst(cot, seconds_since(before));
      spent_ += cost_;
    }
    const double done = course.fraction();
    const double left = iteration > 0 ? seconds * (1 - done) / done : -1;
    return context_.progress({phase, iteration, energy, energy_before, angle_, done, seconds, left});
  }

 private:
  static constexpr double kPartForAngle = 0.01;
  static double seconds_since(Time::time_point start) {
    return std::chrono::duration<double>(Time::now() - start).count();
  }

  const Context& context_;
  Time::time_point start_;
  double angle_ = 0;
  double cost_ = 0, spent_ = 0;  ///< seconds for the angle: last time, and in all
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "mesh/tet.hpp"

namespace tetune {

/// A model of the maximum of several functions of a position: each by its value and gradient. Its minimum within a
/// given distance is the step of a method for nonsmooth functions (the proximal form of the active-set method of
/// Freitag and Ollivier-Gooch, "Tetrahedral mesh improvement using swapping and smoothing", 1997). In the memory of one
/// thread.
class MinimaxModel {
 public:
  /// Adds a function. Where there is no room, it replaces the one of the smallest value if its own is larger. Gradients
  /// that overflow, as at volumes close to underflow, are left out.
  TETUNE_HD void add(double value, const Vec3& gradient) {
    if (!(dot(gradient, gradient) < kMaxNorm2)) return;
    int at = count_;
    if (count_ == kMaxFunctions) {
      at = 0;
      for (int i = 1; i < count_; ++i) at = value_[i] < value_[at] ? i : at;
      if (value <= value_[at]) return;
    } else {
      ++count_;
    }
    value_[at] = value;
    gradient_[at] = gradient;
  }

  /// The step of at most `radius` that minimizes the model with a quadratic term, so that a single function would
  /// decrease by the whole radius: d = -tau sum l_i g_i, where the weights l maximize the dual. They are found by
  /// pairwise exchange between the function of the largest and that of the smallest modeled value.
  TETUNE_HD Vec3 step(double radius) const {
    double weight[kMaxFunctions];
    int largest = 0;
    double norm2 = 0;
    for (int i = 0; i < count_; ++i) {
      weight[i] = 0;
      largest = value_[i] > value_[largest] ? i : largest;
      const double g2 = dot(gradient_[i], gradient_[i]);
      norm2 = g2 > norm2 ? g2 : norm2;
    }
    if (count_ == 0 || !(norm2 > 0)) return {0, 0, 0};
    const double tau = radius / std::sqrt(norm2);
    weight[largest] = 1;
    Vec3 d = -tau * gradient_[largest];
    for (int round = 0; round < kExchanges; ++round) {
      int to = 0;
      int from = -1;
      double high = -1e300;
      double low = 1e300;
      for (int i = 0; i < count_; ++i) {
        const double modeled = value_[i] + dot(gradient_[i], d);
        if (modeled > high) {
          high = modeled;
          to = i;
        }
        if (weight[i] > 0 && modeled < low) {
          low = modeled;
          from = i;
        }
      }
      if (from < 0) break;
      const Vec3 difference = gradient_[to] - gradient_[from];
      const double curvature = tau * dot(difference, difference);
      if (!(high - low > kTolerance * radius * std::sqrt(norm2)) || !(curvature > 0)) break;
      double moved = (high - low) / curvature;
      moved = moved < weight[from] ? moved : weight[from];
      weight[to] += moved;
      weight[from] -= moved;
      d = d - (tau * moved) * difference;
    }
    return d;
  }

 private:
  static constexpr int kMaxFunctions = 40;
  static constexpr double kMaxNorm2 = 1e200;
  static constexpr int kExchanges = 400;
  static constexpr double kTolerance = 1e-10;

  double value_[kMaxFunctions];
  Vec3 gradient_[kMaxFunctions];
  int count_ = 0;
};

}  // namespace tetune

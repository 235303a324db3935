// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/macros.hpp"

#include <cmath>

namespace tetune {

/// The minimum of f() on [a, b] by Brent's method: golden section search with parabolic interpolation through the
/// best three points where that converges (Brent 1973, ch. 5; Press et al., Numerical Recipes).
template <class F>
TETUNE_HD double brent_minimum(const F& f, double a, double b) {
  constexpr double kGolden = 0.38196601125010515;
  constexpr double kTolerance = 1e-6;  // relative to b - a; below about 1e-8 f is constant up to rounding
  constexpr int kMaxIterations = 60;
  using std::fabs;
  const double tolerance = kTolerance * (b - a);
  double x = a + kGolden * (b - a);
  double w = x;
  double v = x;
  double fx = f(x);
  double fw = fx;
  double fv = fx;
  double step = 0, before_last = 0;
  for (int i = 0; i < kMaxIterations; ++i) {
    const double middle = 0.5 * (a + b);
    if (fabs(x - middle) <= 2 * tolerance - 0.5 * (b - a)) break;
    bool parabola = false;
    if (fabs(before_last) > tolerance) {
      const double r = (x - w) * (fx - fv);
      const double s = (x - v) * (fx - fw);
      const double q = 2 * fabs(s - r);
      const double numerator = (x - v) * s - (x - w) * r;
      const double p = s - r > 0 ? -numerator : numerator;
      if (fabs(p) < fabs(0.5 * q * before_last) && p > q * (a - x) && p < q * (b - x)) {
        before_last = step;
        step = p / q;
        const double u = x + step;
        if (u - a < 2 * tolerance || b - u < 2 * tolerance) step = x < middle ? tolerance : -tolerance;
        parabola = true;
      }
    }
    if (!parabola) {
      before_last = x < middle ? b - x : a - x;
      step = kGolden * before_last;
    }
    const double u = x + (fabs(step) >= tolerance ? step : step > 0 ? tolerance : -tolerance);
    const double fu = f(u);
    if (fu <= fx) {
      (u < x ? b : a) = x;
      v = w;
      fv = fw;
      w = x;
      fw = fx;
      x = u;
      fx = fu;
    } else {
      (u < x ? a : b) = u;
      if (fu <= fw || w == x) {
        v = w;
        fv = fw;
        w = u;
        fw = fu;
      } else if (fu <= fv || v == x || v == w) {
        v = u;
        fv = fu;
      }
    }
  }
  return x;
}

}  // namespace tetune

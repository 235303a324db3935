// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <vector>

namespace tetune {
namespace minimize_detail {

/// The decrease that the line search accepts, as a fraction of that of the linear model (Armijo's condition).
inline constexpr double kSufficientDecrease = 1e-4;
/// A pair of steps of x and of the gradient is kept if the cosine of the angle between them is above this.
inline constexpr double kMinCurvature = 1e-12;

inline double product(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

inline void add(std::vector<double>& to, double factor, const std::vector<double>& v) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += factor * v[i];
}

}  // namespace minimize_detail

/// Minimizes a function of many variables by the L-BFGS method (Nocedal & Wright 2006, Alg. 7.4 and 7.5) with a
/// backtracking line search. `evaluate(x, gradient)` returns the value, which may be infinite, and sets the gradient;
/// it must be finite at the start. Returns the value at `x`, which has not increased. `step` is the length of the first
/// step, in the largest component. Ends early once stop() is true.
template <class Evaluate, class Stop>
double minimize_lbfgs(std::vector<double>& x, double step, int iterations, const Evaluate& evaluate, const Stop& stop) {
  constexpr std::size_t kPairs = 10;
  constexpr int kMaxHalvings = 30;
  constexpr double kRelativeDecrease = 1e-6;
  struct Pair {
    std::vector<double> dx, dg;
    double inverse;  ///< of their scalar product
  };
  using namespace minimize_detail;
  std::deque<Pair> pairs;
  std::vector<double> gradient(x.size());
  double value = evaluate(x, gradient);
  std::vector<double> next(x.size()), next_gradient(x.size());
  for (int i = 0; i < iterations && !stop(); ++i) {
    std::vector<double> direction = gradient;
    std::vector<double> alpha(pairs.size());
    for (std::size_t k = pairs.size(); k-- > 0;) {
      alpha[k] = pairs[k].inverse * product(pairs[k].dx, direction);
      add(direction, -alpha[k], pairs[k].dg);
    }
    double largest = 0;
    for (const double g : gradient) largest = std::max(largest, std::fabs(g));
    if (largest == 0) break;
    const double scale =
        pairs.empty() ? step / largest : 1 / (pairs.back().inverse * product(pairs.back().dg, pairs.back().dg));
    for (double& d : direction) d *= scale;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      add(direction, alpha[k] - pairs[k].inverse * product(pairs[k].dg, direction), pairs[k].dx);
    }
    const double slope = -product(direction, gradient);
    if (!(slope < 0)) break;
    double length = 1, next_value = value;
    bool found = false;
    for (int h = 0; h < kMaxHalvings && !found; ++h, length /= 2) {
      next = x;
      add(next, -length, direction);
      next_value = evaluate(next, next_gradient);
      found = next_value <= value + kSufficientDecrease * length * slope;
    }
    if (!found) {
      if (pairs.empty()) break;
      pairs.clear();  // continue by steepest descent
      continue;
    }
    Pair pair{next, next_gradient, 0};
    add(pair.dx, -1, x);
    add(pair.dg, -1, gradient);
    const double curvature = product(pair.dx, pair.dg);
    const double decrease = value - next_value;
    x.swap(next);
    gradient.swap(next_gradient);
    value = next_value;
    if (decrease <= kRelativeDecrease * std::fabs(value)) break;
    if (!(curvature > kMinCurvature * std::sqrt(product(pair.dx, pair.dx) * product(pair.dg, pair.dg)))) continue;
    pair.inverse = 1 / curvature;
    pairs.push_back(std::move(pair));
    if (pairs.size() > kPairs) pairs.pop_front();
  }
  return value;
}

}  // namespace tetune

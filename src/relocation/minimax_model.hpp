// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "backend/pack.hpp"
#include "backend/team.hpp"
#include "math/vec3.hpp"

namespace tetune {

/// A step, and the largest modeled value after it.
struct MinimaxStep {
  Vec3 d;
  double value;
};

/// A model of the maximum of several functions of a position: each by its value and gradient. Its minimum within a
/// given distance is the step of a method for nonsmooth functions (the proximal form of the active-set method of
/// Freitag and Ollivier-Gooch, "Tetrahedral mesh improvement using swapping and smoothing", 1997). In the memory of one
/// thread, or in that which a team shares.
class MinimaxModel {
 public:
  static constexpr int kMaxFunctions = 40;  ///< a multiple of the lanes of a pack

  /// Removes all functions. Called by all threads of a team; in memory of a team, before anything else.
  template <class Team>
  TETUNE_HD void clear(const Team& team) {
    team.sync();
    if (team.rank() == 0) added_ = 0;
    team.sync();
  }
  /// Adds functions of each thread of a team, in the order of the threads: `add_own(add)` calls add(value, number) for
  /// each function of the thread, with the same arguments each time. Those for which there is no room are counted.
  template <class AddOwn, class Team>
  TETUNE_HD void add_in_order(const AddOwn& add_own, const Team& team) {
    if constexpr (Team::kSize == 1) {
      add_own([this](double value, int function) { store(value, function, added_++); });
      return;
    }
    int own = 0;
    add_own([&own](double, int) { ++own; });
    int at = added_;
    int added = added_;
    for (int k = 0; team.any(k < own); ++k) {
      const backend::Placement more = team.rank_among(k < own);
      at += more.before;
      added += more.count;
    }
    team.sync();
    add_own([&](double value, int function) { store(value, function, at++); });
    if (team.rank() == 0) added_ = added;
    team.sync();
  }
  /// The number of functions that were added. Those beyond kMaxFunctions are not in the model.
  TETUNE_HD int added() const { return added_; }
  /// Sets the gradients of all functions: `project(g)` for each g of `gradients_of(functions)`, which gets one function
  /// per lane of TermsOf<Team>. Functions whose gradient overflows, as at volumes close to underflow, do not count.
  /// Called by all threads of a team.
  template <class GradientsOf, class Project, class Team = backend::SingleThread>
  TETUNE_HD void set_gradients(const GradientsOf& gradients_of, const Project& project, const Team& team = {}) {
    constexpr int kLanes = kLanesOf<backend::TermsOf<Team>>;
    team.sync();
    const int size = count();
    for (int first = team.rank() * kLanes; first < size; first += Team::kSize * kLanes) {
      int functions[kLanes];
      for (int l = 0; l < kLanes; ++l) functions[l] = function_[first + l < size ? first + l : size - 1];
      const auto gradients = gradients_of(functions);
      for (int l = 0; l < kLanes && first + l < size; ++l) {
        set_gradient(first + l, project({lane(gradients.x, l), lane(gradients.y, l), lane(gradients.z, l)}));
      }
    }
    team.sync();
  }

  /// The step d of at most `radius` that minimizes the model with a quadratic term |d|^2 / (2 tau), so that a single
  /// function would decrease by the whole radius. d = -tau sum l_i g_i, where the weights l of the simplex maximize the
  /// dual. They are found by its active-set method (after Goldfarb and Idnani, 1983), which ends after a few steps: the
  /// active functions have the same modeled value, and the one of the largest value joins them until none is larger.
  /// Called by all threads of a team, with equal results.
  template <class Team = backend::SingleThread>
  TETUNE_HD TETUNE_OUTLINE MinimaxStep step(double radius, const Team& team = {}) const {
    backend::IndexedMax largest{kLowest, 0};
    backend::Max norm2{0};
    for (int i = team.rank(); i < count(); i += Team::kSize) {
      largest.add(value_[i], i);
      norm2.merge({dot(gradient(i), gradient(i))});
    }
    largest = team.merge(largest);
    norm2 = team.merge(norm2);
    if (!(norm2.value > 0)) return {{0, 0, 0}, largest.value};
    const double tau = radius / std::sqrt(norm2.value);
    ActiveSet active{{largest.index}, {1}, 1};
    Vec3 d = -tau * gradient(largest.index);
    for (int round = 0;; ++round) {
      const backend::IndexedMax next = largest_after(d, team);
      const double gap = next.value - modeled(active.function[0], d);
      const bool is_optimal = !(gap > kTolerance * tau * norm2.value);
      if (is_optimal || round == kMaxRounds || !activate(active, next.index, gap / tau)) return {d, next.value};
      d = {0, 0, 0};
      for (int k = 0; k < active.size; ++k) d = d - (tau * active.weight[k]) * gradient(active.function[k]);
    }
  }

 private:
  TETUNE_HD void store(double value, int function, int at) {
    if (at >= kMaxFunctions) return;
    value_[at] = value;
    function_[at] = function;
  }

  static constexpr double kMaxNorm2 = 1e100;
  static constexpr int kMaxRounds = 64;
  /// The largest modeled value is minimal to within this part of what a single function would decrease by.
  static constexpr double kTolerance = 1e-6;
  /// A gradient is in the affine hull of others if the square of its distance is at most this part of the square of its
  /// distance from one of them.
  static constexpr double kDependent = 1e-15;
  static constexpr double kLowest = -1e300;

  /// Functions with affinely independent gradients, and their weights.
  struct ActiveSet {
    static constexpr int kMaxSize = 4;
    int function[kMaxSize];
    double weight[kMaxSize];
    int size;
    TETUNE_HD void add(int i, double w) {
      function[size] = i;
      weight[size++] = w;
    }
    TETUNE_HD void remove(int k) {
      function[k] = function[--size];
      weight[k] = weight[size];
    }
  };
  /// Changes of the weights of an active set when another function gets weight at rate 1, such that the sum of all is
  /// constant and the modeled values stay equal; and that of the sum of the weighted gradients.
  struct WeightRates {
    double weight[ActiveSet::kMaxSize];
    Vec3 gradient;
  };

  TETUNE_HD void set_gradient(int i, Vec3 gradient) {
    if (!(dot(gradient, gradient) < kMaxNorm2)) {
      gradient = {0, 0, 0};
      value_[i] = kLowest;
    }
    x_[i] = gradient.x;
    y_[i] = gradient.y;
    z_[i] = gradient.z;
  }
  TETUNE_HD Vec3 gradient(int i) const { return {x_[i], y_[i], z_[i]}; }
  TETUNE_HD double modeled(int i, const Vec3& d) const { return value_[i] + dot(gradient(i), d); }

  /// Projects the gradient of function i on the affine hull of the active ones.
  TETUNE_HD WeightRates rates_of(const ActiveSet& active, int i) const {
    const Vec3 origin = gradient(active.function[0]);
    const Vec3 p = gradient(i) - origin;
    Vec3 b[ActiveSet::kMaxSize - 1];
    for (int k = 1; k < active.size; ++k) b[k - 1] = gradient(active.function[k]) - origin;
    double r[ActiveSet::kMaxSize - 1] = {0, 0, 0};
    Vec3 rest = p;
    if (active.size == 2) {
      r[0] = dot(p, b[0]) / dot(b[0], b[0]);
      rest = p - r[0] * b[0];
    } else if (active.size == 3) {
      const Vec3 n = cross(b[0], b[1]);
      const double n2 = dot(n, n);
      r[0] = dot(cross(p, b[1]), n) / n2;
      r[1] = dot(cross(b[0], p), n) / n2;
      rest = (dot(p, n) / n2) * n;
    } else if (active.size == 4) {
      const double det = dot(b[0], cross(b[1], b[2]));
      r[0] = dot(p, cross(b[1], b[2])) / det;
      r[1] = dot(p, cross(b[2], b[0])) / det;
      r[2] = dot(p, cross(b[0], b[1])) / det;
      rest = {0, 0, 0};
    }
    if (dot(rest, rest) <= kDependent * dot(p, p)) rest = {0, 0, 0};
    return {{r[0] + r[1] + r[2] - 1, -r[0], -r[1], -r[2]}, rest};
  }
  /// Makes function i active: gives it weight until its modeled value, which is above that of the active ones by
  /// `gap` times tau, is theirs. Functions whose weight vanishes on the way become inactive. Returns false where
  /// rounding errors prevent it.
  TETUNE_HD bool activate(ActiveSet& active, int i, double gap) const {
    double weight = 0;
    while (active.size > 0) {
      const WeightRates rates = rates_of(active, i);
      const double curvature = dot(rates.gradient, rates.gradient);
      double moved = curvature > 0 ? gap / curvature : HUGE_VAL;
      int vanishing = -1;
      for (int k = 0; k < active.size; ++k) {
        if (rates.weight[k] < 0 && active.weight[k] < -rates.weight[k] * moved) {
          moved = active.weight[k] / -rates.weight[k];
          vanishing = k;
        }
      }
      if (!(moved < HUGE_VAL)) return false;
      for (int k = 0; k < active.size; ++k) active.weight[k] += moved * rates.weight[k];
      weight += moved;
      if (vanishing < 0) break;
      active.remove(vanishing);
      gap = gap > moved * curvature ? gap - moved * curvature : 0;
    }
    active.add(i, weight);
    return true;
  }

  /// 0, 1, ..., one per lane.
  template <class Pack>
  TETUNE_INLINE static Pack first_indices() {
    Pack index{};
    for (int l = 0; l < kLanesOf<Pack>; ++l) index[l] = l;
    return index;
  }
  /// The maximum of each lane, with its index.
  template <class Pack>
  struct PackMax {
    Pack value, index;
    TETUNE_INLINE void add(const Pack& other, const Pack& at) {
      const auto larger = other > value;
      value = larger ? other : value;
      index = larger ? at : index;
    }
    TETUNE_INLINE void merge_to(backend::IndexedMax& max) const {
      for (int l = 0; l < kLanesOf<Pack>; ++l) max.merge({lane(value, l), int(lane(index, l))});
    }
  };
  /// The function of the largest modeled value after step d.
  template <class Team>
  TETUNE_HD backend::IndexedMax largest_after(const Vec3& d, const Team& team) const {
    using Pack = backend::TermsOf<Team>;
    backend::IndexedMax largest{kLowest, 0};
    if constexpr (kLanesOf<Pack> != 1) {
      const Pack zero{};
      const Vec3T<Pack> step{zero + d.x, zero + d.y, zero + d.z};
      Pack index = first_indices<Pack>();
      PackMax<Pack> lanes{zero + kLowest, zero};
      for (int i = 0; i < count(); i += kLanesOf<Pack>, index += kLanesOf<Pack>) {
        const Vec3T<Pack> gradients{backend::load<Pack>(x_ + i), backend::load<Pack>(y_ + i),
                                    backend::load<Pack>(z_ + i)};
        const Pack modeled = backend::load<Pack>(value_ + i) + dot(gradients, step);
        lanes.add(index < count() ? modeled : zero + kLowest, index);
      }
      lanes.merge_to(largest);
    } else {
      for (int i = team.rank(); i < count(); i += Team::kSize) largest.add(modeled(i, d), i);
      largest = team.merge(largest);
    }
    return largest;
  }
  TETUNE_HD int count() const { return added_ < kMaxFunctions ? added_ : kMaxFunctions; }

  double value_[kMaxFunctions];
  double x_[kMaxFunctions], y_[kMaxFunctions], z_[kMaxFunctions];  ///< the gradients
  int function_[kMaxFunctions];
  int added_ = 0;
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "backend/team.hpp"
#include "mesh/gather.hpp"

namespace tetune {

/// A model of the maximum of several functions of a position: each by its value and gradient. Its minimum within a
/// given distance is the step of a method for nonsmooth functions (the proximal form of the active-set method of
/// Freitag and Ollivier-Gooch, "Tetrahedral mesh improvement using swapping and smoothing", 1997). In the memory of one
/// thread, or in that which a team shares.
class MinimaxModel {
 public:
  /// Removes all functions. Called by all threads of a team; in memory of a team, before anything else.
  template <class Team>
  TETUNE_HD void clear(const Team& team) {
    team.sync();
    if (team.rank() == 0) count_ = 0;
    team.sync();
  }
  /// Adds a function by its value and a number. Where there is no room, it replaces the one of the smallest value if
  /// its own is larger.
  template <class Pack = double>
  TETUNE_HD void add(double value, int function) {
    if (count_ == kMaxFunctions && value <= value_[smallest_]) return;
    const int at = count_ == kMaxFunctions ? smallest_ : count_++;
    value_[at] = value;
    function_[at] = function;
    if (count_ == kMaxFunctions) find_smallest<Pack>();
  }
  /// Sets the gradients of all functions: `gradient_of(function)`. Functions whose gradient overflows, as at volumes
  /// close to underflow, do not count. Called by all threads of a team.
  template <class GradientOf, class Team = backend::SingleThread>
  TETUNE_HD void set_gradients(const GradientOf& gradient_of, const Team& team = {}) {
    team.sync();
    for (int i = team.rank(); i < count_; i += Team::kSize) {
      Vec3 gradient = gradient_of(function_[i]);
      if (!(dot(gradient, gradient) < kMaxNorm2)) {
        gradient = {0, 0, 0};
        value_[i] = kLowest;
      }
      x_[i] = gradient.x;
      y_[i] = gradient.y;
      z_[i] = gradient.z;
    }
    team.sync();
  }

  /// The step of at most `radius` that minimizes the model with a quadratic term, so that a single function would
  /// decrease by the whole radius: d = -tau sum l_i g_i, where the weights l maximize the dual. They are found by
  /// pairwise exchange between the function of the largest and that of the smallest modeled value.
  template <class Team = backend::SingleThread>
  TETUNE_HD Vec3 step(double radius, const Team& team = {}) const {
    // Function i belongs to thread i % kSize of the team.
    double weight[(kMaxFunctions + Team::kSize - 1) / Team::kSize] = {};
    backend::IndexedMax largest{kLowest, 0};
    backend::IndexedMax norm2{0, 0};
    for (int i = team.rank(); i < count_; i += Team::kSize) {
      largest.add(value_[i], i);
      norm2.add(dot(gradient(i), gradient(i)), i);
    }
    largest = team.merge(largest);
    norm2 = team.merge(norm2);
    if (!(norm2.value > 0)) return {0, 0, 0};
    const double tau = radius / std::sqrt(norm2.value);
    if (owns(team, largest.index)) weight[largest.index / Team::kSize] = 1;
    Vec3 d = -tau * gradient(largest.index);
    for (int round = 0; round < kExchanges; ++round) {
      backend::IndexedMax high{kLowest, 0};
      backend::IndexedMax low{kLowest, -1};  // of the negative values
      find_extremes(d, weight, high, low, team);
      if (low.index < 0) break;
      const Vec3 difference = gradient(high.index) - gradient(low.index);
      const double curvature = tau * dot(difference, difference);
      const double gap = high.value + low.value;
      if (!(gap > kTolerance * radius * std::sqrt(norm2.value)) || !(curvature > 0)) break;
      const double available = team.broadcast(weight[low.index / Team::kSize], low.index % Team::kSize);
      const double moved = gap / curvature < available ? gap / curvature : available;
      if (owns(team, high.index)) weight[high.index / Team::kSize] += moved;
      if (owns(team, low.index)) weight[low.index / Team::kSize] -= moved;
      d = d - (tau * moved) * difference;
    }
    return d;
  }

 private:
  static constexpr int kMaxFunctions = 40;  ///< a multiple of the lanes of a pack
  static constexpr double kMaxNorm2 = 1e200;
  static constexpr int kExchanges = 400;
  static constexpr double kTolerance = 1e-10;
  static constexpr double kLowest = -1e300;

  template <class Team>
  TETUNE_HD static bool owns(const Team& team, int i) {
    return i % Team::kSize == team.rank();
  }
  TETUNE_HD Vec3 gradient(int i) const { return {x_[i], y_[i], z_[i]}; }

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
  /// The largest modeled value after step d, and the largest negative one of the functions with a weight.
  template <class Team>
  TETUNE_HD void find_extremes(const Vec3& d, const double* weight, backend::IndexedMax& high, backend::IndexedMax& low,
                               const Team& team) const {
    using Pack = backend::TermsOf<Team>;
    if constexpr (kLanesOf<Pack> != 1) {
      const Pack zero{};
      const Vec3T<Pack> step{zero + d.x, zero + d.y, zero + d.z};
      Pack index = first_indices<Pack>();
      PackMax<Pack> highs{zero + kLowest, zero};
      PackMax<Pack> lows{zero + kLowest, zero - 1};
      for (int i = 0; i < count_; i += kLanesOf<Pack>, index += kLanesOf<Pack>) {
        const Vec3T<Pack> gradients{backend::load<Pack>(x_ + i), backend::load<Pack>(y_ + i),
                                    backend::load<Pack>(z_ + i)};
        const Pack modeled = backend::load<Pack>(value_ + i) + dot(gradients, step);
        highs.add(index < count_ ? modeled : zero + kLowest, index);
        lows.add(backend::load<Pack>(weight + i) > 0 ? -modeled : zero + kLowest, index);
      }
      highs.merge_to(high);
      lows.merge_to(low);
    } else {
      for (int i = team.rank(); i < count_; i += Team::kSize) {
        const double modeled = value_[i] + dot(gradient(i), d);
        high.add(modeled, i);
        if (weight[i / Team::kSize] > 0) low.add(-modeled, i);
      }
      high = team.merge(high);
      low = team.merge(low);
    }
  }
  template <class Pack>
  TETUNE_HD void find_smallest() {
    backend::IndexedMax smallest{kLowest, 0};  // of the negative values
    if constexpr (kLanesOf<Pack> != 1) {
      PackMax<Pack> lanes{Pack{} + kLowest, Pack{}};
      Pack index = first_indices<Pack>();
      for (int i = 0; i < kMaxFunctions; i += kLanesOf<Pack>, index += kLanesOf<Pack>) {
        lanes.add(-backend::load<Pack>(value_ + i), index);
      }
      lanes.merge_to(smallest);
    } else {
      for (int i = 0; i < kMaxFunctions; ++i) smallest.add(-value_[i], i);
    }
    smallest_ = smallest.index;
  }

  double value_[kMaxFunctions];
  double x_[kMaxFunctions], y_[kMaxFunctions], z_[kMaxFunctions];  ///< the gradients
  int function_[kMaxFunctions];
  int count_ = 0;
  int smallest_ = 0;  ///< the function of the smallest value, once there is no room
};

}  // namespace tetune

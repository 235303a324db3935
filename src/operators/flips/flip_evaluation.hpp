// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/engine/flip_energy_lower_bound.hpp"
#include "operators/engine/slots.hpp"

/// The candidates of a tetrahedron, the tetrahedron that owns a candidate, and the result of an evaluation.
namespace tetune {

/// The order that decides which tetrahedron of a cavity owns its candidate: the worst, the lowest of equals.
struct IsWorse {
  Span<const double> energies;
  Index t;
  double energy_t;
  TETUNE_HD bool operator()(Index other) const {
    const double energy = energies[other];
    return (energy > energy_t) | ((energy == energy_t) & (other < t));
  }
};

/// The result of evaluating a tetrahedron's candidates.
struct FlipEvaluation {
  double min_ratio;  ///< of the energy after to that before, over all candidates
  Size evaluated = 0;

  TETUNE_HD void add(double ratio) { min_ratio = ratio < min_ratio ? ratio : min_ratio; }
  /// Whether a cavity of this energy may gain, when the energy afterwards is not less than `bound`.
  TETUNE_HD bool may_gain(double bound, double before) {
    if (!(bound > (1 + kBoundMargin) * before)) return true;
    add(bound / before);
    return false;
  }
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/flip_energy_lower_bound.hpp"
#include "operators/slots.hpp"

/// The candidates of a tetrahedron, the tetrahedron that owns a candidate, and the result of an evaluation.
namespace tetune {

/// Candidates 0 to 3 of a tetrahedron are its faces, 4 to 9 its edges.
TETUNE_HD inline std::uint32_t flip_id(Index t, int candidate) {
  return static_cast<std::uint32_t>(t) * kCandidates + static_cast<std::uint32_t>(candidate);
}

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

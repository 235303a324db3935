// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/objective.hpp"

/// A lower bound of the energy that a flip can leave behind, for all positions of its vertices: around an inner edge
/// dihedral angles add up to a full turn, so that not all tetrahedra can be regular. It holds for the plain shape
/// energy, which is free of scale, and is 0 for others. Most candidates are rejected by it alone (docs/method.md).
namespace tetune {

/// A cavity is evaluated when the bound leaves room for a gain, or for a loss below this part: its slack is then exact.
inline constexpr double kBoundMargin = 0.05;

/// The largest ring in which a tetrahedron can be the worst and the removal of the edge still gain, and a lower bound
/// of the ratio of the energy after to that before for all larger rings.
struct RingBound {
  int max_ring;
  double min_ratio;
};

class FlipEnergyLowerBound {
 public:
  TETUNE_HD explicit FlipEnergyLowerBound(const Objective& objective)
      : is_plain_shape_(objective.shape && objective.log2_power == 0) {}

  /// Whether a tetrahedron of this energy may own a candidate that gains. If no tetrahedron around an edge has a larger
  /// energy, the removal of the edge cannot gain where they are five or more, and gains almost nothing where they are
  /// four.
  TETUNE_HD bool may_gain(double energy) const { return !is_plain_shape_ || !(5 * energy <= edge_removal(5)); }

  /// For the three tetrahedra that a 2-3 flip makes: three dihedral angles of 120 degrees.
  TETUNE_HD double face_flip() const { return is_plain_shape_ ? 4.2866 : 0; }
  /// For the removal of an edge with n tetrahedra around it: minima over all positions, found numerically; that of 7
  /// for more.
  TETUNE_HD double edge_removal(int n) const {
    if (!is_plain_shape_) return 0;
    return n == 3 ? 2 : n == 4 ? 4.2426 : n == 5 ? 6.7527 : n == 6 ? 9.3234 : 12.1421;
  }

  /// For a tetrahedron that may gain.
  TETUNE_HD RingBound ring_bound(double worst, int max_ring) const {
    if (!is_plain_shape_) return {max_ring, kInfeasible};
    const double max_energy = (1 + kBoundMargin) * worst;
    int ring = max_ring < 5 ? max_ring : 5;
    while (ring < max_ring && edge_removal(ring + 1) <= (ring + 1) * max_energy) ++ring;
    return {ring, ring < max_ring ? edge_removal(ring + 1) / ((ring + 1) * worst) : kInfeasible};
  }

 private:
  bool is_plain_shape_;
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/energy_law.hpp"
#include "flips/flip.hpp"

/// The least energy that a flip can leave behind, wherever its vertices are: around an inner edge dihedral angles add
/// up to a full turn, so that not all tetrahedra can be regular. Of the shape energy alone, which knows no size. Most
/// flips need no other look than this (docs/method.md, "Which flips are looked at").
namespace tetune {

/// A cavity is evaluated when the bound leaves room for a gain, or for less than this loss: its slack is then exact.
inline constexpr double kBoundMargin = 0.05;

/// Largest ring in which a tetrahedron can be the worst and its removal still pay, and the least ratio of the energy
/// after to that before for all others.
struct RingLimit {
  int ring;
  double ratio;
};

class LeastAfter {
 public:
  TETUNE_HD explicit LeastAfter(const EnergyLaw& law) : known_(law.shape && law.squarings == 0) {}

  /// Whether a tetrahedron may be the worst of a cavity that is looked at. Where all are so good, an edge with five or
  /// more around it cannot be removed with gain, and exchanges of four for four gain next to nothing.
  TETUNE_HD bool worth_a_look(double energy) const { return !known_ || !(5 * energy <= removal(5)); }

  /// Of the three tetrahedra that a 2-3 flip makes: three dihedral angles of 120 degrees.
  TETUNE_HD double split() const { return known_ ? 4.2866 : 0; }
  /// Of the removal of an edge with n tetrahedra around it: minima over all positions, found numerically.
  TETUNE_HD double removal(int n) const {
    if (!known_) return 0;
    return n == 3 ? 2 : n == 4 ? 4.2426 : n == 5 ? 6.7527 : n == 6 ? 9.3234 : 12.1421;
  }

  /// For a tetrahedron that is worth a look.
  TETUNE_HD RingLimit ring_limit(double worst, int max_ring) const {
    if (!known_) return {max_ring, kNever};
    const double most = (1 + kBoundMargin) * worst;
    int ring = max_ring < 5 ? max_ring : 5;
    while (ring < max_ring && removal(ring + 1) <= (ring + 1) * most) ++ring;
    return {ring, ring < max_ring ? removal(ring + 1) / ((ring + 1) * worst) : kNever};
  }

 private:
  bool known_;
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/stars/star_proposals.hpp"

namespace tetune {

/// A cavity around a tetrahedron retriangulated from each of its vertices: it grows across the face whose new
/// tetrahedron is worst. Flips, edge removals and multi-face removals of any size are special cases.
struct CavityRetriangulation {
  static constexpr int kChoices = 4;
  /// With rings of at most three tetrahedra only the flips of the paper are made.
  static constexpr int kMinRing = 4;

  template <class Proposal>
  TETUNE_HD static void propose(const Proposal& p, Index t, int corner) {
    if (p.max_ring < kMinRing) return;
    const Index apex = p.mesh.tet2vertex[t][corner];
    StarCavity star = p.cavity();
    if (!star.take_tet(t, p.team)) return;
    const Vec3 x = vec(p.mesh.points[apex]);
    if (!p.grow(star, apex, x)) return;
    StarCandidate c = star.candidate(apex, kNoVertex, x);
    p.add(star, c);
  }
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/stars/star_proposals.hpp"

namespace tetune {

/// A vertex inserted near the midpoint of each edge of a tetrahedron, and one inside it; the cavity grows while that
/// lowers the energy (Klingner and Shewchuk, "Aggressive tetrahedral mesh improvement", 2007).
struct VertexInsertion {
  static constexpr int kInside = 6;  ///< the choice after those of the edges
  static constexpr int kChoices = kInside + 1;

  template <class Proposal>
  TETUNE_HD static void propose(const Proposal& p, Index t, int choice) {
    if (!p.edits || !p.inserts) return;
    StarCavity star = p.cavity();
    if (choice == kInside) {
      if (!p.is_selective) insert_inside(p, t, star);
      return;
    }
    const Tet tet = p.mesh.tet2vertex[t];
    const EdgeCorners e = edge_corners(choice);
    if (!star.take_edge(t, choice, p.team) || !p.is_long_enough(star, tet[e.i], tet[e.j]) ||
        p.is_shared_with_earlier(star, t)) {
      return;
    }
    const Vec3 middle = 0.5 * (vec(p.mesh.points[tet[e.i]]) + vec(p.mesh.points[tet[e.j]]));
    insert(p, star, star.relax_and_grow(star.relax(middle, p.team), p.team));
  }

 private:
  template <class Proposal>
  TETUNE_HD static void insert_inside(const Proposal& p, Index t, StarCavity& star) {
    if (!star.take_tet(t, p.team)) return;
    const Tet tet = p.mesh.tet2vertex[t];
    Vec3 x{0, 0, 0};
    for (int k = 0; k < 4; ++k) x = x + 0.25 * vec(p.mesh.points[tet[k]]);
    insert(p, star, x);
  }
  template <class Proposal>
  TETUNE_HD static void insert(const Proposal& p, StarCavity& star, Vec3 x) {
    if (!p.place_new_vertex(star, x)) return;
    StarCandidate c = star.candidate(kNewVertex, kNoVertex, x);
    p.add(star, c);
  }
};

}  // namespace tetune

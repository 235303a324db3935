// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/star_proposals.hpp"

namespace tetune {

/// The best removal of an edge of a tetrahedron with a vertex of its ring moved at the same time: a composite operation
/// (Klingner and Shewchuk, "Aggressive tetrahedral mesh improvement", 2007).
struct CompositeRemoval {
  static constexpr int kChoices = 1;
  /// The maximum number of tetrahedra around the edge: with more it hardly ever helps.
  static constexpr int kMaxEdgeTets = 6;

  TETUNE_HD static void propose(const StarProposal& p, Index t, int) {
    Move best{StarCavity(p.mesh, p.constrained), -1, {}, 0, kAcceptRatio};
    const Tet tet = p.mesh.tet2vertex[t];
    for (int edge = 0; edge < 6; ++edge) {
      StarCavity ring(p.mesh, p.constrained);
      if (!ring.take_edge(t, edge) || ring.tet_count() > kMaxEdgeTets || ring.tet_count() > p.max_ring) continue;
      const EdgeCorners e = edge_corners(edge);
      Index before = tet[e.k];
      for (int i = 0; i < ring.tet_count(); ++i) {
        // Tetrahedron i has the vertices before and after the face to the next one.
        const Tet current = p.mesh.tet2vertex[ring.tet(i)];
        Index v = before;
        for (int k = 0; k < 4; ++k) {
          v = current[k] != tet[e.i] && current[k] != tet[e.j] && current[k] != before ? current[k] : v;
        }
        before = v;
        if (p.is_movable(v)) try_move(p, ring, v, best);
      }
    }
    if (best.v < 0) return;
    StarCandidate c = best.star.candidate(best.v, kNoVertex, best.star.lower_cost(best.x));
    c.is_moved = true;
    p.add(best.star, best.before, c);
  }

 private:
  /// A vertex moved so that the cavity can be retriangulated from it.
  struct Move {
    StarCavity star;
    Index v;  ///< -1: none
    Vec3 x;
    double before;
    double ratio;  ///< of the cotangents after and before
  };
  TETUNE_HD static void try_move(const StarProposal& p, StarCavity star, Index v, Move& best) {
    if (!star.take_all_around(v)) return;
    Vec3 x = vec(p.mesh.points[v]);
    if (!star.find_kernel_point(x)) return;
    x = star.relax(x);
    const double screen = kScreenRatio * best.ratio * star.cost_before();
    if (!(star.cost_after(v, x, screen) < screen)) return;
    x = star.relax_and_grow(x);
    const double before = star.cost_before();
    const double limit = best.ratio * before;
    const double after = star.cost_after(v, x, limit);
    if (after < limit && star.preserves_constraints(v)) best = {star, v, x, before, after / before};
  }
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/star_proposals.hpp"

namespace tetune {

/// A vertex inserted near the midpoint of each edge of a tetrahedron; its cavity grows while that lowers the energy
/// (Klingner and Shewchuk, "Aggressive tetrahedral mesh improvement", 2008).
struct VertexInsertion {
  static constexpr int kChoices = 6;

  TETUNE_HD static void propose(const StarProposal& p, Index t, int edge) {
    if (!p.may_change_vertices(t)) return;
    StarCavity star(p.mesh, p.constrained);
    if (!star.take_edge(t, edge)) return;
    const Tet tet = p.mesh.tet2vertex[t];
    const EdgeCorners e = edge_corners(edge);
    const Vec3 middle = 0.5 * (vec(p.mesh.points[tet[e.i]]) + vec(p.mesh.points[tet[e.j]]));
    const Vec3 x = star.relax_and_grow(star.relax(middle));
    const double before = star.cot_before();
    const double limit = kAcceptRatio * before;
    if (!(star.cot_after(kNewVertex, x, limit) < limit)) return;
    p.add(star, before, kNewVertex, kNoVertex, star.open_angle(x));
  }
};

}  // namespace tetune

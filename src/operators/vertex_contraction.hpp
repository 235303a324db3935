// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/star_proposals.hpp"

namespace tetune {

/// Each movable vertex of a tetrahedron removed by the contraction of an edge to each of the others.
struct VertexContraction {
  static constexpr int kChoices = 12;

  template <class Proposal>
  TETUNE_HD static void propose(const Proposal& p, Index t, int choice) {
    if (!p.may_change_vertices(t)) return;
    const Tet tet = p.mesh.tet2vertex[t];
    const int from = choice / 3;
    const int to = (from + 1 + choice % 3) % 4;
    StarCavity star = p.cavity();
    if (!p.is_movable(tet[from]) || !star.take_vertex(t, from, p.team)) return;
    if (p.is_contracted_earlier(star, tet[to], t)) return;
    const Vec3 x = vec(p.mesh.points[tet[to]]);
    if (!p.grow(star, tet[to], x)) return;
    p.add(star, p.candidate(star, tet[to], tet[from], x));
  }
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/prefetch.hpp"
#include "mesh/work_mesh.hpp"

namespace tetune {

/// Prefetches all that flips read and write of a tetrahedron.
TETUNE_INLINE void prefetch_tet(const MeshView& mesh, Span<const double> energies, Index t) {
  backend::prefetch(&mesh.tet2tet[t]);
  backend::prefetch(&mesh.tet2vertex[t]);
  backend::prefetch(&energies[t]);
}

/// Prefetches what the loop over the active tetrahedra needs soon: those, their neighbors, and the neighbors of these.
struct PrefetchAhead {
  MeshView mesh;
  Span<const double> energies;
  Span<const Index> active;

  TETUNE_INLINE void operator()(Size i) const {
    constexpr Size kTetsAhead = 24;
    constexpr Size kNeighborsAhead = 12;
    constexpr Size kSecondNeighborsAhead = 5;
    if (i + kTetsAhead >= active.size()) return;
    prefetch_tet(mesh, energies, active[i + kTetsAhead]);
    prefetch_neighbors(active[i + kNeighborsAhead]);
    const Index t = active[i + kSecondNeighborsAhead];
    const FaceAdjacency links = mesh.tet2tet[t];
    for (int face = 0; face < 4; ++face) prefetch_neighbors(neighbor(t, links[face]));
  }

 private:
  TETUNE_INLINE static Index neighbor(Index t, HalfFace across) { return is_locked(across) ? t : tet_of(across); }
  TETUNE_INLINE void prefetch_neighbors(Index t) const {
    const FaceAdjacency links = mesh.tet2tet[t];
    for (int face = 0; face < 4; ++face) prefetch_tet(mesh, energies, neighbor(t, links[face]));
  }
};

}  // namespace tetune

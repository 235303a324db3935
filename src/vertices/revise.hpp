// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "flips/flip_pass.hpp"
#include "relocate/sweep.hpp"

namespace tetune {

/// How many vertices revise_vertices() inserted and removed.
struct ReviseReport {
  Size inserted = 0, removed = 0;
};

/// Inserts and removes vertices where that opens the smallest dihedral angles, those whose cotangent is above `bound`.
/// Each tetrahedron with one proposes to insert a vertex on each of its edges, and to pull each of its free vertices
/// into each other; a proposal is carried out when it is the best one of all tetrahedra of its cavity. Surfaces and
/// constrained edges stay as they are.
///
/// Inserted vertices take the ids from mesh.vertices() on; removed ones are in no tetrahedron afterwards. The
/// vertex2original of both is kInserted or kRemoved. `mobilities.awake` is set for the vertices whose ring changed.
/// Rings, colours and the energies in `flips` have to be made anew. Nothing is changed where the mesh would get more
/// than `most_tets` tetrahedra.
template <class Backend>
ReviseReport revise_vertices(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& flips,
                             Mobilities<Backend>& mobilities, double bound, Size most_tets);

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "flips/flip_pass.hpp"
#include "relocate/sweep.hpp"

namespace tetune {

/// How many vertices revise_vertices() inserted and removed, and how many edges it removed by moving a vertex.
struct ReviseReport {
  Size inserted = 0, removed = 0;
  Size edges = 0;
};

/// Opens the smallest dihedral angles of some tetrahedra. Each proposes to remove one of its edges, with a vertex
/// around that edge moved to where this can be done; where it has an angle whose cotangent is above `vertex_cot`
/// (kNever: nowhere), also to insert a vertex on each of its edges, and to pull each of its free vertices into each
/// other. A proposal is carried out when it is the best one of all tetrahedra of its cavity. Surfaces and constrained
/// edges stay as they are.
///
/// Inserted vertices take the ids from mesh.vertices() on; removed ones are in no tetrahedron afterwards. The
/// vertex2original of both is kInserted or kRemoved. `mobilities.awake` is set for the vertices whose ring changed; the
/// energies in `flips` stay up to date, rings and colours have to be made anew. Nothing is changed where the mesh would
/// get more than `most_tets` tetrahedra.
template <class Backend>
ReviseReport revise_vertices(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& flips,
                             Mobilities<Backend>& mobilities, Span<const Index> around, Size most_tets,
                             double vertex_cot);

}  // namespace tetune

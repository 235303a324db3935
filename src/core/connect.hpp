// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/rows.hpp"
#include "core/work_mesh.hpp"

namespace tetune {

/// What build_adjacency() met. A valid mesh has zeros in the last two.
struct AdjacencyReport {
  Size boundary_faces = 0;
  Size crowded_faces = 0;    ///< sides of faces on three tetrahedra or more
  Size same_side_faces = 0;  ///< faces whose two tetrahedra lie on the same side
};

/// Renumbers a freshly uploaded mesh for locality: vertices along a Hilbert curve, tetrahedra by lowest vertex.
/// `mesh` holds points and tet2vertex in the caller's order.
template <class Backend>
void sort_mesh(const Backend& par, WorkMesh<Backend>& mesh);

/// How many faces seem to have the three vertices of another one, as flips make where a mesh overlaps itself. 0 is
/// certain, any other number is to be checked. The mesh is linked.
template <class Backend>
Size count_doubled_faces(const Backend& par, WorkMesh<Backend>& mesh);

/// Links each face with the one across it. Where a face is crowded or its tetrahedra lie on the same side,
/// the face is left as boundary and counted.
template <class Backend>
AdjacencyReport build_adjacency(const Backend& par, WorkMesh<Backend>& mesh);

/// The corners of each vertex: items are 4 * tet + local vertex.
template <class Backend>
void build_vertex2tet(const Backend& par, WorkMesh<Backend>& mesh, Rows<Backend>& vertex2tet);

/// Locks the faces between tetrahedra of different tags, given one for each of the caller's.
template <class Backend>
void lock_interfaces(const Backend& par, WorkMesh<Backend>& mesh, Span<const int> tags);

/// Moves the tetrahedra together so that no slot is free, and drops the links.
/// Returns the old slot of each tetrahedron.
template <class Backend>
typename Backend::template Buffer<Index> compact_slots(const Backend& par, WorkMesh<Backend>& mesh);

}  // namespace tetune

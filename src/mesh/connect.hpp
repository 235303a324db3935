// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mesh/csr.hpp"
#include "mesh/work_mesh.hpp"

/// Order and connectivity of the working mesh. Definitions: sort_mesh.inl, adjacency.inl, duplicate_faces.inl.
namespace tetune {

/// Defects found by build_adjacency(); a valid mesh has none.
struct AdjacencyReport {
  Size non_manifold_faces = 0;  ///< half-faces of faces that three or more tetrahedra share
  Size misoriented_faces = 0;   ///< faces whose two tetrahedra lie on the same side

  bool ok() const { return non_manifold_faces + misoriented_faces == 0; }
  TETUNE_HD void merge(const AdjacencyReport& other) {
    non_manifold_faces += other.non_manifold_faces;
    misoriented_faces += other.misoriented_faces;
  }
};

/// Renumbers a freshly uploaded mesh for locality: vertices along a Hilbert curve, tetrahedra by lowest vertex.
/// Requires points and tet2vertex in the caller's order; sets vertex2original and permutes tet2original.
template <class Backend>
void sort_mesh(const Backend& backend, WorkMesh<Backend>& mesh);

/// Computes tet2tet. A face that is non-manifold or misoriented is left as boundary and counted.
template <class Backend>
AdjacencyReport build_adjacency(const Backend& backend, WorkMesh<Backend>& mesh);

/// Counts the faces that seem to have the same three vertices as another face, as flips create them in a mesh that
/// overlaps itself. A result of 0 is exact; any other may be due to a hash collision and has to be verified. Requires
/// tet2tet.
template <class Backend>
Size count_duplicate_faces(const Backend& backend, WorkMesh<Backend>& mesh);

/// The corners at each vertex: items are 4 * tet + local vertex.
template <class Backend>
void build_vertex2tet(const Backend& backend, WorkMesh<Backend>& mesh, Csr<Backend>& vertex2tet);

/// Locks the faces between tetrahedra of different tags. `tags` holds one tag per tetrahedron of the caller.
template <class Backend>
void lock_interfaces(const Backend& backend, WorkMesh<Backend>& mesh, Span<const int> tags);

/// Removes free slots and drops tet2tet. Returns the previous slot of each tetrahedron.
template <class Backend>
typename Backend::template Buffer<Index> compact_slots(const Backend& backend, WorkMesh<Backend>& mesh);

}  // namespace tetune

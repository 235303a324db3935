// SPDX-License-Identifier: Apache-2.0
// Included once per backend, by a file that defines Instance.
#include "mesh/adjacency.inl"
#include "mesh/duplicate_faces.inl"
#include "mesh/sort_mesh.inl"

namespace tetune {
template void sort_mesh(const Instance&, WorkMesh<Instance>&);
template AdjacencyReport build_adjacency(const Instance&, WorkMesh<Instance>&);
template Size count_duplicate_faces(const Instance&, WorkMesh<Instance>&);
template void build_vertex2tet(const Instance&, WorkMesh<Instance>&, Csr<Instance>&);
template void lock_interfaces(const Instance&, WorkMesh<Instance>&, Span<const int>);
template Instance::Buffer<Index> compact_slots(const Instance&, WorkMesh<Instance>&);
}  // namespace tetune

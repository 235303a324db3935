// SPDX-License-Identifier: Apache-2.0
// Included once for each backend, by a file that says which: Instance.
#include "core/connect.inl"

namespace tetune {
template void sort_mesh(const Instance&, WorkMesh<Instance>&);
template AdjacencyReport build_adjacency(const Instance&, WorkMesh<Instance>&);
template Size count_doubled_faces(const Instance&, WorkMesh<Instance>&);
template void build_vertex2tet(const Instance&, WorkMesh<Instance>&, Rows<Instance>&);
template void lock_interfaces(const Instance&, WorkMesh<Instance>&, Span<const int>);
template Instance::Buffer<Index> compact_slots(const Instance&, WorkMesh<Instance>&);
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "core/connect.inl"
#include "par/cuda.cuh"

namespace tetune {
template void sort_mesh(const par::Cuda&, WorkMesh<par::Cuda>&);
template AdjacencyReport build_adjacency(const par::Cuda&, WorkMesh<par::Cuda>&);
template void build_vertex2tet(const par::Cuda&, WorkMesh<par::Cuda>&, Rows<par::Cuda>&);
template void lock_interfaces(const par::Cuda&, WorkMesh<par::Cuda>&, Span<const int>);
template par::Cuda::Buffer<Index> compact_slots(const par::Cuda&, WorkMesh<par::Cuda>&);
}  // namespace tetune

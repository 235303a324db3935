// SPDX-License-Identifier: Apache-2.0
#include "core/connect.inl"
#include "par/cpu.hpp"

namespace tetune {
template void sort_mesh(const par::Cpu&, WorkMesh<par::Cpu>&);
template AdjacencyReport build_adjacency(const par::Cpu&, WorkMesh<par::Cpu>&);
template void build_vertex2tet(const par::Cpu&, WorkMesh<par::Cpu>&, Rows<par::Cpu>&);
template void lock_interfaces(const par::Cpu&, WorkMesh<par::Cpu>&, Span<const int>);
template par::Cpu::Buffer<Index> compact_slots(const par::Cpu&, WorkMesh<par::Cpu>&);
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "boundary/classify.inl"
#include "boundary/features.inl"
#include "par/cpu.hpp"

namespace tetune {
template void build_surface(const par::Cpu&, WorkMesh<par::Cpu>&, const ListedTriangles&, par::Cpu::Buffer<Listed>&,
                            Surface<par::Cpu>&);
template void classify_vertices(const par::Cpu&, WorkMesh<par::Cpu>&, const Surface<par::Cpu>&, Span<const Index>,
                                const ConstrainedEdges&, Span<const std::uint8_t>, bool, Span<Mobility>, Span<Vec3>);
template void build_reference(const par::Cpu&, WorkMesh<par::Cpu>&, const Surface<par::Cpu>&, Span<const Index>,
                              const ConstrainedEdges&, Span<const std::uint8_t>, double, Span<Mobility>,
                              ReferenceSurface<par::Cpu>&);
template Size hold_corners(const par::Cpu&, Span<const std::uint8_t>, Span<Mobility>);
}  // namespace tetune

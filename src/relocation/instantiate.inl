// SPDX-License-Identifier: Apache-2.0
// Included once per backend, by a file that defines Instance.
#include "relocation/coloring.inl"
#include "relocation/maximize_min_angle.inl"
#include "relocation/rings.inl"
#include "relocation/sweep.inl"

namespace tetune {

template SweepSum sweep<SweepRing<Instance>>(const Instance&, WorkMesh<Instance>&, const Criterion&, const RingsView&,
                                             const Coloring<Instance>&, VertexDofs<Instance>&, const NewtonStep&,
                                             SweepScope);
template SweepSum sweep<SweepRing<Instance>>(const Instance&, WorkMesh<Instance>&, const Criterion&, const RingsView&,
                                             const Coloring<Instance>&, VertexDofs<Instance>&, const GradientStep&,
                                             SweepScope);
template SweepSum sweep<RegularizedRing>(const Instance&, WorkMesh<Instance>&, const Criterion&, const RingsView&,
                                         const Coloring<Instance>&, VertexDofs<Instance>&, const NewtonStep&,
                                         SweepScope);
template Size maximize_min_angle(const Instance&, WorkMesh<Instance>&, const Criterion&, const RingsView&,
                                 const Coloring<Instance>&, VertexDofs<Instance>&, Span<const std::uint8_t>, double);
template void color_vertices(const Instance&, const RingsView&, Span<const VertexDof>, Coloring<Instance>&,
                             const SurfaceAdjacency&);
template void build_rings(const Instance&, WorkMesh<Instance>&, Rings<Instance>&);
template void build_rings_of(const Instance&, WorkMesh<Instance>&, Span<const Index>, Span<const std::uint8_t>,
                             Rings<Instance>&);
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "flips/boundary_flips.inl"
#include "flips/face_removals.inl"
#include "flips/flip_pass.inl"
#include "par/cpu.hpp"

namespace tetune {
template double refresh_energy(const par::Cpu&, WorkMesh<par::Cpu>&, FlipState<par::Cpu>&);
template void refresh_energy_of(const par::Cpu&, WorkMesh<par::Cpu>&, FlipState<par::Cpu>&, Span<const Index>);
template double sum_energy(const par::Cpu&, FlipState<par::Cpu>&);
template void activate_all(const par::Cpu&, WorkMesh<par::Cpu>&, FlipState<par::Cpu>&, double);
template double activate_drifted(const par::Cpu&, WorkMesh<par::Cpu>&, FlipState<par::Cpu>&);
template FlipReport flip_pass(const par::Cpu&, WorkMesh<par::Cpu>&, FlipState<par::Cpu>&, Span<std::uint8_t>);
template void activate_around(const par::Cpu&, WorkMesh<par::Cpu>&, FlipState<par::Cpu>&, Span<const std::uint8_t>);
template FlipReport boundary_flip_pass(const par::Cpu&, WorkMesh<par::Cpu>&, FlipState<par::Cpu>&,
                                       BoundaryTriangles<par::Cpu>&, Span<std::uint8_t>);
template FlipReport face_removal_pass(const par::Cpu&, WorkMesh<par::Cpu>&, FlipState<par::Cpu>&, Span<std::uint8_t>);

}  // namespace tetune

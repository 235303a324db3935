// SPDX-License-Identifier: Apache-2.0
// Included once for each backend, by a file that says which: Instance.
#include "flips/boundary_flips.inl"
#include "flips/face_removals.inl"
#include "flips/flip_pass.inl"

namespace tetune {
template double refresh_energy(const Instance&, WorkMesh<Instance>&, FlipState<Instance>&);
template void refresh_energy_of(const Instance&, WorkMesh<Instance>&, FlipState<Instance>&, Span<const Index>);
template double sum_energy(const Instance&, FlipState<Instance>&);
template void activate_all(const Instance&, WorkMesh<Instance>&, FlipState<Instance>&, double);
template double activate_drifted(const Instance&, WorkMesh<Instance>&, FlipState<Instance>&, double);
template FlipReport flip_pass(const Instance&, WorkMesh<Instance>&, FlipState<Instance>&, Span<std::uint8_t>);
template void activate_around(const Instance&, WorkMesh<Instance>&, FlipState<Instance>&, Span<const std::uint8_t>);
template FlipReport boundary_flip_pass(const Instance&, WorkMesh<Instance>&, FlipState<Instance>&,
                                       BoundaryTriangles<Instance>&, Span<std::uint8_t>);
template FlipReport face_removal_pass(const Instance&, WorkMesh<Instance>&, FlipState<Instance>&, Span<std::uint8_t>);
}  // namespace tetune

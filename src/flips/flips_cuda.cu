// SPDX-License-Identifier: Apache-2.0
#include "flips/boundary_flips.inl"
#include "flips/face_removals.inl"
#include "flips/flip_pass.inl"
#include "par/cuda.cuh"

namespace tetune {
template double refresh_energy(const par::Cuda&, WorkMesh<par::Cuda>&, FlipState<par::Cuda>&);
template void refresh_energy_of(const par::Cuda&, WorkMesh<par::Cuda>&, FlipState<par::Cuda>&, Span<const Index>);
template double sum_energy(const par::Cuda&, FlipState<par::Cuda>&);
template void activate_all(const par::Cuda&, WorkMesh<par::Cuda>&, FlipState<par::Cuda>&, double);
template double activate_drifted(const par::Cuda&, WorkMesh<par::Cuda>&, FlipState<par::Cuda>&);
template FlipReport flip_pass(const par::Cuda&, WorkMesh<par::Cuda>&, FlipState<par::Cuda>&, Span<std::uint8_t>);
template void activate_around(const par::Cuda&, WorkMesh<par::Cuda>&, FlipState<par::Cuda>&, Span<const std::uint8_t>);
template FlipReport boundary_flip_pass(const par::Cuda&, WorkMesh<par::Cuda>&, FlipState<par::Cuda>&,
                                       BoundaryTriangles<par::Cuda>&, Span<std::uint8_t>);
template FlipReport face_removal_pass(const par::Cuda&, WorkMesh<par::Cuda>&, FlipState<par::Cuda>&,
                                      Span<std::uint8_t>);

}  // namespace tetune

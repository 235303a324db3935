// SPDX-License-Identifier: Apache-2.0
#include "par/cuda.cuh"
#include "vertices/open_angles.inl"
#include "vertices/revise.inl"

namespace tetune {
template ReviseReport revise_vertices(const par::Cuda&, WorkMesh<par::Cuda>&, FlipState<par::Cuda>&,
                                      Mobilities<par::Cuda>&, Span<const Index>, Size, double);
template Size open_angles(const par::Cuda&, WorkMesh<par::Cuda>&, const RingsView&, const Coloring<par::Cuda>&,
                          Mobilities<par::Cuda>&, Span<const std::uint8_t>, double);

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "par/cpu.hpp"
#include "vertices/open_angles.inl"
#include "vertices/revise.inl"

namespace tetune {
template ReviseReport revise_vertices(const par::Cpu&, WorkMesh<par::Cpu>&, FlipState<par::Cpu>&, Mobilities<par::Cpu>&,
                                      Span<const Index>, Size, double);
template Size open_angles(const par::Cpu&, WorkMesh<par::Cpu>&, const RingsView&, const Coloring<par::Cpu>&,
                          Mobilities<par::Cpu>&, Span<const std::uint8_t>, double);

}  // namespace tetune

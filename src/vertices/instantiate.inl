// SPDX-License-Identifier: Apache-2.0
// Included once for each backend, by a file that says which: Instance.
#include "vertices/open_angles.inl"
#include "vertices/revise.inl"

namespace tetune {
template ReviseReport revise_vertices(const Instance&, WorkMesh<Instance>&, FlipState<Instance>&, Mobilities<Instance>&,
                                      Span<const Index>, Size, double);
template Size open_angles(const Instance&, WorkMesh<Instance>&, const RingsView&, const Coloring<Instance>&,
                          Mobilities<Instance>&, Span<const std::uint8_t>, double);
}  // namespace tetune

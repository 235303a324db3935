// SPDX-License-Identifier: Apache-2.0
// Included once for each backend, by a file that says which: Instance.
#include "boundary/classify.inl"
#include "boundary/features.inl"

namespace tetune {
template void build_surface(const Instance&, WorkMesh<Instance>&, const ListedTriangles&, Instance::Buffer<Listed>&,
                            Surface<Instance>&);
template void classify_vertices(const Instance&, WorkMesh<Instance>&, const Surface<Instance>&, Span<const Index>,
                                const ConstrainedEdges&, Span<const std::uint8_t>, bool, Span<Mobility>, Span<Vec3>);
template void build_reference(const Instance&, WorkMesh<Instance>&, const Surface<Instance>&, Span<const Index>,
                              const ConstrainedEdges&, Span<const std::uint8_t>, double, Span<Mobility>,
                              ReferenceSurface<Instance>&);
template Size hold_corners(const Instance&, Span<const std::uint8_t>, Span<Mobility>);
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "boundary/classify.inl"
#include "boundary/features.inl"
#include "par/cuda.cuh"

namespace tetune {
template void build_surface(const par::Cuda&, WorkMesh<par::Cuda>&, const ListedTriangles&,
                            par::Cuda::Buffer<Listed>&, Surface<par::Cuda>&);
template void classify_vertices(const par::Cuda&, WorkMesh<par::Cuda>&, const Surface<par::Cuda>&, Span<const Index>,
                                const ConstrainedEdges&, Span<const std::uint8_t>, bool, Span<Mobility>, Span<Vec3>);
template void build_reference(const par::Cuda&, WorkMesh<par::Cuda>&, const Surface<par::Cuda>&, Span<const Index>,
                              const ConstrainedEdges&, Span<const std::uint8_t>, double, Span<Mobility>,
                              ReferenceSurface<par::Cuda>&);
template Size hold_corners(const par::Cuda&, Span<const std::uint8_t>, Span<Mobility>);
}  // namespace tetune

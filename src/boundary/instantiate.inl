// SPDX-License-Identifier: Apache-2.0
// Included once for each backend, by a file that says which: Instance.
#include "boundary/boundary_triangles.inl"
#include "boundary/classify.inl"
#include "boundary/find_dofs.inl"
#include "boundary/sliding/features.inl"
#include "boundary/sliding/slide_surface.inl"
#include "boundary/surface.inl"

namespace tetune {
template void build_surface(const Instance&, WorkMesh<Instance>&, const ListedTriangles&, Instance::Buffer<Listed>&,
                            Surface<Instance>&);
template void build_boundary(const Instance&, const Surface<Instance>&, const ListedTriangles&,
                             Span<const std::uint8_t>, BoundaryTriangles<Instance>&);
template void classify_vertices(const Instance&, WorkMesh<Instance>&, const Surface<Instance>&, Span<const Index>,
                                const ConstrainedEdges&, Span<const std::uint8_t>, bool, Span<VertexDof>, Span<Vec3>);
template void build_reference(const Instance&, WorkMesh<Instance>&, const Surface<Instance>&, Span<const Index>,
                              const ConstrainedEdges&, Span<const std::uint8_t>, double, Span<VertexDof>,
                              ReferenceSurface<Instance>&);
template Size fix_corners(const Instance&, Span<const std::uint8_t>, Span<VertexDof>);
template void find_dofs(const Instance&, WorkMesh<Instance>&, const DofInput<Instance>&, VertexDofs<Instance>&,
                        Report&);
template SlideSurface export_slide_surface(const ReferenceSurface<Instance>&, const std::vector<Point3>&,
                                           const std::vector<Index>&);
template std::vector<std::array<Index, 3>> export_surface_points(const Instance&, const VertexDofs<Instance>&,
                                                                 const std::vector<Index>&);
}  // namespace tetune

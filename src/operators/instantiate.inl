// SPDX-License-Identifier: Apache-2.0
// Included once for each backend, by a file that defines it as Instance.
#include "operators/engine/active_set.inl"
#include "operators/flips/boundary_flip.inl"
#include "operators/flips/face_removal.inl"
#include "operators/flips/flip_pass.inl"
#include "operators/stars/move_edited_surface.inl"
#include "operators/stars/retriangulate.inl"

namespace tetune {
template void activate_all(const Instance&, WorkMesh<Instance>&, const Criterion&, FlipState<Instance>&, double);
template double activate_drifted(const Instance&, WorkMesh<Instance>&, const Criterion&, FlipState<Instance>&, double);
template void activate_around(const Instance&, WorkMesh<Instance>&, FlipState<Instance>&, Span<const std::uint8_t>);
template void activate_marked(const Instance&, const Criterion&, FlipState<Instance>&);
template PassResult flip_pass(const Instance&, WorkMesh<Instance>&, const Criterion&, FlipState<Instance>&,
                              Span<std::uint8_t>);
template PassResult boundary_flip_pass(const Instance&, WorkMesh<Instance>&, const Criterion&, FlipState<Instance>&,
                                       BoundaryTriangles<Instance>&, const CheckedSurfaceView&, Span<std::uint8_t>);
template PassResult face_removal_pass(const Instance&, WorkMesh<Instance>&, const Criterion&, FlipState<Instance>&,
                                      Span<std::uint8_t>);
template RetriangulationReport retriangulate_worst(const Instance&, const EditableMesh<Instance>&, const Criterion&,
                                                   Span<const Index>, const RetriangulationLimits&);
template ResultOf<Instance, Sum<Size>> move_edited_surface(const Instance&, WorkMesh<Instance>&, VertexDofs<Instance>&,
                                                           BoundaryTriangles<Instance>&, const Coloring<Instance>&);
}  // namespace tetune

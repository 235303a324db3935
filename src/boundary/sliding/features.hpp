// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/classify.hpp"
#include "boundary/sliding/reference_surface.hpp"

namespace tetune {

/// Makes the surface the reference surface, finds its features, and decides where each vertex may go:
///   free     not on the surface and on no constrained edge
///   surface  on the surface, on no feature edge
///   curve    between exactly two feature edges, where the line turns by at most the feature angle
///   fixed    ends and junctions of feature lines, their sharper turns, points at which sheets of the surface touch,
///   and
///            where `frozen` is kFrozen
/// Feature edges are those where the surface turns by more than `feature_angle` degrees (180: none), borders between
/// tags, edges not on two triangles, and the constrained edges.
template <class Backend>
void build_reference(const Backend& backend, WorkMesh<Backend>& mesh, const Surface<Backend>& surface,
                     Span<const Index> edges, const ConstrainedEdges& constrained, Span<const std::uint8_t> frozen,
                     double feature_angle, Span<VertexDof> dof, ReferenceSurface<Backend>& reference);

}  // namespace tetune

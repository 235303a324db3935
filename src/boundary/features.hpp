// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/classify.hpp"
#include "surface/reference.hpp"

namespace tetune {

/// Makes the surface the reference that vertices slide on and finds its features, decides
/// where each vertex may go:
///   free     not on the surface and on no constrained edge
///   surface  on the surface, on no feature edge
///   curve    between exactly two feature edges, where the line turns by no more than the feature angle
///   fixed    ends and junctions of feature lines, their sharper turns, places where sheets of the surface touch, and
///            where `frozen` is kFrozen
/// Feature edges are those where the surface turns by more than `feature_angle` degrees (180: none), borders between
/// tags, edges not on two triangles, and the constrained edges.
template <class Backend>
void build_reference(const Backend& par, WorkMesh<Backend>& mesh, const Surface<Backend>& surface,
                     Span<const Index> edges, const ConstrainedEdges& constrained, Span<const std::uint8_t> frozen,
                     double feature_angle, Span<Mobility> kind, ReferenceSurface<Backend>& reference);

}  // namespace tetune

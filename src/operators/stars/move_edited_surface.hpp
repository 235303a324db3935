// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/boundary_triangles.hpp"
#include "boundary/vertex_dofs.hpp"
#include "relocation/color_groups.hpp"

namespace tetune {

/// Moves vertices of the edited surface (DeviationBound) to where they are in the mesh, if they have drifted by more
/// than half of what they may and operations have changed the triangles at them. Like such an operation, a move adds
/// the distance between the edited surface before and after to the deviation of the triangles; it is not made where
/// that is too large. Moves only active vertices of VertexDof::surface, which have rings and colors: others may have
/// the color of a neighbor. Requires a bound on the deviation, and VertexDofs::checked with an edited surface. Returns
/// the pending number of vertices that moved.
template <class Backend>
ResultOf<Backend, Sum<Size>> move_edited_surface(const Backend& backend, WorkMesh<Backend>& mesh,
                                                 VertexDofs<Backend>& dofs, BoundaryTriangles<Backend>& boundary,
                                                 const Coloring<Backend>& coloring);

}  // namespace tetune

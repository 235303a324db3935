// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/stars/retriangulate.hpp"
#include "relocation/color_groups.hpp"

namespace tetune {

/// Moves vertices of the edited surface (DeviationBound) to where they are in the mesh, if they have drifted by more
/// than half of what they may and operations have changed the triangles at them. Like such an operation, a move adds
/// the distance between the edited surface before and after to the deviation of the triangles; it is not made where
/// that is too large. Of vertices of VertexDof::surface with a color; requires a bound on the deviation. Returns the
/// pending number of vertices that moved.
template <class Backend>
ResultOf<Backend, Sum<Size>> move_edited_surface(const Backend& backend, const EditableMesh<Backend>& editable,
                                                 const Coloring<Backend>& coloring);

}  // namespace tetune

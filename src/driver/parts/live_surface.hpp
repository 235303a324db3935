// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "boundary/sliding/slide_surface.hpp"
#include "tetune/move.hpp"

/// The surface that the vertices of a live mesh slide on, from call to call.
namespace tetune {

/// Cuts a triangle off the surface if all of its vertices are prescribed and the target of one is not its initial
/// position. Vertices that move leave the surface. `moves`: 1 per vertex that is not at its target.
void leave_surface(SlideSurface& surface, const VertexTargets& target, const std::vector<std::uint8_t>& moves);

/// Makes the surface that of a result, `vertex2original` as of Report: all vertices of the surface are in it.
void renumber_surface(SlideSurface& surface, const std::vector<Index>& vertex2original,
                      const std::vector<Point3>& points);

}  // namespace tetune

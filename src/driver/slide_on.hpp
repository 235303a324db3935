// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "surface/slide_surface.hpp"
#include "tetune/optimize.hpp"

namespace tetune {

/// What optimize() lets the vertices of a mesh slide on: its surface, and where they may go on it. Throws as optimize()
/// does.
SlideSurface find_slide_surface(const TetMesh& mesh, const Options& options);

/// optimize() with Boundary::slide on a surface that need not be the mesh's own. Vertices whose site is not on it
/// stay. `surface.site` is brought up to date; its entries are those of the vertices before the call.
Report optimize(TetMesh& mesh, const Options& options, const Context& context, SlideSurface& surface);

}  // namespace tetune

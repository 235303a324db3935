// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/sliding/slide_surface.hpp"
#include "tetune/optimize.hpp"

namespace tetune {

/// optimize() on one backend. `surface`: the surface to slide on, whose points of contact are updated; null: the
/// surface of the mesh.
template <class Backend>
Report optimize_on(const Backend& backend, TetMesh& mesh, const Options& options, const Context& context,
                   SlideSurface* surface = nullptr);

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "driver/working_set.hpp"
#include "surface/slide_surface.hpp"
#include "tetune/optimize.hpp"

namespace tetune {

/// optimize() on one backend: take the mesh in, alternate flips and sweeps, give it back. `surface`: what to slide on,
/// brought up to date; null: the surface of the mesh.
template <class Backend>
Report optimize_on(const Backend& par, TetMesh& mesh, const Options& options, const Context& context,
                   SlideSurface* surface = nullptr);

}  // namespace tetune

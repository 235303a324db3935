// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "surface/slide_surface.hpp"
#include "tetune/optimize.hpp"

namespace tetune {

/// optimize() on the first NVIDIA GPU; `surface` as of optimize_on(). Throws DeviceError where there is none, or in a
/// build without CUDA.
Report optimize_on_cuda(TetMesh& mesh, const Options& options, const Context& context, SlideSurface* surface);

}  // namespace tetune

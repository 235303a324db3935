// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tetune/optimize.hpp"

namespace tetune {

/// optimize() on the first NVIDIA GPU. Throws DeviceError where there is none, or in a build without CUDA.
Report optimize_on_cuda(TetMesh& mesh, const Options& options, const Context& context);

}  // namespace tetune

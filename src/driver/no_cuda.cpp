// SPDX-License-Identifier: Apache-2.0
// Replaces driver_cuda.cu in a build without nvcc.
#include "driver/devices.hpp"
#include "tetune/error.hpp"

namespace tetune {

std::string why_not_on_cuda(std::size_t) {
  return "this build of tetune has no CUDA backend. Build with the `cuda` preset where nvcc is installed, or use the "
         "CPU (device=cpu).";
}

Report optimize_on_cuda(TetMesh&, const Options&, const Context&, SlideSurface*, MoveJob*) {
  throw DeviceError(why_not_on_cuda(0));
}

}  // namespace tetune

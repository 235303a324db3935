// SPDX-License-Identifier: Apache-2.0
// Stands in for driver_cuda.cu in a build without nvcc.
#include "driver/devices.hpp"
#include "tetune/error.hpp"

namespace tetune {

Report optimize_on_cuda(TetMesh&, const Options&, const Context&, SlideSurface*) {
  throw DeviceError(
      "this build of tetune has no CUDA backend. Build with the `cuda` preset where nvcc is installed, or use the CPU "
      "(--device cpu).");
}

}  // namespace tetune

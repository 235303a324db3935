// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "surface/slide_surface.hpp"
#include "tetune/optimize.hpp"

/// Where an optimisation runs. Nothing but driver_cuda.cu asks the system.
namespace tetune {

/// Device::automatic takes the CPU for meshes below this. To be on the safe side: from where on a GPU is faster has not
/// been measured.
inline constexpr std::size_t kAutoTets = 1000000;

/// What the CUDA runtime says of the system.
struct CudaSystem {
  int driver = 0;     ///< newest CUDA version that the driver knows, as 1000 major + 10 minor; 0: no driver
  int runtime = 0;    ///< the same of this build
  std::string error;  ///< empty: none
  int devices = 0;
};
/// Why it has no GPU to use; empty where it has.
std::string why_no_gpu(const CudaSystem& system);

/// What the runtime says of a GPU.
struct Gpu {
  std::string name;
  int major = 0, minor = 0;     ///< compute capability
  std::size_t free_memory = 0;  ///< bytes
  std::size_t total_memory = 0;
  std::size_t resident_threads = 0;  ///< most at once
};
/// Why it cannot be used for a run with so many bytes of buffers; empty where it can.
std::string why_unusable(const Gpu& gpu, std::size_t memory);

/// Why optimize_on_cuda() would refuse at once: no GPU, or none for this mesh. Empty where it would not.
std::string why_not_on_cuda(const TetMesh& mesh, const Options& options);

/// optimize() on the calling thread's current NVIDIA GPU; `surface` as of optimize_on(). Throws DeviceError.
Report optimize_on_cuda(TetMesh& mesh, const Options& options, const Context& context, SlideSurface* surface);

/// Of Device::automatic.
struct DeviceChoice {
  Device device;
  std::string reason;
};
DeviceChoice choose_device(const TetMesh& mesh, const Options& options);

}  // namespace tetune

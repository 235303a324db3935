// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "boundary/sliding/slide_surface.hpp"
#include "tetune/optimize.hpp"

/// The choice of the device, and optimize() on it. Only driver_cuda.cu queries the system, so that the rest is tested
/// without a GPU.
namespace tetune {

struct MoveJob;

/// Device::automatic takes the CPU for meshes of fewer tetrahedra: a process needs 0.3 s for its first use of a GPU, as
/// long as 16 threads need for 450 thousand tetrahedra (docs/benchmarks/gpu.md).
inline constexpr std::size_t kAutoTets = 500000;

/// The properties of the system that the CUDA runtime reports.
struct CudaSystem {
  int driver = 0;     ///< newest CUDA version that the driver supports, as 1000 major + 10 minor; 0: no driver
  int runtime = 0;    ///< CUDA version of this build, in the same notation
  std::string error;  ///< empty: none
  int devices = 0;
};
/// Returns the reason why the system has no usable GPU; empty if it has one.
std::string why_no_gpu(const CudaSystem& system);

/// The properties of a GPU that the CUDA runtime reports.
struct Gpu {
  std::string name;
  int major = 0, minor = 0;     ///< compute capability
  std::size_t free_memory = 0;  ///< bytes
  std::size_t total_memory = 0;
  std::size_t resident_threads = 0;  ///< at most
};
/// Returns the reason why the GPU cannot run with `memory` bytes of buffers; empty if it can.
std::string why_unusable(const Gpu& gpu, std::size_t memory);

/// optimize() or, with a job, move() on one backend. `surface`: the surface to slide on, with the places of the
/// vertices, which are updated; null: the surface of the mesh.
template <class Backend>
Report optimize_on(const Backend& backend, TetMesh& mesh, const Options& options, const Context& context,
                   SlideSurface* surface = nullptr, MoveJob* job = nullptr);

/// Checks the options, and calls optimize_on() on the device that they choose.
Report run_on_device(TetMesh& mesh, const Options& options, const Context& context, SlideSurface* surface,
                     MoveJob* job);

/// The GPU memory of optimize() or, with a job, move(), in bytes.
std::size_t device_memory(const TetMesh& mesh, const Options& options, const MoveJob* job);

/// Returns the reason why optimize_on_cuda() would refuse a mesh that needs `memory` bytes; empty if it would not.
std::string why_not_on_cuda(std::size_t memory);

/// optimize_on() on the calling thread's current NVIDIA GPU. Throws DeviceError.
Report optimize_on_cuda(TetMesh& mesh, const Options& options, const Context& context, SlideSurface* surface,
                        MoveJob* job);

/// The device that Device::automatic stands for.
struct DeviceChoice {
  Device device;
  std::string reason;
};
DeviceChoice choose_device(const TetMesh& mesh, const Options& options, const MoveJob* job = nullptr);

}  // namespace tetune

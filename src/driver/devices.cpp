// SPDX-License-Identifier: Apache-2.0
#include "driver/devices.hpp"

#include "driver/move_job.hpp"

namespace tetune {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;

std::string version(int number) { return std::to_string(number / 1000) + "." + std::to_string(number % 1000 / 10); }

/// Local memory per thread in bytes: the largest need of a kernel (docs/benchmarks/gpu-memory.md). The
/// CUDA driver reserves it for each thread that can be resident.
constexpr std::size_t kLocalMemory = 11264;
/// Reserve for the CUDA driver, which holds for example the code of the kernels.
constexpr std::size_t kDriverReserve = 128 * kMiB;

}  // namespace

std::string why_no_gpu(const CudaSystem& system) {
  if (system.driver == 0) {
    return "no usable GPU for CUDA: there is no NVIDIA driver. Install one (`nvidia-smi` then lists the GPU), or use "
           "the CPU (device=cpu).";
  }
  // A driver runs every program that was built for its major version.
  if (system.driver / 1000 < system.runtime / 1000) {
    return "no usable GPU for CUDA: the driver is too old. It runs CUDA " + version(system.driver) +
           ", and tetune was built with CUDA " + version(system.runtime) +
           ". Install a newer driver, or use the CPU (device=cpu).";
  }
  if (system.error.empty() && system.devices > 0) return "";
  return "no usable GPU for CUDA: " + (system.error.empty() ? "none found" : system.error) +
         ". Check `nvidia-smi` and CUDA_VISIBLE_DEVICES, or use the CPU (device=cpu).";
}

std::string why_unusable(const Gpu& gpu, std::size_t memory) {
  if (gpu.major * 10 + gpu.minor < 75) {
    return gpu.name + " has compute capability " + std::to_string(gpu.major) + "." + std::to_string(gpu.minor) +
           "; 7.5 or newer is needed. Use the CPU (device=cpu).";
  }
  const std::size_t needed = memory + gpu.resident_threads * kLocalMemory + kDriverReserve;
  if (needed <= gpu.free_memory) return "";
  return gpu.name + " has too little memory: about " + std::to_string((needed + kMiB - 1) / kMiB) +
         " MiB are needed, and " + std::to_string(gpu.free_memory / kMiB) + " of its " +
         std::to_string(gpu.total_memory / kMiB) +
         " MiB are free. End other programs that use it, choose less work (effort=fast), or use the CPU (device=cpu).";
}

std::size_t device_memory(const TetMesh& mesh, const Options& options, const MoveJob* job) {
  return memory_needed_on_device(mesh, options) + (job == nullptr ? 0 : motion_memory(mesh, options));
}

DeviceChoice choose_device(const TetMesh& mesh, const Options& options, const MoveJob* job) {
  if (mesh.tets.size() < kAutoTets) {
    return {Device::cpu, "below " + std::to_string(kAutoTets) + " tetrahedra"};
  }
  const std::string why_not = why_not_on_cuda(device_memory(mesh, options, job));
  if (!why_not.empty()) return {Device::cpu, why_not};
  return {Device::cuda, std::to_string(kAutoTets) + " tetrahedra or more, and a GPU with enough memory"};
}

}  // namespace tetune

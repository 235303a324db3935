// SPDX-License-Identifier: Apache-2.0
#include "driver/alternate.inl"
#include "driver/devices.hpp"
#include "par/cuda.cuh"

namespace tetune {
namespace {

CudaSystem cuda_system() {
  CudaSystem system;
  cudaDriverGetVersion(&system.driver);
  cudaRuntimeGetVersion(&system.runtime);
  const cudaError_t status = cudaGetDeviceCount(&system.devices);
  if (status != cudaSuccess) system.error = cudaGetErrorString(status);
  return system;
}

Gpu current_gpu() {
  int device = 0;
  par::check_cuda(cudaGetDevice(&device), "device query");
  cudaDeviceProp properties{};
  par::check_cuda(cudaGetDeviceProperties(&properties, device), "device query");
  Gpu gpu{properties.name, properties.major, properties.minor};
  gpu.resident_threads = static_cast<std::size_t>(properties.multiProcessorCount) *
                         static_cast<std::size_t>(properties.maxThreadsPerMultiProcessor);
  par::check_cuda(cudaMemGetInfo(&gpu.free_memory, &gpu.total_memory), "memory query");
  return gpu;
}

}  // namespace

template Report optimize_on(const par::Cuda&, TetMesh&, const Options&, const Context&, SlideSurface*);

std::string why_not_on_cuda(const TetMesh& mesh, const Options& options) {
  std::string why = why_no_gpu(cuda_system());
  cudaGetLastError();  // told here, and what the caller left unread is not ours
  if (!why.empty()) return why;
  try {
    return why_unusable(current_gpu(), memory_needed_on_device(mesh, options));
  } catch (const DeviceError& e) {
    return e.what();
  }
}

Report optimize_on_cuda(TetMesh& mesh, const Options& options, const Context& context, SlideSurface* surface) {
  if (const std::string why = why_not_on_cuda(mesh, options); !why.empty()) throw DeviceError(why);
  std::string name = current_gpu().name;  // before the mesh changes: nothing may fail after that
  const par::Cuda cuda(memory_needed_on_device(mesh, options), context.stop);
  Report report = optimize_on(cuda, mesh, options, context, surface);
  report.device.swap(name);
  return report;
}

}  // namespace tetune

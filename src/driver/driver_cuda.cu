// SPDX-License-Identifier: Apache-2.0
#include "backend/cuda.cuh"
#include "driver/devices.hpp"
#include "driver/optimize_on.inl"

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
  backend::check_cuda(cudaGetDevice(&device), "device query");
  cudaDeviceProp properties{};
  backend::check_cuda(cudaGetDeviceProperties(&properties, device), "device query");
  Gpu gpu{properties.name, properties.major, properties.minor};
  gpu.resident_threads = static_cast<std::size_t>(properties.multiProcessorCount) *
                         static_cast<std::size_t>(properties.maxThreadsPerMultiProcessor);
  backend::check_cuda(cudaMemGetInfo(&gpu.free_memory, &gpu.total_memory), "memory query");
  return gpu;
}

}  // namespace

template Report optimize_on(const backend::Cuda&, TetMesh&, const Options&, const Context&, SlideSurface*, MoveJob*);

std::string why_not_on_cuda(std::size_t memory) {
  std::string why = why_no_gpu(cuda_system());
  cudaGetLastError();  // clears the error, which the returned text reports
  if (!why.empty()) return why;
  try {
    return why_unusable(current_gpu(), memory);
  } catch (const DeviceError& e) {
    return e.what();
  }
}

Report optimize_on_cuda(TetMesh& mesh, const Options& options, const Context& context, SlideSurface* surface,
                        MoveJob* job) {
  const std::size_t memory = device_memory(mesh, options, job);
  if (const std::string why = why_not_on_cuda(memory); !why.empty()) throw DeviceError(why);
  std::string name = current_gpu().name;  // allocated before the mesh changes: nothing may fail afterwards
  const backend::Cuda cuda(memory, context.stop);
  Report report = optimize_on(cuda, mesh, options, context, surface, job);
  report.device.swap(name);
  return report;
}

}  // namespace tetune

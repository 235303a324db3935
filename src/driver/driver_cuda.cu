// SPDX-License-Identifier: Apache-2.0
#include "driver/alternate.inl"
#include "driver/devices.hpp"
#include "par/cuda.cuh"

namespace tetune {

template Report optimize_on(const par::Cuda&, TetMesh&, const Options&, const Context&, SlideSurface*);

Report optimize_on_cuda(TetMesh& mesh, const Options& options, const Context& context, SlideSurface* surface) {
  cudaGetLastError();  // what the caller left unread is not ours
  int count = 0;
  const cudaError_t status = cudaGetDeviceCount(&count);
  if (status != cudaSuccess || count == 0) {
    cudaGetLastError();
    throw DeviceError(std::string("no usable NVIDIA GPU: ") +
                      (status != cudaSuccess ? cudaGetErrorString(status) : "none found") +
                      ". Check `nvidia-smi`, or use the CPU (--device cpu).");
  }
  int device = 0;
  par::check_cuda(cudaGetDevice(&device), "device query");
  cudaDeviceProp properties{};
  par::check_cuda(cudaGetDeviceProperties(&properties, device), "device query");
  if (properties.major * 10 + properties.minor < 75) {
    throw DeviceError(std::string(properties.name) + " has compute capability " + std::to_string(properties.major) +
                      "." + std::to_string(properties.minor) + "; 7.5 or newer is needed. Use the CPU (--device cpu).");
  }
  if (properties.memoryPoolsSupported == 0) {
    throw DeviceError(std::string(properties.name) +
                      " has no memory pools (cudaMallocAsync) under this driver; they are needed. Use the CPU "
                      "(--device cpu).");
  }
  std::string name = properties.name;  // before the mesh changes: nothing may fail after that
  Report report = optimize_on(par::Cuda(context.stop), mesh, options, context, surface);
  report.device.swap(name);
  return report;
}

}  // namespace tetune

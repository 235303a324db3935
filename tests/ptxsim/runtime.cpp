// SPDX-License-Identifier: Apache-2.0
// The functions of the CUDA runtime that the library and CUB call, on the simulated device. Kernels run when they are
// launched, so that nothing is left to wait for.
#include <cuda_runtime.h>
#include <sys/mman.h>

#include <algorithm>
#include <chrono>
#include <cstring>

#include "ptxsim/fat_binary.hpp"
#include "ptxsim/global_memory.hpp"
#include "ptxsim/problems.hpp"
#include "ptxsim/reports.hpp"
#include "ptxsim/settings.hpp"

namespace tetune::ptxsim {
namespace {

constexpr u32 kThreadsPerProcessor = 1024;
constexpr int kVersion = 13000;

/// Where device memory begins: low, so that addresses differ from those of the host.
u64 next_address = 0xc0000000;

cudaError_t latest_error = cudaSuccess;
cudaError_t fail(cudaError_t error) { return latest_error = error; }

u64 address_of(const void* memory) { return reinterpret_cast<u64>(memory); }

/// Null if there is none.
void* new_memory(u64 bytes) {
  constexpr u64 kPage = u64{1} << 21;
  void* const memory = mmap(reinterpret_cast<void*>(next_address), bytes, PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_FIXED_NOREPLACE, -1, 0);
  if (memory == MAP_FAILED) return nullptr;
  next_address += (bytes + kPage - 1) / kPage * kPage;
  return memory;
}

struct ConfiguredLaunch {
  dim3 grid, block;
  std::size_t shared_bytes = 0;
  void* stream = nullptr;
};
thread_local ConfiguredLaunch configured;

struct Event {
  std::chrono::steady_clock::time_point time;
};
Event* event_of(cudaEvent_t event) { return reinterpret_cast<Event*>(event); }

cudaError_t report_transfer(const void* place, std::size_t bytes, const char* what) {
  problems().report(Fault::transfer, place, [&] { return formatted("a copy of %zu bytes %s", bytes, what); });
  return fail(cudaErrorInvalidValue);
}

cudaError_t copy(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind) {
  if (bytes == 0) return cudaSuccess;
  GlobalMemory& memory = global_memory();
  const bool to_device = kind == cudaMemcpyHostToDevice || kind == cudaMemcpyDeviceToDevice;
  const bool from_device = kind == cudaMemcpyDeviceToHost || kind == cudaMemcpyDeviceToDevice;
  const auto is_in_place = [&](const void* at, bool on_device) {
    return on_device ? memory.is_in_buffer(address_of(at), bytes) : memory.find(address_of(at)) == nullptr;
  };
  if (!is_in_place(to, to_device)) return report_transfer(to, bytes, "is not to a buffer in use of its kind");
  if (!is_in_place(from, from_device)) return report_transfer(from, bytes, "is not from a buffer in use of its kind");
  std::memmove(to, from, bytes);
  write_transfer(to_device && from_device ? "copy" : to_device ? "upload" : "download", bytes);
  if (kind == cudaMemcpyDeviceToDevice) {
    memory.copy_written(address_of(to), address_of(from), bytes);
  } else if (to_device) {
    memory.mark_written(address_of(to), bytes);
  } else if (memory.count_unwritten(address_of(from), bytes) > 0) {
    return report_transfer(from, bytes, "to the host has bytes that were never written");
  }
  return cudaSuccess;
}

int processor_attribute(cudaDeviceAttr attribute) {
  switch (attribute) {
    case cudaDevAttrComputeCapabilityMajor:
      return static_cast<int>(settings().compute_capability / 10);
    case cudaDevAttrComputeCapabilityMinor:
      return static_cast<int>(settings().compute_capability % 10);
    case cudaDevAttrMultiProcessorCount:
      return static_cast<int>(settings().processors);
    case cudaDevAttrSingleToDoublePrecisionPerfRatio:
      return static_cast<int>(settings().double_ratio);
    case cudaDevAttrMaxSharedMemoryPerBlock:
      return 48 * 1024;
    case cudaDevAttrMaxSharedMemoryPerBlockOptin:
      return 64 * 1024;
    case cudaDevAttrReservedSharedMemoryPerBlock:
      return 0;
    case cudaDevAttrMaxGridDimX:
      return 2147483647;
    case cudaDevAttrWarpSize:
      return static_cast<int>(kLanes);
    case cudaDevAttrMaxThreadsPerBlock:
      return 1024;
    case cudaDevAttrMaxThreadsPerMultiProcessor:
      return static_cast<int>(kThreadsPerProcessor);
    default:
      fatal("the attribute " + std::to_string(attribute) + " of a device is not simulated");
  }
}

}  // namespace
}  // namespace tetune::ptxsim

using namespace tetune::ptxsim;

extern "C" {

// -- Called by the code that nvcc adds to each file --

void** __cudaRegisterFatBinary(void* wrapper) { return register_fat_binary(wrapper); }
void __cudaRegisterFatBinaryEnd(void**) {}
void __cudaUnregisterFatBinary(void**) {}
void __cudaRegisterFunction(void** binary, const char* host, char*, const char* name, int, uint3*, uint3*, dim3*, dim3*,
                            int*) {
  register_kernel(binary, host, name);
}
void __cudaRegisterVar(void**, char*, char*, const char*, int, std::size_t, int, int) {}
unsigned __cudaPushCallConfiguration(dim3 grid, dim3 block, std::size_t shared_bytes, CUstream_st* stream) {
  configured = {grid, block, shared_bytes, stream};
  return 0;
}
cudaError_t __cudaPopCallConfiguration(dim3* grid, dim3* block, std::size_t* shared_bytes, void* stream) {
  *grid = configured.grid;
  *block = configured.block;
  *shared_bytes = configured.shared_bytes;
  *static_cast<void**>(stream) = configured.stream;
  return cudaSuccess;
}
cudaError_t __cudaGetKernel(cudaKernel_t* kernel, const void* host) {
  *kernel = reinterpret_cast<cudaKernel_t>(const_cast<void*>(host));
  return cudaSuccess;
}

// -- Launches --

cudaError_t cudaLaunchKernel(const void* host, dim3 grid, dim3 block, void** arguments, std::size_t shared_bytes,
                             cudaStream_t) {
  const Function* const kernel = find_kernel(host);
  if (kernel == nullptr) return fail(cudaErrorInvalidDeviceFunction);
  run_kernel(*kernel, grid, block, arguments, shared_bytes);
  return cudaSuccess;
}
cudaError_t __cudaLaunchKernel(cudaKernel_t kernel, dim3 grid, dim3 block, void** arguments, std::size_t shared_bytes,
                               cudaStream_t stream) {
  return cudaLaunchKernel(reinterpret_cast<const void*>(kernel), grid, block, arguments, shared_bytes, stream);
}
cudaError_t cudaLaunchKernelExC(const cudaLaunchConfig_t* launch, const void* host, void** arguments) {
  return cudaLaunchKernel(host, launch->gridDim, launch->blockDim, arguments, launch->dynamicSmemBytes, launch->stream);
}
cudaError_t cudaFuncGetAttributes(cudaFuncAttributes* attributes, const void* host) {
  const Function* const kernel = find_kernel(host);
  *attributes = {};
  if (kernel == nullptr) return fail(cudaErrorInvalidDeviceFunction);
  attributes->ptxVersion = attributes->binaryVersion = static_cast<int>(kernel->module->architecture);
  attributes->maxThreadsPerBlock = kernel->max_threads != 0 ? static_cast<int>(kernel->max_threads) : 1024;
  attributes->numRegs = 64;
  attributes->sharedSizeBytes = kernel->shared_bytes;
  attributes->localSizeBytes = kernel->frame_bytes;
  return cudaSuccess;
}
cudaError_t cudaFuncSetAttribute(const void*, cudaFuncAttribute, int) { return cudaSuccess; }
cudaError_t cudaOccupancyMaxActiveBlocksPerMultiprocessorWithFlags(int* blocks, const void*, int threads, std::size_t,
                                                                   unsigned) {
  *blocks = std::clamp(static_cast<int>(kThreadsPerProcessor) / std::max(threads, 1), 1, 16);
  return cudaSuccess;
}
cudaError_t cudaDeviceSynchronize() { return cudaSuccess; }
cudaError_t cudaStreamSynchronize(cudaStream_t) {
  write_transfer("wait", 0);
  return cudaSuccess;
}

// -- Memory --

cudaError_t cudaMalloc(void** memory, std::size_t bytes) {
  *memory = new_memory(std::max<u64>(bytes, 1));
  if (*memory == nullptr) return fail(cudaErrorMemoryAllocation);
  global_memory().add(address_of(*memory), std::max<u64>(bytes, 1));
  return cudaSuccess;
}
cudaError_t cudaFree(void* memory) {
  if (memory == nullptr) return cudaSuccess;
  GlobalMemory::Region* const region = global_memory().find(address_of(memory));
  if (region == nullptr || region->base != address_of(memory)) return fail(cudaErrorInvalidValue);
  munmap(memory, region->bytes);
  global_memory().remove(address_of(memory));
  return cudaSuccess;
}
/// Memory of the host that the device can access, too.
cudaError_t cudaMallocHost(void** memory, std::size_t bytes) { return cudaMalloc(memory, bytes); }
cudaError_t cudaFreeHost(void* memory) { return cudaFree(memory); }
cudaError_t cudaMemcpy(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind) {
  return copy(to, from, bytes, kind);
}
cudaError_t cudaMemcpyAsync(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind, cudaStream_t) {
  return copy(to, from, bytes, kind);
}
cudaError_t cudaMemset(void* memory, int value, std::size_t bytes) {
  if (!global_memory().is_in_buffer(address_of(memory), bytes)) {
    return report_transfer(memory, bytes, "sets bytes outside a buffer in use");
  }
  std::memset(memory, value, bytes);
  write_transfer("set", bytes);
  global_memory().mark_written(address_of(memory), bytes);
  return cudaSuccess;
}
cudaError_t cudaMemsetAsync(void* memory, int value, std::size_t bytes, cudaStream_t) {
  return cudaMemset(memory, value, bytes);
}
cudaError_t cudaMemGetInfo(std::size_t* free, std::size_t* total) {
  *free = *total = settings().memory_bytes;
  return cudaSuccess;
}

// -- Errors --

cudaError_t cudaGetLastError() { return std::exchange(latest_error, cudaSuccess); }
cudaError_t cudaPeekAtLastError() { return latest_error; }
const char* cudaGetErrorString(cudaError_t error) {
  return error == cudaSuccess ? "no error" : "an error of the simulated device";
}
const char* cudaGetErrorName(cudaError_t) { return "cudaErrorOfTheSimulator"; }

// -- The device --

cudaError_t cudaDriverGetVersion(int* version) { return *version = kVersion, cudaSuccess; }
cudaError_t cudaRuntimeGetVersion(int* version) { return *version = kVersion, cudaSuccess; }
cudaError_t cudaGetDeviceCount(int* count) { return *count = 1, cudaSuccess; }
cudaError_t cudaGetDevice(int* device) { return *device = 0, cudaSuccess; }
cudaError_t cudaSetDevice(int) { return cudaSuccess; }
cudaError_t cudaGetDeviceProperties(cudaDeviceProp* properties, int) {
  *properties = {};
  std::strcpy(properties->name, "PTX simulator");
  properties->major = processor_attribute(cudaDevAttrComputeCapabilityMajor);
  properties->minor = processor_attribute(cudaDevAttrComputeCapabilityMinor);
  properties->multiProcessorCount = processor_attribute(cudaDevAttrMultiProcessorCount);
  properties->maxThreadsPerMultiProcessor = static_cast<int>(kThreadsPerProcessor);
  properties->maxThreadsPerBlock = 1024;
  properties->totalGlobalMem = settings().memory_bytes;
  properties->sharedMemPerBlock = 48 * 1024;
  properties->warpSize = static_cast<int>(kLanes);
  return cudaSuccess;
}
cudaError_t cudaDeviceGetAttribute(int* value, cudaDeviceAttr attribute, int) {
  *value = processor_attribute(attribute);
  return cudaSuccess;
}

// -- Events: the time of the simulation --

cudaError_t cudaEventCreate(cudaEvent_t* event) {
  *event = reinterpret_cast<cudaEvent_t>(new Event);
  return cudaSuccess;
}
cudaError_t cudaEventDestroy(cudaEvent_t event) {
  delete event_of(event);
  return cudaSuccess;
}
cudaError_t cudaEventRecord(cudaEvent_t event, cudaStream_t) {
  event_of(event)->time = std::chrono::steady_clock::now();
  return cudaSuccess;
}
cudaError_t cudaEventSynchronize(cudaEvent_t) { return cudaSuccess; }
cudaError_t cudaEventElapsedTime(float* milliseconds, cudaEvent_t begin, cudaEvent_t end) {
  *milliseconds = std::chrono::duration<float, std::milli>(event_of(end)->time - event_of(begin)->time).count();
  return cudaSuccess;
}
}

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime.h>

#include <vector>

#include "ptxsim/types.hpp"

namespace tetune::ptxsim {

/// An array in the memory of the device, for tests.
template <class T>
class DeviceArray {
 public:
  explicit DeviceArray(std::size_t size) { cudaMalloc(reinterpret_cast<void**>(&data_), size * sizeof(T)); }
  explicit DeviceArray(const std::vector<T>& host) : DeviceArray(host.size()) {
    cudaMemcpy(data_, host.data(), host.size() * sizeof(T), cudaMemcpyHostToDevice);
  }
  ~DeviceArray() { cudaFree(data_); }
  DeviceArray(const DeviceArray&) = delete;
  DeviceArray& operator=(const DeviceArray&) = delete;

  T* data() const { return data_; }

 private:
  T* data_ = nullptr;
};

}  // namespace tetune::ptxsim

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/cuda.cuh"
#include "bench/gpu/device.hpp"

namespace tetune::gpu_bench {

/// Measures device time between two events on the default stream.
class Stopwatch {
 public:
  Stopwatch() {
    backend::check_cuda(cudaEventCreate(&start_), "event");
    backend::check_cuda(cudaEventCreate(&end_), "event");
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  ~Stopwatch() {
    cudaEventDestroy(start_);
    cudaEventDestroy(end_);
  }

  template <class F>
  double seconds(const F& work) const {
    backend::check_cuda(cudaEventRecord(start_), "event");
    work();
    backend::check_cuda(cudaEventRecord(end_), "event");
    backend::check_cuda(cudaEventSynchronize(end_), "event");
    float milliseconds = 0;
    backend::check_cuda(cudaEventElapsedTime(&milliseconds, start_, end_), "event");
    return 1e-3 * static_cast<double>(milliseconds);
  }

 private:
  cudaEvent_t start_{}, end_{};
};

}  // namespace tetune::gpu_bench

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/gpu/device.hpp"
#include "par/cuda.cuh"

namespace tetune::gpu_bench {

/// Device time between two events on the default stream.
class Stopwatch {
 public:
  Stopwatch() {
    par::check_cuda(cudaEventCreate(&start_), "event");
    par::check_cuda(cudaEventCreate(&end_), "event");
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  ~Stopwatch() {
    cudaEventDestroy(start_);
    cudaEventDestroy(end_);
  }

  template <class F>
  double seconds(const F& work) const {
    par::check_cuda(cudaEventRecord(start_), "event");
    work();
    par::check_cuda(cudaEventRecord(end_), "event");
    par::check_cuda(cudaEventSynchronize(end_), "event");
    float milliseconds = 0;
    par::check_cuda(cudaEventElapsedTime(&milliseconds, start_, end_), "event");
    return 1e-3 * static_cast<double>(milliseconds);
  }

 private:
  cudaEvent_t start_{}, end_{};
};

}  // namespace tetune::gpu_bench

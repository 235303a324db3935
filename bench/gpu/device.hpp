// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "tetune/mesh.hpp"

/// Measurements of the device itself, independent of the library.
namespace tetune::gpu_bench {

struct Card {
  std::string name;
  int major = 0, minor = 0, processors = 0;
  std::size_t memory = 0, free_memory = 0;
  int driver = 0, runtime = 0;  ///< CUDA version numbers: 13000 is 13.0
};
Card card();

/// Peak rates of the idle device: medians of several runs after a warm-up run.
struct Ceilings {
  double copy_bytes = 0;                      ///< bytes read and written per second by a copy within device memory
  double upload_bytes = 0;                    ///< bytes per second from pageable host memory
  double download_bytes = 0;                  ///< bytes per second to pageable host memory
  double single_flops = 0, double_flops = 0;  ///< operations per second; a multiply-add counts as two
  double launch_seconds = 0;                  ///< time between consecutive empty kernels
  double round_trip_seconds = 0;              ///< an empty kernel and a download of 8 bytes
};
Ceilings measure_ceilings();

/// Free device memory in bytes.
std::size_t free_bytes();

/// Times of single stages, measured by CUDA events in seconds: medians of `runs` runs after a warm-up run.
std::vector<std::pair<std::string, double>> measure_stages(const TetMesh& mesh, int runs);

double median(std::vector<double> values);

}  // namespace tetune::gpu_bench

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "tetune/mesh.hpp"

/// What the benchmark asks of the card itself, beside the library.
namespace tetune::gpu_bench {

struct Card {
  std::string name;
  int major = 0, minor = 0, processors = 0;
  std::size_t memory = 0, free_memory = 0;
  int driver = 0, runtime = 0;  ///< as CUDA numbers them: 13000 is 13.0
};
Card card();

/// What the card reaches with nothing else to do: medians of several runs after one to warm up.
struct Ceilings {
  double copy_bytes = 0;    ///< bytes a second, read and written, of a copy within its memory
  double upload_bytes = 0;  ///< bytes a second from the host, and back, from and to pageable memory
  double download_bytes = 0;
  double single_flops = 0, double_flops = 0;  ///< a multiply-add counts as two
  double launch_seconds = 0;                  ///< from one empty kernel to the next
  double round_trip_seconds = 0;              ///< an empty kernel and a download of 8 bytes
};
Ceilings measure_ceilings();

/// Of the card's memory, what nobody has now.
std::size_t free_bytes();

/// Seconds by CUDA events of parts of the work, each called on its own: medians of `runs` after one to warm up.
std::vector<std::pair<std::string, double>> measure_stages(const TetMesh& mesh, int runs);

double median(std::vector<double> values);

}  // namespace tetune::gpu_bench

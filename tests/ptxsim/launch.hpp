// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector_types.h>

#include <vector>

#include "ptxsim/program.hpp"

namespace tetune::ptxsim {

/// Counts of one launch. None depends on the order in which warps run.
struct LaunchCounts {
  u64 blocks = 0, threads = 0;
  u64 warp_instructions = 0, lane_instructions = 0;
  u64 warp_instructions_of[kKinds] = {}, lane_instructions_of[kKinds] = {};
  u64 longest_warp = 0;      ///< instructions
  u64 requests = 0;          ///< instructions that access global memory
  u64 sectors = 0;           ///< of 32 bytes, summed over requests
  u64 distinct_sectors = 0;  ///< each counted once
  u64 stack_bytes = 0;       ///< the most that a thread used
};

/// The data that all warps of a launch share.
struct Launch {
  const Function* kernel = nullptr;
  u32 number = 0;  ///< from 1
  /// A kernel of CUB, whose warps communicate through memory in ways that the search for races does not model.
  bool is_of_library = false;
  dim3 grid, block;
  std::vector<char> parameters;
  LaunchCounts counts;
  std::vector<u64>* profile = nullptr;  ///< warp instructions per instruction of the module; null if not profiled
};

/// Runs a kernel to its end. `arguments`: as of cudaLaunchKernel.
void run_kernel(const Function& kernel, dim3 grid, dim3 block, void** arguments, std::size_t dynamic_shared_bytes);

/// Launches so far.
u32 launch_count();

}  // namespace tetune::ptxsim

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "ptxsim/types.hpp"

namespace tetune::ptxsim {

/// The device that is simulated, and the checks. Each field is read from the environment variable that its comment
/// names.
struct Settings {
  u32 compute_capability = 75;      ///< PTXSIM_CC: 75 or 90, the PTX that is run
  u32 processors = 30;              ///< PTXSIM_SMS: multiprocessors of the device
  u32 double_ratio = 2;             ///< PTXSIM_DOUBLE_RATIO: of operations in single to those in double precision
  u64 memory_bytes = u64{6} << 30;  ///< PTXSIM_MEMORY_GIB: of the device
  bool races = false;               ///< PTXSIM_RACES=1: races are searched for; 16 bytes per byte of device memory
  bool unwritten = true;            ///< PTXSIM_UNWRITTEN=0: reads of unwritten memory are not searched for
  u64 seed = 0;             ///< PTXSIM_SEED: warps take turns in an order shuffled by it; 0: one after the other
  u32 resident_blocks = 1;  ///< PTXSIM_RESIDENT: blocks that are run at the same time
  std::string trace;        ///< PTXSIM_TRACE: a file for the counts of each launch
  std::string profile;      ///< PTXSIM_PROFILE: a file for the instructions run per line of the sources
};

/// The settings of this process.
Settings& settings();

}  // namespace tetune::ptxsim

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "ptxsim/types.hpp"

namespace tetune::ptxsim {

/// The errors of kernels and of calls of the runtime.
enum class Fault : u8 {
  misaligned,
  outside_memory,  ///< not an address of the device
  outside_buffer,  ///< beyond the end of a buffer, or of one that was released
  unwritten,       ///< a read of bytes that were never written
  outside_shared,
  outside_stack,
  outside_parameters,
  race,          ///< two threads of a launch access a byte, one of them writes, and nothing orders them
  unnamed_lane,  ///< a lane runs an operation of its warp whose mask lacks the lane
  absent_lane,   ///< a shuffle reads a lane that does not take part
  trap,
  assertion,
  endless_wait,  ///< all threads left wait for others
  transfer       ///< a copy beyond a buffer, or of unwritten bytes to the host
};

struct Problem {
  Fault fault;
  std::string text;
  u64 count;
};

/// The faults found so far: one entry per fault and place, the first one described.
class Problems {
 public:
  /// `place` identifies the instruction or call; `describe()` returns the text, and is called for the first fault
  /// there.
  template <class Describe>
  void report(Fault fault, const void* place, const Describe& describe) {
    const auto [entry, is_new] = index_.try_emplace({place, fault}, all_.size());
    if (is_new) add(fault, describe());
    ++all_[entry->second].count;
  }

  const std::vector<Problem>& all() const { return all_; }
  void clear();

 private:
  void add(Fault fault, std::string text);

  std::map<std::pair<const void*, Fault>, std::size_t> index_;
  std::vector<Problem> all_;
};

/// The problems of this process. Each is printed when it is found; a process that ends with any has exit code 99.
Problems& problems();

}  // namespace tetune::ptxsim

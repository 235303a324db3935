// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ptxsim/types.hpp"

namespace tetune::ptxsim {

enum class Access : u8 { read, write, atomic };

/// The time of an access: nothing orders threads within an epoch. An epoch of shared memory is the time between two
/// barriers of the block; one of global memory the time between two barriers of the block in one launch, as no barrier
/// orders the threads of different blocks.
constexpr u32 kBlockEpochs = 1U << 12U;
constexpr u32 global_epoch(u32 launch, u32 block_epoch) { return launch * kBlockEpochs + block_epoch % kBlockEpochs; }

/// The number of a thread of a launch, below 2^31 - 1.
constexpr u32 kThreadNumbers = 2048;  ///< per block
constexpr u32 thread_number(u32 block, u32 thread) { return block * kThreadNumbers + thread; }

/// A thread, the time, and whether its access is one that the hardware performs as a whole: atomic or volatile.
struct Accessor {
  u32 epoch;
  u32 thread;
  bool strong;
};

/// The latest accesses to a byte. Zero bytes are a byte that was never accessed, as epochs start at 1.
struct ByteHistory {
  u32 write_epoch, writer;
  u32 read_epoch, reader;
};

/// Two unordered accesses of different threads, of which one writes, are a race, unless both are strong.
struct Race {
  bool found = false;
  const char* text = "";  ///< such as "is read that another thread writes"
};

/// Enters an access to `count` bytes; returns the first race with an earlier access.
Race record(ByteHistory* bytes, u32 count, const Accessor& accessor, Access access);

}  // namespace tetune::ptxsim

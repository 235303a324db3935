// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ptxsim/types.hpp"

namespace tetune::ptxsim {

enum class Access : u8 { read, write, atomic };

/// A thread, the time within which nothing orders it with others (a launch, or what lies between two barriers), and
/// whether its access is one that the hardware performs as a whole: atomic or volatile.
struct Accessor {
  u32 epoch;
  u32 thread;  ///< below 2^31 - 1
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

/// Enters an access to `count` bytes; returns the first race with an earlier access of the same epoch.
Race record(ByteHistory* bytes, u32 count, const Accessor& accessor, Access access);

}  // namespace tetune::ptxsim

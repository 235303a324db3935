// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <string>

#include "tetune/error.hpp"

/// What tetune and the programs of its plugins agree on.
///
///   PROGRAM read FILE      answer: kAnswerVersion, error, warnings, mesh (when error is empty)
///   PROGRAM check FILE     answer: kAnswerVersion, error, no warnings: whether the library has the format of this name
///   PROGRAM write FILE     in: kStreamVersion, mesh; answer: kAnswerVersion, error, warnings
///
/// Both go through the file kPluginDescriptor, in memory, encoded as in mesh_stream.hpp; the answer replaces what came
/// in. The exit code is 0 whenever there is an answer.
namespace tetune {

inline constexpr int kPluginDescriptor = 3;
/// Exit code of the system's loader when a shared library is missing.
inline constexpr int kPluginNotLoaded = 127;

inline void write_all(int descriptor, const void* data, std::size_t bytes) {
  const char* at = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t done = ::write(descriptor, at, bytes);
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) throw FileError(std::string("no memory to hand a mesh over: ") + std::strerror(errno));
    at += done;
    bytes -= static_cast<std::size_t>(done);
  }
}

}  // namespace tetune

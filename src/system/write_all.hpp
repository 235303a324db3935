// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstddef>

namespace tetune {

/// Writes all bytes to an open descriptor, across interruptions by signals and partial writes. Returns false, with
/// errno set, on an error.
inline bool write_all(int descriptor, const void* data, std::size_t bytes) {
  const char* next = static_cast<const char*>(data);
  const char* const end = next + bytes;
  while (next != end) {
    const ssize_t written = ::write(descriptor, next, std::size_t(end - next));
    if (written >= 0) {
      next += written;
    } else if (errno != EINTR) {
      return false;
    }
  }
  return true;
}

}  // namespace tetune

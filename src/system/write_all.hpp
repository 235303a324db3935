// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>

namespace tetune {

/// Writes all bytes to an open descriptor, across interruptions by signals and partial writes. Returns false, with
/// errno set, on an error.
inline bool write_all(int descriptor, const void* data, std::size_t bytes) {
  constexpr std::ptrdiff_t kMaxPart = 1 << 30;  // Windows counts the bytes of a call in 32 bits, as Linux does
  const char* next = static_cast<const char*>(data);
  const char* const end = next + bytes;
  while (next != end) {
    const auto part = unsigned(std::min<std::ptrdiff_t>(end - next, kMaxPart));
    const auto written = ::write(descriptor, next, part);
    if (written >= 0) {
      next += written;
    } else if (errno != EINTR) {
      return false;
    }
  }
  return true;
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <system_error>

namespace tetune {

/// The path that a name stands for. On Windows names are UTF-8, which libstdc++ 12 writes but does not read.
inline std::filesystem::path path_of(const std::string& name) {
#ifdef _WIN32
  return std::u8string(name.begin(), name.end());
#else
  return name;
#endif
}

/// Whether there is a regular file of that name.
inline bool is_file(const std::string& name) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path_of(name), ignored);
}

}  // namespace tetune

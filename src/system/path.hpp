// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace tetune {

/// The path that a name stands for. On Windows names are UTF-8, which libstdc++ 12 writes but does not read.
inline std::filesystem::path path_of(const std::string& name) {
#ifdef _WIN32
  return std::u8string(name.begin(), name.end());
#else
  return name;
#endif
}

}  // namespace tetune

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

/// The ending of a file's name with its point, in lower case: ".inp" of MODEL.INP.
inline std::string ending_of(const std::string& file) {
  std::string ending = path_of(file).extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
  return ending;
}

/// The file with another ending, in capitals where that of `file` has capitals.
inline std::string with_ending(const std::string& file, std::string ending) {
  if (path_of(file).extension().string() != ending_of(file)) {
    for (char& c : ending) c = c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c;
  }
  return path_of(file).replace_extension(ending).string();
}

/// Whether there is a regular file of that name.
inline bool is_file(const std::string& name) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path_of(name), ignored);
}

}  // namespace tetune

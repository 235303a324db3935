// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace tetune {

/// Threads and a place for warnings, for readers and writers.
struct IoContext {
  int threads = 0;
  std::vector<std::string>* warnings = nullptr;
  void warn(const std::string& text) const {
    if (warnings != nullptr) warnings->push_back(text);
  }
};

}  // namespace tetune

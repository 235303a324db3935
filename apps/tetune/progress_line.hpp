// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/core.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>

#include "tetune/optimize.hpp"

namespace tetune::cli {

/// One line on a terminal that follows the work; nothing in a pipe or file.
class ProgressLine {
 public:
  explicit ProgressLine(bool wanted) : shown_(wanted && isatty(STDERR_FILENO) == 1) {}
  ~ProgressLine() { clear(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void say(const char* what) {
    if (!shown_) return;
    fmt::print(stderr, "\r\033[K{} ...", what);
    std::fflush(stderr);
  }
  void update(const Progress& p) {
    const auto now = std::chrono::steady_clock::now();
    if (!shown_ || now - last_ < std::chrono::milliseconds(50)) return;
    last_ = now;
    const double fall = p.energy_before > 0 ? 100 * (1 - p.energy / p.energy_before) : 0;
    fmt::print(stderr, "\r\033[K{:<6} after {:>3} sweeps   energy {:.6g}   down {:.2f} %", p.phase, p.iteration,
               p.energy, fall);
    std::fflush(stderr);
  }
  void clear() {
    if (!shown_) return;
    fmt::print(stderr, "\r\033[K");
    std::fflush(stderr);
  }

 private:
  bool shown_;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace tetune::cli

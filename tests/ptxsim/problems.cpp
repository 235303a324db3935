// SPDX-License-Identifier: Apache-2.0
#include "ptxsim/problems.hpp"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>

namespace tetune::ptxsim {
namespace {

constexpr int kExitCode = 99;

void end_with_exit_code() {
  if (problems().all().empty()) return;
  std::fprintf(stderr, "ptxsim: %zu kinds of problems\n", problems().all().size());
  std::fflush(nullptr);
  _exit(kExitCode);
}

}  // namespace

void Problems::add(Fault fault, std::string text) {
  std::fprintf(stderr, "ptxsim: PROBLEM %s\n", text.c_str());
  all_.push_back({fault, std::move(text), 0});
}

void Problems::clear() {
  index_.clear();
  all_.clear();
}

Problems& problems() {
  // Never destroyed, as functions registered with atexit() use it.
  static Problems* const instance = [] {
    std::atexit(end_with_exit_code);
    return new Problems;
  }();
  return *instance;
}

}  // namespace tetune::ptxsim

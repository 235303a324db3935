// SPDX-License-Identifier: Apache-2.0
#include "ptxsim/settings.hpp"

#include <cstdlib>

namespace tetune::ptxsim {
namespace {

u64 number(const char* variable, u64 otherwise) {
  const char* const text = std::getenv(variable);
  return text != nullptr && *text != '\0' ? std::strtoull(text, nullptr, 0) : otherwise;
}

std::string text(const char* variable) {
  const char* const value = std::getenv(variable);
  return value != nullptr ? value : "";
}

Settings from_environment() {
  Settings s;
  s.compute_capability = static_cast<u32>(number("PTXSIM_CC", s.compute_capability));
  s.processors = static_cast<u32>(number("PTXSIM_SMS", s.processors));
  s.double_ratio = static_cast<u32>(number("PTXSIM_DOUBLE_RATIO", s.double_ratio));
  s.memory_bytes = number("PTXSIM_MEMORY_GIB", s.memory_bytes >> 30) << 30;
  s.races = number("PTXSIM_RACES", 0) != 0;
  s.unwritten = number("PTXSIM_UNWRITTEN", 1) != 0;
  s.seed = number("PTXSIM_SEED", 0);
  s.resident_blocks = static_cast<u32>(number("PTXSIM_RESIDENT", s.resident_blocks));
  s.trace = text("PTXSIM_TRACE");
  s.profile = text("PTXSIM_PROFILE");
  return s;
}

}  // namespace

Settings& settings() {
  static Settings instance = from_environment();
  return instance;
}

}  // namespace tetune::ptxsim

// SPDX-License-Identifier: Apache-2.0
#include "ptxsim/types.hpp"

#include <cxxabi.h>

#include <cstdarg>
#include <cstdio>
#include <cstdlib>

namespace tetune::ptxsim {

void fatal(const std::string& message) {
  std::fprintf(stderr, "ptxsim: %s\n", message.c_str());
  std::abort();
}

std::string formatted(const char* format, ...) {
  char text[600];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

std::string demangled(const std::string& name) {
  int status = 0;
  char* const text = abi::__cxa_demangle(name.c_str(), nullptr, nullptr, &status);
  std::string result = status == 0 && text != nullptr ? text : name;
  std::free(text);
  return result;
}

}  // namespace tetune::ptxsim

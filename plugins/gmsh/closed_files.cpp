// SPDX-License-Identifier: GPL-2.0-or-later
#include "closed_files.hpp"

#include <dlfcn.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "tetune/error.hpp"

namespace {

/// The error number of the first failure; 0 without one.
int failure = 0;

}  // namespace

/// Replaces the function of the C library, also for Gmsh: the loader searches the program before its libraries.
extern "C" int fclose(std::FILE* file) {
  using Close = int (*)(std::FILE*);
  static const auto close = reinterpret_cast<Close>(::dlsym(RTLD_NEXT, "fclose"));
  const bool failed = std::ferror(file) != 0;
  errno = 0;
  const int result = close(file);
  // The number of an earlier error is lost; it is almost always a full disk.
  if ((failed || result != 0) && failure == 0) failure = errno != 0 ? errno : ENOSPC;
  return result;
}

namespace tetune::plugin {

void check_closed_files() {
  if (failure != 0) throw FileError(std::string("cannot write: ") + std::strerror(failure));
}

}  // namespace tetune::plugin

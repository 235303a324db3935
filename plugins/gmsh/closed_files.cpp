// SPDX-License-Identifier: GPL-2.0-or-later
#include "closed_files.hpp"

#include <dlfcn.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "tetune/error.hpp"

namespace {

/// Why the first of them failed; 0 where none did.
int failure = 0;

}  // namespace

/// In the place of the C library's, also for Gmsh: the program comes first where the system's loader looks for a name.
extern "C" int fclose(std::FILE* file) {
  using Close = int (*)(std::FILE*);
  static const auto close = reinterpret_cast<Close>(::dlsym(RTLD_NEXT, "fclose"));
  const bool failed = std::ferror(file) != 0;
  errno = 0;
  const int result = close(file);
  // What of an earlier error is left tells little, but it is a full disk in all but strange cases.
  if ((failed || result != 0) && failure == 0) failure = errno != 0 ? errno : ENOSPC;
  return result;
}

namespace tetune::plugin {

void check_closed_files() {
  if (failure != 0) throw FileError(std::string("cannot write: ") + std::strerror(failure));
}

}  // namespace tetune::plugin

// SPDX-License-Identifier: Apache-2.0
#include "system/child_process.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "tetune/error.hpp"

namespace tetune {

bool has_child_processes() { return true; }

std::string own_folder() {
  Dl_info info{};
  link_map* map = nullptr;
  std::string object = "/proc/self/exe";
  if (::dladdr1(reinterpret_cast<const void*>(&own_folder), &info, reinterpret_cast<void**>(&map), RTLD_DL_LINKMAP) !=
          0 &&
      map != nullptr && map->l_name != nullptr && map->l_name[0] == '/') {
    object = map->l_name;
  }
  std::error_code ignored;
  const std::filesystem::path folder = std::filesystem::canonical(object, ignored).parent_path();
  const std::filesystem::path above = folder.parent_path();
  return above.filename() == "glibc-hwcaps" ? above.parent_path() : folder;
}

MemoryFile::MemoryFile() : descriptor_(::memfd_create("tetune", MFD_CLOEXEC)) {
  if (descriptor_ < 0) throw FileError(std::string("cannot create a file in memory: ") + std::strerror(errno));
}

MemoryFile::~MemoryFile() { ::close(descriptor_); }

ExitStatus run_program(const std::string& program, const std::vector<std::string>& arguments, const MemoryFile& channel,
                       int child_descriptor) {
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    ::posix_spawn_file_actions_addopen(&files, standard, "/dev/null", O_RDWR, 0);
  }
  ::posix_spawn_file_actions_adddup2(&files, channel.descriptor(), child_descriptor);
  pid_t child = 0;
  const int error = ::posix_spawn(&child, program.c_str(), &files, nullptr, argv.data(), environ);
  ::posix_spawn_file_actions_destroy(&files);
  if (error != 0) throw FileError(program + ": cannot be started: " + std::strerror(error));
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) return {0, ::strsignal(WTERMSIG(status))};
  return {WEXITSTATUS(status), {}};
}

}  // namespace tetune

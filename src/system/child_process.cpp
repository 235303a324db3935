// SPDX-License-Identifier: Apache-2.0
#include "system/child_process.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

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
  if (descriptor_ >= 0 && descriptor_ <= STDERR_FILENO) {
    // Where standard streams are closed their numbers are free; in the child they belong to its standard streams.
    const int above = ::fcntl(descriptor_, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    ::close(std::exchange(descriptor_, above));
  }
  if (descriptor_ < 0) throw FileError(std::string("cannot create a file in memory: ") + std::strerror(errno));
}

void MemoryFile::clear() const {
  if (::ftruncate(descriptor_, 0) == 0 && ::lseek(descriptor_, 0, SEEK_SET) == 0) return;
  throw FileError(std::string("cannot use a file in memory: ") + std::strerror(errno));
}

MemoryFile::~MemoryFile() { ::close(descriptor_); }

namespace {

/// Starts a program with a descriptor as its standard input, nothing if that is negative. Throws FileError.
pid_t start(const std::string& program, const std::vector<std::string>& arguments, const MemoryFile& channel,
            int child_descriptor, int input) {
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (standard == STDIN_FILENO && input >= 0) continue;
    ::posix_spawn_file_actions_addopen(&files, standard, "/dev/null", O_RDWR, 0);
  }
  if (input >= 0) ::posix_spawn_file_actions_adddup2(&files, input, STDIN_FILENO);
  ::posix_spawn_file_actions_adddup2(&files, channel.descriptor(), child_descriptor);
  ::fcntl(channel.descriptor(), F_SETOWN, ::getpid());  // the child asks whether its parent is still this process
  pid_t child = 0;
  const int error = ::posix_spawn(&child, program.c_str(), &files, nullptr, argv.data(), environ);
  ::posix_spawn_file_actions_destroy(&files);
  if (error != 0) throw FileError(program + ": cannot be started: " + std::strerror(error));
  return child;
}

ExitStatus wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) return {0, ::strsignal(WTERMSIG(status))};
  return {WEXITSTATUS(status), {}};
}

/// Repeats a call that a signal interrupts.
template <class Call>
bool transfers_byte(const Call& call) {
  ssize_t done = 0;
  do {
    done = call();
  } while (done < 0 && errno == EINTR);
  return done == 1;
}

}  // namespace

ExitStatus run_program(const std::string& program, const std::vector<std::string>& arguments, const MemoryFile& channel,
                       int child_descriptor) {
  return wait_for(start(program, arguments, channel, child_descriptor, -1));
}

ChildProcess::ChildProcess(const std::string& program, const std::vector<std::string>& arguments,
                           const MemoryFile& channel, int child_descriptor)
    : owner_(::getpid()) {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    throw FileError(program + ": cannot be started: " + std::strerror(errno));
  }
  try {
    // Copies above the standard descriptors and the channel's, onto which the child's are copied.
    const int input = ::fcntl(ends[1], F_DUPFD_CLOEXEC, child_descriptor + 1);
    ::close(std::exchange(ends[1], input));
    if (input < 0) throw FileError(program + ": cannot be started: " + std::strerror(errno));
    child_ = start(program, arguments, channel, child_descriptor, input);
  } catch (...) {
    ::close(ends[0]);
    ::close(ends[1]);
    throw;
  }
  ::close(ends[1]);
  socket_ = ends[0];
}

ChildProcess::~ChildProcess() {
  if (owner_ == ::getpid() && child_ != 0) {
    ::shutdown(socket_, SHUT_RDWR);  // for all copies of the socket, those of forks too
    wait_for(child_);
  }
  ::close(socket_);
}

std::optional<ExitStatus> ChildProcess::request() {
  if (owner_ != ::getpid()) throw FileError("a program cannot be asked from a fork of the process that started it");
  char byte = 1;
  if (child_ != 0) {
    const bool answered = transfers_byte([&] { return ::send(socket_, &byte, 1, MSG_NOSIGNAL); }) &&
                          transfers_byte([&] { return ::recv(socket_, &byte, 1, 0); });
    if (answered) return {};
    status_ = wait_for(child_);
    child_ = 0;
  }
  return status_;
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tetune/export.hpp"

/// Child processes (child_process.cpp: Linux; child_process_none.cpp: systems without them): where programs of the
/// installation are, and how one runs with a file in memory as its channel, once or for many requests.
namespace tetune {

/// Whether this system's build can start programs; where it cannot, a MemoryFile throws FileError.
TETUNE_API bool has_child_processes();

/// The folder of the program or shared library that holds this code; of a library in a folder for some processors
/// (glibc-hwcaps), the folder of the one for all.
std::string own_folder();

/// A file without a name in memory, for handing data to a child process and back.
class MemoryFile {
 public:
  /// Throws FileError.
  MemoryFile();
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  int descriptor() const { return descriptor_; }
  /// Makes it empty. Throws FileError.
  void clear() const;

 private:
  int descriptor_;
};

/// How a child process ended.
struct ExitStatus {
  int code = 0;        ///< exit code, where it ended by itself
  std::string signal;  ///< name of the signal that ended it; empty otherwise
};

/// Runs a program to its end, with `channel` as its descriptor `child_descriptor` and nothing as its standard input and
/// outputs. Throws FileError where it cannot be started.
ExitStatus run_program(const std::string& program, const std::vector<std::string>& arguments, const MemoryFile& channel,
                       int child_descriptor);

/// A program that answers requests, one after another: each is a byte on its standard input, a socket, to which it
/// writes a byte back when it is done. It ends when the input does, which the destructor waits for.
class ChildProcess {
 public:
  /// Starts a program, with arguments as for run_program(). Throws FileError where it cannot be started.
  ChildProcess(const std::string& program, const std::vector<std::string>& arguments, const MemoryFile& channel,
               int child_descriptor);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  /// Returns when the program has answered, or how it ended instead. Throws FileError in another process than the one
  /// that started it: a fork.
  std::optional<ExitStatus> request();

 private:
  [[maybe_unused]] int owner_ = 0;  ///< process id
  [[maybe_unused]] int child_ = 0;  ///< process id; 0: it has ended
  [[maybe_unused]] int socket_ = -1;
  ExitStatus status_;
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "system/child_process.hpp"
#include "tetune/error.hpp"

namespace tetune {

bool has_child_processes() { return false; }

std::string own_folder() { return {}; }

MemoryFile::MemoryFile() : descriptor_(-1) { throw FileError("tetune starts no programs on this system"); }

MemoryFile::~MemoryFile() = default;

void MemoryFile::clear() const {}

ExitStatus run_program(const std::string& program, const std::vector<std::string>&, const MemoryFile&, int) {
  throw FileError(program + ": tetune starts no programs on this system");
}

ChildProcess::ChildProcess(const std::string& program, const std::vector<std::string>&, const MemoryFile&, int) {
  throw FileError(program + ": tetune starts no programs on this system");
}

ChildProcess::~ChildProcess() = default;

std::optional<ExitStatus> ChildProcess::request() { return status_; }

}  // namespace tetune

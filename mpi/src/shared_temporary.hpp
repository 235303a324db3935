// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "communicate.hpp"
#include "system/file.hpp"

namespace tetune::mpi {

/// A temporary file that all ranks write. Rank 0 chooses its name, which no other run has, and owns it: it deletes the
/// file at the end, unless replace() has moved it.
class SharedTemporary {
 public:
  SharedTemporary(MPI_Comm comm, const std::string& path) : comm_(comm) {
    collective_try(comm, [&] {
      if (rank_of(comm) == 0) name_ = file_.emplace(path).name();
    });
    const std::vector<char> name = gather_all(comm, std::vector<char>(name_.begin(), name_.end()), MPI_CHAR);
    name_.assign(name.begin(), name.end());
  }
  const std::string& name() const { return name_; }
  /// Moves the closed file to its path; a file that it replaces hands its permissions on. Throws FileError on all
  /// ranks.
  void replace() {
    collective_try(comm_, [this] {
      if (file_) file_->replace();
    });
  }

 private:
  MPI_Comm comm_;
  std::string name_;
  std::optional<TemporaryFile> file_;
};

}  // namespace tetune::mpi

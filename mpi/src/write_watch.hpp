// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mpi.h>
#include <petscsys.h>

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace tetune::mpi {

/// Ends all ranks where a file that they write together by HDF5 cannot be completed. HDF5 reports a full disk to the
/// rank that wrote, for which the others then wait, or to none. The temporary file is removed, and the exit code is
/// that of other errors of writing.
class WriteWatch {
 public:
  /// `path`: for messages. On rank 0 a thread watches the file.
  WriteWatch(MPI_Comm comm, std::string path, std::string temporary);
  ~WriteWatch();
  WriteWatch(const WriteWatch&) = delete;
  WriteWatch& operator=(const WriteWatch&) = delete;

  /// Ends the run unless the code is that of success.
  void check(PetscErrorCode code) const;

 private:
  void watch();
  bool is_nearly_full() const;
  void print() const;

  MPI_Comm comm_;
  std::string path_, temporary_;
  std::mutex mutex_;
  std::condition_variable ended_;
  bool has_ended_ = false;
  std::thread thread_;
};

}  // namespace tetune::mpi

// SPDX-License-Identifier: Apache-2.0
#include "write_watch.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

#include "communicate.hpp"
#include "exit_code.hpp"

namespace tetune::mpi {
namespace {

using SteadyClock = std::chrono::steady_clock;
namespace files = std::filesystem;

constexpr auto kPeriod = std::chrono::seconds(1);
/// On a disk that is nearly full, a file that has not changed for this time is not being written.
constexpr auto kStall = std::chrono::seconds(20);
/// A write that fails has taken the space but for less than this, in bytes.
constexpr std::uintmax_t kNearlyFull = std::uintmax_t(16) << 20;

}  // namespace

WriteWatch::WriteWatch(MPI_Comm comm, std::string path, std::string temporary)
    : comm_(comm), path_(std::move(path)), temporary_(std::move(temporary)) {
  if (rank_of(comm) == 0) thread_ = std::thread([this] { watch(); });
}

WriteWatch::~WriteWatch() {
  {
    const std::lock_guard lock(mutex_);
    has_ended_ = true;
  }
  ended_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void WriteWatch::check(PetscErrorCode code) const {
  if (code == 0) return;
  // One rank has the message: rank 0 if it can, else the one that removes the file; others give it the time.
  const bool is_first = rank_of(comm_) == 0;
  if (!is_first) std::this_thread::sleep_for(std::chrono::seconds(2));
  std::error_code error;
  if (!files::remove(temporary_, error) && !is_first) std::this_thread::sleep_for(std::chrono::seconds(5));
  print();
  MPI_Abort(comm_, cli::kNothingWritten);
}

void WriteWatch::watch() {
  std::unique_lock lock(mutex_);
  auto changed = SteadyClock::now();
  files::file_time_type last{};
  while (!ended_.wait_for(lock, kPeriod, [this] { return has_ended_; })) {
    std::error_code error;
    const files::file_time_type time = files::last_write_time(temporary_, error);
    if (error || std::exchange(last, time) != time || !is_nearly_full()) changed = SteadyClock::now();
    if (SteadyClock::now() - changed < kStall) continue;
    files::remove(temporary_, error);
    print();
    // The launcher ends the other ranks. MPI_Abort() is for the thread that has initialized MPI.
    std::_Exit(cli::kNothingWritten);
  }
}

bool WriteWatch::is_nearly_full() const {
  std::error_code error;
  const files::space_info space = files::space(files::absolute(temporary_, error).parent_path(), error);
  return !error && space.available < kNearlyFull;
}

void WriteWatch::print() const {
  fmt::print(stderr, "tetune-mpi: {}: could not be written (disk full?)\n", path_);
  std::fflush(stderr);
}

}  // namespace tetune::mpi

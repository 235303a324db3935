// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "par/span.hpp"

namespace tetune::par {

/// Threads that wait for loops to share. Between loops a thread spins for some microseconds and then sleeps; a loop
/// never waits for a thread that has not started on it, the caller does the work instead. So a machine that is busy
/// with other things costs its share of the processor and no more (docs/benchmarks/cpu.md, "A busy machine").
///
/// One loop at a time, from one thread.
class ThreadPool {
 public:
  /// Far above what helps: it bounds what a slip of the caller costs.
  static constexpr int kMaxThreads = 4096;

  /// `threads` counts the caller. At most kMaxThreads, and fewer where the system does not give them.
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  /// Those that there are, with the caller.
  int threads() const { return static_cast<int>(threads_.size()) + 1; }

  /// f(part) for part in [0, parts), in any order, on all threads. The first exception is thrown on.
  template <class F>
  void run(Size parts, const F& f) {
    run_erased(parts, &f, [](const void* task, Size part) { (*static_cast<const F*>(task))(part); });
  }

 private:
  using Call = void (*)(const void* task, Size part);
  void run_erased(Size parts, const void* task, Call call);
  void work();
  void take_parts();

  // The loop in progress; written while the gate is shut.
  const void* task_ = nullptr;
  Call call_ = nullptr;
  Size parts_ = 0;
  std::atomic<Size> next_{0};
  std::mutex error_mutex_;
  std::exception_ptr error_;

  /// Number of the loop; what threads sleep on. Changed in sequential consistency: a change that moves behind the look
  /// for sleepers in notify_all() would leave asleep whoever lies down in between.
  std::atomic<std::uint32_t> round_{0};
  /// Round in the high half, then a bit for "open", then the number of threads inside: a thread enters by raising that
  /// number while the gate is open, so none can enter late.
  std::atomic<std::uint64_t> gate_{0};
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

}  // namespace tetune::par

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "backend/span.hpp"

namespace tetune::backend {

/// A reference to a function object f(part) that processes one part of a loop.
struct PartTask {
  template <class F>
  PartTask(const F& f) : object(&f), call([](const void* task, Size part) { (*static_cast<const F*>(task))(part); }) {}

  const void* object;
  void (*call)(const void* object, Size part);
};

/// Worker threads that share the parts of a loop with the calling thread. Between loops a worker spins for some tens of
/// microseconds and then blocks. A loop waits only for workers that have started on it: the caller processes all other
/// parts itself. So on a busy machine a loop takes no more than its share of the processor
/// (docs/benchmarks/cpu.md, "A busy machine").
///
/// Runs one loop at a time, from one thread.
class ThreadPool {
 public:
  /// Far above any useful number; bounds the cost of a mistake of the caller.
  static constexpr int kMaxThreads = 4096;

  /// `threads` counts the caller. At most kMaxThreads, and fewer where the system refuses to create more.
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  /// The number of threads that exist, with the caller.
  int threads() const { return static_cast<int>(workers_.size()) + 1; }

  /// Calls the task for each part in [0, parts), in any order, on all threads. Rethrows the first exception.
  void run(Size parts, const PartTask& task);

 private:
  void work();
  void take_parts();

  // The loop in progress; written while the gate is closed.
  const PartTask* task_ = nullptr;
  Size parts_ = 0;
  std::atomic<Size> next_{0};
  std::mutex error_mutex_;
  std::exception_ptr error_;

  /// The number of the loop, on which workers block. Its changes are sequentially consistent: notify_all() must not
  /// test for waiting threads before the change is visible, as a thread that starts to wait in between would miss it.
  std::atomic<std::uint32_t> round_{0};
  /// The round in the upper half, then one bit for "open", then the number of workers inside. A worker enters by
  /// incrementing that number while the gate is open, so none can enter late.
  std::atomic<std::uint64_t> gate_{0};
  std::atomic<bool> stop_{false};
  std::vector<std::thread> workers_;
};

}  // namespace tetune::backend

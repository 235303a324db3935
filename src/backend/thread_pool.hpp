// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "backend/processor_model.hpp"
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
  static constexpr int clamp(int threads) { return std::clamp(threads, 1, kMaxThreads); }

  /// `threads` counts the caller. At most kMaxThreads, and fewer where the system refuses to create more.
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  /// The number of threads that exist, or that are modeled, with the caller.
  int threads() const { return threads_; }

  /// Calls the task for each part in [0, parts), in any order, on all threads. Rethrows the first exception.
  void run(Size parts, const PartTask& task);

 private:
  void work();
  /// Publishes a round, and wakes the workers that block.
  void begin(std::uint32_t round);
  /// Returns when a round other than `seen` has begun.
  void wait_for_round(std::uint32_t seen);
  void take_parts();

  /// Runs the loops in place of workers; null: there is no model.
  ProcessorModel* model_;
  int threads_;

  // The loop in progress; written while the gate is closed.
  const PartTask* task_ = nullptr;
  Size parts_ = 0;
  std::atomic<Size> next_{0};
  std::mutex error_mutex_;
  std::exception_ptr error_;

  /// The number of the loop. A worker increments `blocked_` before it tests the round a last time, and begin() writes
  /// the round before it reads `blocked_`, both sequentially consistent: one of the two sees the other.
  std::atomic<std::uint32_t> round_{0};
  /// The number of workers that block, or are about to.
  std::atomic<int> blocked_{0};
  /// Instead of std::atomic::wait(), which loses notifications in libstdc++ 12 where the system has no futex (Windows).
  std::mutex block_mutex_;
  std::condition_variable begun_;
  /// The round in the upper half, then one bit for "open", then the number of workers inside. A worker enters by
  /// incrementing that number while the gate is open, so none can enter late.
  std::atomic<std::uint64_t> gate_{0};
  std::atomic<bool> stop_{false};
  std::vector<std::thread> workers_;
};

}  // namespace tetune::backend

// SPDX-License-Identifier: Apache-2.0
#include "backend/thread_pool.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace tetune::backend {

[[gnu::weak]] ProcessorModel* processor_model() noexcept { return nullptr; }

SteadyClock::time_point SteadyClock::now() noexcept {
  const ProcessorModel* const model = processor_model();
  return model != nullptr ? model->now() : std::chrono::steady_clock::now();
}

namespace {

constexpr std::uint64_t kOpen = std::uint64_t{1} << 31;
constexpr std::uint64_t kInside = kOpen - 1;
/// Some tens of microseconds: longer than the gap between two loops of one sweep.
constexpr int kSpins = 2000;

void relax() {
#if defined(__x86_64__)
  _mm_pause();
#endif
}

}  // namespace

ThreadPool::ThreadPool(int threads) : model_(processor_model()), threads_(clamp(threads)) {
  if (model_ != nullptr) return;
  try {
    if (threads_ > 1) workers_.reserve(to_size_t(threads_));
    for (int t = 1; t < threads_; ++t) workers_.emplace_back([this] { work(); });
  } catch (...) {
    // The system refused a thread or memory. The pool uses the threads that started; no result depends on their number.
    threads_ = int(workers_.size()) + 1;
  }
}

ThreadPool::~ThreadPool() {
  stop_.store(true, std::memory_order_relaxed);
  begin(round_.load(std::memory_order_relaxed) + 1);
  for (std::thread& worker : workers_) worker.join();
}

void ThreadPool::begin(std::uint32_t round) {
  round_.store(round);
  if (blocked_.load() == 0) return;
  // A worker that holds the mutex has tested the round before this lock, and waits after it.
  { const std::lock_guard lock(block_mutex_); }
  begun_.notify_all();
}

void ThreadPool::wait_for_round(std::uint32_t seen) {
  for (int spin = 0; spin < kSpins; ++spin) {
    if (round_.load(std::memory_order_acquire) != seen) return;
    relax();
  }
  std::unique_lock lock(block_mutex_);
  blocked_.fetch_add(1);
  begun_.wait(lock, [&] { return round_.load() != seen; });
  blocked_.fetch_sub(1, std::memory_order_relaxed);
}

void ThreadPool::take_parts() {
  for (Size part = next_.fetch_add(1, std::memory_order_relaxed); part < parts_;
       part = next_.fetch_add(1, std::memory_order_relaxed)) {
    try {
      task_->call(task_->object, part);
    } catch (...) {
      const std::lock_guard lock(error_mutex_);
      if (!error_) error_ = std::current_exception();
    }
  }
}

void ThreadPool::work() {
  std::uint32_t seen = 0;
  for (;;) {
    wait_for_round(seen);
    seen = round_.load(std::memory_order_acquire);
    if (stop_.load(std::memory_order_relaxed)) return;
    std::uint64_t gate = gate_.load(std::memory_order_relaxed);
    bool entered = false;
    while (!entered && (gate >> 32) == seen && (gate & kOpen) != 0) {
      entered = gate_.compare_exchange_weak(gate, gate + 1, std::memory_order_acquire, std::memory_order_relaxed);
    }
    if (!entered) continue;
    take_parts();
    gate_.fetch_sub(1, std::memory_order_release);
  }
}

void ThreadPool::run(Size parts, const PartTask& task) {
  if (model_ != nullptr) return model_->run(threads_, parts, task);
  if (workers_.empty() || parts <= 1) {
    for (Size part = 0; part < parts; ++part) task.call(task.object, part);
    return;
  }
  task_ = &task;
  parts_ = parts;
  error_ = nullptr;
  next_.store(0, std::memory_order_relaxed);
  const std::uint32_t round = round_.load(std::memory_order_relaxed) + 1;
  gate_.store((std::uint64_t{round} << 32) | kOpen, std::memory_order_release);
  begin(round);
  take_parts();
  gate_.fetch_and(~kOpen, std::memory_order_relaxed);
  for (int spin = 0; (gate_.load(std::memory_order_acquire) & kInside) != 0; ++spin) {
    if (spin < kSpins) {
      relax();
    } else {
      std::this_thread::yield();
    }
  }
  if (error_) std::rethrow_exception(error_);
}

}  // namespace tetune::backend

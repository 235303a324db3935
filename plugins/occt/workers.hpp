// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "nearest.hpp"

namespace tetune::plugin {

/// Nearest points by several threads, each of which has searches of its own.
class Workers {
 public:
  explicit Workers(const Model& model) : model_(model) { prepare(1); }

  /// The search of the calling thread.
  NearestPoints& own() { return *nearest_.front(); }

  /// Calls f(nearest, begin, end) for chunks of 0 to `count`, which do not depend on the number of threads. `threads`:
  /// 0 for all cores.
  template <class F>
  void for_chunks(std::size_t count, int threads, const F& f) {
    const std::size_t chunks = (count + kChunk - 1) / kChunk;
    const std::size_t wanted = threads > 0 ? std::size_t(threads) : std::thread::hardware_concurrency();
    const std::size_t used = std::clamp<std::size_t>(wanted, 1, std::max<std::size_t>(chunks, 1));
    prepare(used);
    std::atomic<std::size_t> next{0};
    std::exception_ptr error;
    std::mutex mutex;
    const auto work = [&](NearestPoints& nearest) {
      try {
        for (std::size_t c = next++; c < chunks; c = next++) {
          f(nearest, c * kChunk, std::min(count, (c + 1) * kChunk));
        }
      } catch (...) {
        const std::lock_guard lock(mutex);
        error = std::current_exception();
        next = chunks;
      }
    };
    {
      std::vector<std::jthread> others;
      others.reserve(used);
      try {
        for (std::size_t i = 1; i < used; ++i) others.emplace_back(work, std::ref(*nearest_[i]));
      } catch (const std::system_error&) {
        // The system refused a thread: those that started do all chunks.
      }
      work(own());
    }
    if (error) std::rethrow_exception(error);
  }

 private:
  static constexpr std::size_t kChunk = 256;

  void prepare(std::size_t count) {
    while (nearest_.size() < count) nearest_.push_back(std::make_unique<NearestPoints>(model_));
  }

  const Model& model_;
  std::vector<std::unique_ptr<NearestPoints>> nearest_;
};

}  // namespace tetune::plugin

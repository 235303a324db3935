// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <functional>

#include "backend/cpu.hpp"

namespace tetune {

/// Evaluates functions of many points by all threads, in chunks between which a stop may be requested.
class ChunkedQueries {
 public:
  static constexpr Size kChunk = 4096;  ///< takes some milliseconds on one thread

  ChunkedQueries(int threads, const std::function<bool()>& stop) : cpu_(threads), stop_(stop) {}

  bool is_stopped() const { return is_stopped_; }
  /// Calls f(i) for all i in [begin, end), or for none after a stop.
  template <class F>
  void chunk(Size begin, Size end, const F& f) {
    is_stopped_ = is_stopped_ || (stop_ && stop_());
    if (!is_stopped_) cpu_.for_each(end - begin, Query<F>{f, begin});
  }
  /// Calls f(i) for all i in [0, n) until a stop.
  template <class F>
  void all(Size n, const F& f) {
    for (Size begin = 0; begin < n && !is_stopped_; begin += kChunk) chunk(begin, std::min(n, begin + kChunk), f);
  }

 private:
  template <class F>
  struct Query {
    static constexpr Size kGrain = 32;
    const F& f;
    Size begin;
    void operator()(Size i) const { f(begin + i); }
  };

  backend::Cpu cpu_;
  const std::function<bool()>& stop_;
  bool is_stopped_ = false;
};

}  // namespace tetune

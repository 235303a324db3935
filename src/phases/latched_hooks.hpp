// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <thread>

#include "tetune/context.hpp"

namespace tetune {

/// Hooks for several runs: they latch the request to stop, as an interrupted step must not be resumed, and the fraction
/// that is done does not fall where a run is repeated. Those of the caller are called on the thread that made this
/// object alone; on others the request is the latched one.
class LatchedHooks {
 public:
  explicit LatchedHooks(const Context& caller) : caller_(caller) {
    context_.stop = [this] {
      if (std::this_thread::get_id() == thread_ && !stopped_ && caller_.stop && caller_.stop()) stopped_ = true;
      return stopped_.load();
    };
    if (caller_.progress) {
      context_.progress = [this](Progress p) {
        fraction_ = p.fraction = std::max(fraction_, p.fraction);
        if (!stopped_ && !caller_.progress(p)) stopped_ = true;
        return !stopped_;
      };
    }
  }
  LatchedHooks(const LatchedHooks&) = delete;
  LatchedHooks& operator=(const LatchedHooks&) = delete;
  const Context& context() const { return context_; }
  bool is_stopped() const { return stopped_; }

 private:
  const Context& caller_;
  const std::thread::id thread_ = std::this_thread::get_id();
  std::atomic<bool> stopped_ = false;
  double fraction_ = 0;
  Context context_;
};

/// The hooks of a part of a run, before which a part `done` is done.
inline Context part_of(const Context& whole, double done, double part) {
  Context context = whole;
  if (whole.progress) {
    context.progress = [progress = whole.progress, done, part](Progress p) {
      p.fraction = done + part * p.fraction;
      return progress(p);
    };
  }
  return context;
}

}  // namespace tetune

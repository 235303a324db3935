// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <thread>

#include "tetune/context.hpp"

namespace tetune {

/// Hooks that several runs share. A request to stop is remembered, since an interrupted step must not be resumed, and
/// the reported fraction never falls. The caller's hooks are called only on the thread that made this object; other
/// threads see the remembered request.
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

/// The hooks of a step that takes the run's progress from `done` to `done + fraction`.
inline Context scaled_progress(const Context& whole, double done, double fraction) {
  Context context = whole;
  if (whole.progress) {
    context.progress = [progress = whole.progress, done, fraction](Progress p) {
      p.fraction = done + fraction * p.fraction;
      return progress(p);
    };
  }
  return context;
}

}  // namespace tetune

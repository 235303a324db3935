// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "backend/span.hpp"

namespace tetune::backend {

struct PartTask;

/// Takes the place of the processors: runs the loops of all thread pools on the calling thread, and gives the time at
/// which a modeled machine would be done. So a program predicts times for more processors than its machine has
/// (bench/scaling).
class ProcessorModel {
 public:
  /// Runs a loop of a pool of that many threads.
  virtual void run(int threads, Size parts, const PartTask& task) = 0;
  virtual std::chrono::steady_clock::time_point now() const noexcept = 0;

 protected:
  ~ProcessorModel() = default;
};

/// The model that the process uses: none in the library. The function is weak, so that a program may replace it.
ProcessorModel* processor_model() noexcept;

/// The clock of all times in reports: modeled time where there is a model.
struct SteadyClock {
  using time_point = std::chrono::steady_clock::time_point;
  static time_point now() noexcept;
};

}  // namespace tetune::backend

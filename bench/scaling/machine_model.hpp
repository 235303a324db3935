// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <vector>

#include "backend/processor_model.hpp"

/// Predicts times on more processors than the machine has.
namespace tetune::scaling {

/// The costs of threads, in seconds: estimates, of which a run on two processors can confirm the first three.
struct ThreadCosts {
  /// From the start of a loop until a worker that spins has taken part of it.
  double start = 0.3e-6;
  /// Each worker enters and leaves through one atomic number, one after the other.
  double gate = 0.1e-6;
  /// Each part is taken from one atomic number.
  double take = 0.05e-6;
  /// A worker blocks after this time without a loop; then the first one starts after `notify`, each further one after
  /// `notify_each` more.
  double spin = 40e-6;
  double notify = 50e-6;
  double notify_each = 2e-6;
};

/// The time in which the threads of a pool process parts, of which each takes the next one when it is free. The last
/// loop ended `since_last_loop` before.
double makespan(const std::vector<double>& part_seconds, int threads, double since_last_loop, const ThreadCosts& costs);

/// Runs loops on the calling thread, times each part, and advances the clock by the makespan.
class MachineModel final : public backend::ProcessorModel {
 public:
  enum class Loops {
    scheduled,  ///< by the threads of the pool, with their costs
    free        ///< in no time: the parts of a run that are not loops are left
  };

  MachineModel(Loops loops, const ThreadCosts& costs) : loops_(loops), costs_(costs) {}

  void run(int threads, Size parts, const backend::PartTask& task) override;
  std::chrono::steady_clock::time_point now() const noexcept override;

 private:
  Loops loops_;
  ThreadCosts costs_;
  /// A loop within a part of another one is part of that one's work.
  bool is_within_loop_ = false;
  /// Modeled minus real time.
  std::chrono::steady_clock::duration ahead_{0};
  std::chrono::steady_clock::time_point end_of_last_loop_{};
  std::vector<double> part_seconds_;
};

}  // namespace tetune::scaling

// SPDX-License-Identifier: Apache-2.0
#include "machine_model.hpp"

#include <algorithm>
#include <functional>
#include <queue>

#include "backend/thread_pool.hpp"

namespace tetune::scaling {
namespace {

double seconds(std::chrono::steady_clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

}  // namespace

double makespan(const std::vector<double>& part_seconds, int threads, double since_last_loop,
                const ThreadCosts& costs) {
  const bool blocked = since_last_loop > costs.spin;
  std::priority_queue<double, std::vector<double>, std::greater<>> free_at;
  free_at.push(0);
  for (int worker = 1; worker < threads; ++worker) {
    free_at.push(blocked ? costs.notify + costs.notify_each * worker : costs.start + costs.gate * worker);
  }
  double counter_free_at = 0;
  double end = 0;
  for (const double part : part_seconds) {
    counter_free_at = std::max(free_at.top(), counter_free_at) + costs.take;
    free_at.pop();
    free_at.push(counter_free_at + part);
    end = std::max(end, counter_free_at + part);
  }
  return end + costs.start + costs.gate * (threads - 1);
}

std::chrono::steady_clock::time_point MachineModel::now() const noexcept {
  return std::chrono::steady_clock::now() + ahead_;
}

void MachineModel::run(int threads, Size parts, const backend::PartTask& task) {
  if (is_within_loop_) {
    for (Size part = 0; part < parts; ++part) task.call(task.object, part);
    return;
  }
  is_within_loop_ = true;
  const auto start = std::chrono::steady_clock::now();
  const double since_last_loop = seconds(start + ahead_ - end_of_last_loop_);
  part_seconds_.clear();
  auto part_start = start;
  for (Size part = 0; part < parts; ++part) {
    task.call(task.object, part);
    const auto part_end = std::chrono::steady_clock::now();
    part_seconds_.push_back(seconds(part_end - part_start));
    part_start = part_end;
  }
  double modeled = 0;
  if (loops_ == Loops::scheduled) {
    // The pool runs a single part, or all parts of a single thread, without any cost of threads.
    modeled = threads > 1 && parts > 1 ? makespan(part_seconds_, threads, since_last_loop, costs_)
                                       : seconds(part_start - start);
  }
  ahead_ += std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(modeled)) -
            (std::chrono::steady_clock::now() - start);
  end_of_last_loop_ = now();
  is_within_loop_ = false;
}

}  // namespace tetune::scaling

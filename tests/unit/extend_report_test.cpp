// SPDX-License-Identifier: Apache-2.0
#include "driver/report/extend_report.hpp"

#include <gtest/gtest.h>

namespace tetune {
namespace {

/// A run of sweeps, with a flip pass before them and after each, and one round on the worst elements.
Report run_of(int sweeps) {
  Report report;
  for (int i = 0; i <= sweeps; ++i) {
    if (i > 0) {
      report.sweeps.emplace_back().iteration = i;
      report.sweeps.back().moved = i;
    }
    report.flip_passes.emplace_back().iteration = i;
  }
  report.worst_rounds.emplace_back().moved = 10 + sweeps;
  return report;
}

TEST(ExtendReport, StepsOfFurtherRunsFollow) {
  Report report = run_of(2);
  extend_report(report, run_of(1), {});
  std::vector<std::int64_t> moved;
  std::vector<int> sweeps, flips;
  for (const SweepReport& s : report.sweeps) sweeps.push_back(s.iteration);
  for (const FlipReport& f : report.flip_passes) flips.push_back(f.iteration);
  for (const WorstReport& w : report.worst_rounds) moved.push_back(w.moved);
  EXPECT_EQ(sweeps, (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(report.sweeps[2].moved, 1);
  EXPECT_EQ(flips, (std::vector<int>{0, 1, 2, 2, 3}));
  EXPECT_EQ(moved, (std::vector<std::int64_t>{12, 11}));
}

}  // namespace
}  // namespace tetune

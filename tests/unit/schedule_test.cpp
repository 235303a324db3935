// SPDX-License-Identifier: Apache-2.0
#include "phases/schedule.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "phases/tuning.hpp"

namespace tetune {
namespace {

Options with_effort(Effort effort) {
  Options options;
  options.effort = effort;
  return options;
}

bool stops(Schedule& schedule, double energy_before, double energy) {
  StopReason reason = StopReason::iteration_limit;
  const bool stop = schedule.stop(SweepReport{}, energy_before, energy, reason);
  EXPECT_EQ(reason, stop ? StopReason::converged : StopReason::iteration_limit);
  return stop;
}

TEST(Schedule, FastFlipsAfterTheFirstSweepOnly) {
  Schedule schedule(with_effort(Effort::fast));
  EXPECT_TRUE(schedule.flips_due(1));
  schedule.record_flips(1, 100, 0.1);
  EXPECT_FALSE(stops(schedule, 1, 0.9));
  for (int iteration = 2; iteration < 100; ++iteration) EXPECT_FALSE(schedule.flips_due(iteration));
  EXPECT_TRUE(stops(schedule, 0.9, 0.89));
}

TEST(Schedule, FastFlipsOnceForAnyMaximumOfSweeps) {
  Options options = with_effort(Effort::fast);
  options.max_iterations = std::numeric_limits<int>::max();
  Schedule schedule(options);
  schedule.record_flips(1, 100, 0.1);
  EXPECT_FALSE(schedule.flips_due(2));
}

TEST(Schedule, AMeshWithoutTetrahedraIsConverged) {
  Schedule schedule(Options{});
  EXPECT_TRUE(stops(schedule, 0, 0));
}

TEST(Schedule, FastWithoutFlipsConverges) {
  Options options = with_effort(Effort::fast);
  options.flips = false;
  Schedule schedule(options);
  EXPECT_TRUE(stops(schedule, 1, 1));
}

TEST(Schedule, FlipsOfLittleGainDoubleTheInterval) {
  Schedule schedule(Options{});
  EXPECT_TRUE(schedule.flips_due(1));
  schedule.record_flips(1, 100, 0.1);
  EXPECT_TRUE(schedule.flips_due(2));
  schedule.record_flips(2, 100, 1e-4);
  EXPECT_FALSE(schedule.flips_due(3));
  EXPECT_TRUE(schedule.flips_due(4));
}

TEST(Schedule, HigherEffortStopsLater) {
  Schedule fast(with_effort(Effort::fast));
  Schedule standard(with_effort(Effort::standard));
  Schedule best(with_effort(Effort::best));
  EXPECT_TRUE(stops(fast, 1, 0.99));
  EXPECT_FALSE(stops(standard, 1, 0.99));
  EXPECT_TRUE(stops(standard, 1, 0.999));
  EXPECT_FALSE(stops(best, 1, 0.999));
}

TEST(Tuning, RoundsBeforeRestartsLeaveThemAPartOfTheGrowth) {
  const RestartParameters& restarts = tuning_of(Effort::best).restart;
  EXPECT_DOUBLE_EQ(inserted_fraction_before(restarts, 0), 0.6);
  EXPECT_DOUBLE_EQ(inserted_fraction_before(restarts, 100), 0.6);
  EXPECT_DOUBLE_EQ(inserted_fraction_before(restarts, 600), 0.9);
  EXPECT_DOUBLE_EQ(inserted_fraction_before(restarts, 1e5), 0.95);
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "driver/schedule.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace tetune {
namespace {

SweepReport sweep(int iteration) {
  SweepReport r;
  r.iteration = iteration;
  return r;
}

TEST(Schedule, FastLooksForFlipsAfterTheFirstSweepAlone) {
  Options options;
  options.effort = Effort::fast;
  Schedule schedule(options);
  StopReason reason = StopReason::iteration_limit;
  EXPECT_TRUE(schedule.flips_due(1));
  schedule.flips_found(1, 100, 0.1);
  EXPECT_FALSE(schedule.stop(sweep(1), 1, 0.9, reason));
  for (int iteration = 2; iteration < 100; ++iteration) EXPECT_FALSE(schedule.flips_due(iteration));
  EXPECT_TRUE(schedule.stop(sweep(2), 0.9, 0.89, reason));
  EXPECT_EQ(reason, StopReason::converged);
}

TEST(Schedule, FastLooksOnceHoweverManySweepsThereMayBe) {
  Options options;
  options.effort = Effort::fast;
  options.max_iterations = std::numeric_limits<int>::max();
  Schedule schedule(options);
  schedule.flips_found(1, 100, 0.1);
  EXPECT_FALSE(schedule.flips_due(2));
}

TEST(Schedule, WithoutElementsThereIsNothingToDo) {
  StopReason reason = StopReason::iteration_limit;
  EXPECT_TRUE(Schedule(Options{}).stop(sweep(1), 0, 0, reason));
  EXPECT_EQ(reason, StopReason::converged);
}

TEST(Schedule, FastWithoutFlipsWaitsForNone) {
  Options options;
  options.effort = Effort::fast;
  options.flips = false;
  Schedule schedule(options);
  StopReason reason = StopReason::iteration_limit;
  EXPECT_TRUE(schedule.stop(sweep(1), 1, 1, reason));
  EXPECT_EQ(reason, StopReason::converged);
}

TEST(Schedule, LooksForFlipsAreRarerWhereTheyGainLittle) {
  Schedule schedule(Options{});
  EXPECT_TRUE(schedule.flips_due(1));
  schedule.flips_found(1, 100, 0.1);
  EXPECT_TRUE(schedule.flips_due(2));
  schedule.flips_found(2, 100, 1e-4);
  EXPECT_FALSE(schedule.flips_due(3));
  EXPECT_TRUE(schedule.flips_due(4));
}

}  // namespace
}  // namespace tetune

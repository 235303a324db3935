// SPDX-License-Identifier: Apache-2.0
// Restarts around the worst element: a kept one lowers the largest cost, a failed one leaves no trace.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "phases/tuning.hpp"
#include "support/meshes.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

Options with_restarts(int restarts) {
  Options options;
  options.effort = Effort::best;
  options.restarts = restarts;
  return options;
}

bool are_same(const TetMesh& a, const TetMesh& b) { return a.points == b.points && a.tets == b.tets; }

/// The cost that restarts lower: see AngleParameters.
double largest_cost(const TetMesh& mesh) {
  const Quality q = quality(mesh);
  const auto cot = [](double degrees) { return 1 / std::tan(degrees * std::numbers::pi / 180); };
  return std::max(cot(q.dihedral_min), -tuning_of(Effort::best).angles.obtuse_weight * cot(q.dihedral_max));
}

/// Numbers of meshes: whose largest cost is lower with restarts, and whose restarts all failed.
struct RestartCounts {
  int lower = 0, failed = 0;
};

RestartCounts compare_with_none(Boundary boundary, int restarts) {
  RestartCounts found;
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const TetMesh input = test::scrambled(test::cube(5, 0.3, seed), 3, seed);
    Options options = with_restarts(0);
    options.boundary = boundary;
    TetMesh without = input;
    optimize(without, options);
    options.restarts = restarts;
    TetMesh with = input;
    const Report report = optimize(with, options);
    EXPECT_TRUE(validate(with).ok());
    const RestartParameters& p = tuning_of(Effort::best).restart;
    EXPECT_LE(report.restarts, p.spots * p.tries * 2 * restarts);
    EXPECT_LE(double(with.tets.size()), options.max_growth * double(input.tets.size()));
    if (report.restarts_kept > 0) {
      EXPECT_LE(largest_cost(with), largest_cost(without)) << seed;
      found.lower += largest_cost(with) < largest_cost(without) ? 1 : 0;
    } else {
      EXPECT_TRUE(are_same(with, without)) << seed;
      found.failed += report.restarts > 0 ? 1 : 0;
    }
  }
  return found;
}

TEST(Restarts, LowerTheLargestCost) { EXPECT_GT(compare_with_none(Boundary::preserve, 6).lower, 2); }

TEST(Restarts, LeaveNoTraceWhereTheyFail) { EXPECT_GT(compare_with_none(Boundary::fixed, 1).failed, 0); }

TEST(Restarts, TheNumberOfThreadsDoesNotMatter) {
  const TetMesh input = test::scrambled(test::cube(5, 0.3, 2), 3, 2);
  Options options = with_restarts(6);
  options.threads = 1;
  TetMesh one = input;
  const Report report = optimize(one, options);
  EXPECT_GT(report.restarts_kept, 0);
  EXPECT_GT(report.restarts, report.restarts_kept);
  for (const int threads : {3, 12}) {
    options.threads = threads;
    TetMesh more = input;
    const Report of_more = optimize(more, options);
    EXPECT_TRUE(are_same(one, more)) << threads;
    EXPECT_EQ(of_more.restarts, report.restarts) << threads;
    EXPECT_EQ(of_more.restarts_kept, report.restarts_kept) << threads;
  }
}

TEST(Restarts, AStopTakesBackTheOneThatIsUnderWay) {
  const TetMesh input = test::scrambled(test::cube(5, 0.3, 3), 3, 3);
  const double angle = quality(input).dihedral_min;
  int polls = 0;
  bool in_restarts = false;
  const auto run = [&](int limit) {
    polls = 0;
    in_restarts = false;
    Context context;
    context.progress = [&](const Progress& p) {
      in_restarts = in_restarts || p.phase == std::string("restarts");
      return true;
    };
    context.stop = [&] { return in_restarts && ++polls > limit; };
    TetMesh mesh = input;
    Options options = with_restarts(6);
    options.threads = 1;
    const Report report = optimize(mesh, options, context);
    EXPECT_TRUE(in_restarts) << limit;
    EXPECT_EQ(report.stop, StopReason::cancelled) << limit;
    EXPECT_TRUE(validate(mesh).ok());
    EXPECT_GE(quality(mesh).dihedral_min, angle);
    return mesh;
  };
  const TetMesh first = run(0);
  // Stopped within the second restart: as after the first one.
  for (const int limit : {1, 3, 8}) EXPECT_TRUE(are_same(run(limit), first)) << limit;
}

TEST(Restarts, TheOptionIsTheNumberOfRounds) {
  Options options;
  EXPECT_EQ(restart_rounds(options, 1e6), 0);
  options.effort = Effort::best;
  EXPECT_EQ(restart_rounds(options, 1e6), 10);
  EXPECT_EQ(restart_rounds(options, 900), 3);
  EXPECT_EQ(largest_angle_rounds(options), 10);
  options.restarts = 30;
  EXPECT_EQ(restart_rounds(options, 900), 30);
  EXPECT_EQ(largest_angle_rounds(options), 30);
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
// Progress, cancellation and warnings of a run.
#include <gtest/gtest.h>

#include <string>

#include "mesh/tet.hpp"
#include "support/meshes.hpp"
#include "support/options.hpp"
#include "support/safe_points.hpp"
#include "tetune/tetune.hpp"

namespace tetune {
namespace {

using test::options_of;

TetMesh input() { return test::scrambled(test::cube(5, 0.3), 3, 1); }

bool same(const TetMesh& a, const TetMesh& b) { return a.points == b.points && a.tets == b.tets; }

/// Wherever a run is stopped: the mesh is valid, and no worse than it was.
TEST(Control, StopsAtEverySafePoint) {
  const TetMesh before = input();
  const double worst = quality(before).dihedral_min;
  for (const Effort effort : {Effort::standard, Effort::best}) {
    for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
      const Options options = options_of(effort, boundary, 1);
      TetMesh whole = before;
      Report complete;
      const int points =
          test::count_safe_points([&](const Context& context) { complete = optimize(whole, options, context); });
      ASSERT_NE(complete.stop, StopReason::cancelled);
      EXPECT_GT(points, 50);
      for (int at = 1; at <= points; at += 1 + at / 4) {
        int asked = 0;
        TetMesh m = before;
        const Report report = optimize(m, options, test::stop_once_at(at, asked));
        EXPECT_EQ(report.stop, StopReason::cancelled);
        EXPECT_EQ(asked, at);
        const ValidationReport valid = validate(m);
        ASSERT_TRUE(valid.ok()) << "stopped at " << at << ": " << valid.message(false);
        EXPECT_GE(quality(m).dihedral_min, worst - 1e-9);
        if (effort != Effort::best) {
          EXPECT_LE(report.energy_after, report.energy_before * (1 + 1e-12));
        }
        EXPECT_NEAR(report.energy_after, quality(m).shape_sum, 1e-9 * report.energy_after);
        EXPECT_EQ(report.tet2original.size(), m.tets.size());
        if (at == 1) {
          EXPECT_EQ(m.points, before.points);
          EXPECT_EQ(report.energy_after, report.energy_before);
        }
      }
    }
  }
}

/// Proposals are evaluated in batches, and a stop is requested before each of those of one round.
TEST(Control, StopsBetweenBatchesOfProposals) {
  const TetMesh before = test::scrambled(test::cube(14, 0.2), 3, 1);
  Options options = options_of(Effort::best, Boundary::preserve, 1);
  options.restarts = 0;
  for (int at = 1; at <= 4; ++at) {
    bool is_in_rounds = false;
    int polls = 0;
    Context context;
    context.progress = [&](const Progress& p) {
      is_in_rounds = is_in_rounds || p.phase == std::string("worst");
      return true;
    };
    context.stop = [&] { return is_in_rounds && ++polls == at; };
    TetMesh m = before;
    EXPECT_EQ(optimize(m, options, context).stop, StopReason::cancelled);
    const ValidationReport valid = validate(m);
    ASSERT_TRUE(valid.ok()) << "stopped at " << at << ": " << valid.message(false);
    EXPECT_GE(quality(m).dihedral_min, quality(before).dihedral_min);
  }
}

TEST(Control, ProgressReportsHowFarTheRunIs) {
  const TetMesh before = input();
  for (const Effort effort : {Effort::fast, Effort::standard, Effort::best}) {
    TetMesh m = before;
    std::vector<Progress> seen;
    Context context;
    context.progress = [&seen](const Progress& p) {
      seen.push_back(p);
      return true;
    };
    optimize(m, options_of(effort, Boundary::preserve, 1), context);
    ASSERT_GT(seen.size(), 5U);
    EXPECT_STREQ(seen[0].phase, "load");
    EXPECT_NEAR(seen[0].worst_angle, quality(before).dihedral_min, 1e-9);
    EXPECT_EQ(seen[0].energy, seen[0].energy_before);
    EXPECT_LT(seen[0].seconds_left, 0);
    EXPECT_GE(seen.back().seconds_left, 0);
    EXPECT_GT(seen.back().fraction, 0.7);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      EXPECT_GT(seen[i].fraction, 0);
      EXPECT_LE(seen[i].fraction, 1);
      EXPECT_GE(seen[i].worst_angle, quality(before).dihedral_min - 1e-9);
      if (i == 0) continue;
      EXPECT_GE(seen[i].fraction, seen[i - 1].fraction);
      EXPECT_GE(seen[i].seconds, seen[i - 1].seconds);
    }
    TetMesh alone = before;
    optimize(alone, options_of(effort, Boundary::preserve, 1));
    EXPECT_TRUE(same(m, alone));
  }
}

TEST(Control, WithoutFlipsTheTetrahedraStay) {
  const TetMesh before = input();
  for (const Termination termination : {Termination::relative, Termination::paper}) {
    TetMesh m = before;
    Options options = options_of(Effort::standard, Boundary::preserve, 1);
    options.flips = false;
    options.termination = termination;
    options.max_iterations = 20;
    const Report report = optimize(m, options);
    EXPECT_TRUE(report.flip_passes.empty());
    EXPECT_EQ(report.flips23 + report.flips32 + report.edge_removals + report.face_removals + report.boundary_flips, 0);
    EXPECT_LT(report.energy_after, report.energy_before);
    EXPECT_TRUE(validate(m).ok());
    ASSERT_EQ(m.tets.size(), before.tets.size());
    for (std::size_t t = 0; t < m.tets.size(); ++t) {
      EXPECT_EQ(ascending(m.tets[t]), ascending(before.tets[static_cast<std::size_t>(report.tet2original[t])]));
    }
  }
  TetMesh m = before;
  Options nothing;
  nothing.flips = false;
  nothing.max_iterations = 0;
  const Report report = optimize(m, nothing);
  EXPECT_EQ(m.points, before.points);
  EXPECT_EQ(m.tets.size(), before.tets.size());
  EXPECT_EQ(report.energy_after, report.energy_before);
}

TEST(Control, MemoryNeededGrowsWithTheMeshAndTheWork) {
  const TetMesh small = test::cube(4);
  const TetMesh large = test::cube(12);
  EXPECT_GT(memory_needed(large), memory_needed(small));
  EXPECT_GT(memory_needed(large), large.tets.size() * 40 + large.points.size() * 40);
  Options best;
  best.effort = Effort::best;
  EXPECT_GT(memory_needed(large, best), memory_needed(large));
  Options slide;
  slide.boundary = Boundary::slide;
  EXPECT_GT(memory_needed(large, slide), memory_needed(large));
}

TEST(Control, MemoryNeededCountsTransferAndCurvedEdges) {
  TetMesh mesh = test::cube(4);
  mesh.tet_data = {{"t", 1, std::vector<double>(mesh.tets.size())}};
  const auto with = [&mesh](DataTransfer data, Boundary boundary = Boundary::preserve) {
    Options options;
    options.data = data;
    options.boundary = boundary;
    return memory_needed(mesh, options);
  };
  const std::size_t carry = with(DataTransfer::carry);
  EXPECT_EQ(with(DataTransfer::interpolate), carry + 45 * mesh.tets.size());
  EXPECT_EQ(with(DataTransfer::conserve), carry + 960 * mesh.tets.size());
  EXPECT_EQ(with(DataTransfer::conserve, Boundary::slide),
            with(DataTransfer::carry, Boundary::slide) + 1620 * mesh.tets.size());
  const std::size_t without_field = with(DataTransfer::conserve) - carry;
  mesh.point_data = {{"p", 3, std::vector<double>(3 * mesh.points.size())}};
  EXPECT_EQ(with(DataTransfer::conserve) - with(DataTransfer::carry), without_field + 3 * 48 * mesh.tets.size());
  const std::size_t straight = with(DataTransfer::carry);
  mesh.curved_edges.resize(5);
  EXPECT_EQ(with(DataTransfer::carry), straight + 75 * mesh.tets.size() + 5 * 470);
}

/// At the end each array is there before and after, data of vertices once more while those of inserted ones are made.
TEST(Control, MemoryNeededCountsData) {
  TetMesh mesh = test::cube(4);
  const auto with = [&mesh](const Options& options) { return memory_needed(mesh, options); };
  Options best;
  best.effort = Effort::best;
  const std::size_t none = with({});
  const std::size_t none_best = with(best);
  mesh.point_data = {{"p", 3, std::vector<double>(3 * mesh.points.size())}};
  const std::size_t points = 3 * sizeof(double) * mesh.points.size();
  EXPECT_EQ(with({}), none + 2 * points);
  EXPECT_EQ(with(best), none_best + 3 * points);
  mesh.tet_data = {{"t", 1, std::vector<std::int8_t>(mesh.tets.size())}};
  EXPECT_EQ(with({}), none + 2 * (points + mesh.tets.size()));
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "tetune/live_mesh.hpp"
#include "math/constants.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "support/meshes.hpp"
#include "support/options.hpp"
#include "support/sanitized.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

TetMesh optimized(int cells) {
  TetMesh mesh = test::two_materials(cells, 0.2);
  optimize(mesh);
  return mesh;
}

/// The inner vertex nearest to a point.
Index inner_vertex_near(const TetMesh& mesh, const Point3& at) {
  Index best = -1;
  double least = 1e300;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const Point3& p = mesh.points[v];
    const double d = std::hypot(p[0] - at[0], p[1] - at[1], p[2] - at[2]);
    if (!test::is_inner(p) || d >= least) continue;
    least = d;
    best = static_cast<Index>(v);
  }
  return best;
}

/// Targets at the positions of the mesh for one vertex, moved by an offset, and for the boundary.
VertexTargets one_moved(const TetMesh& mesh, Index v, const Point3& offset) {
  VertexTargets targets(mesh.points.size(), test::kFree);
  Point3& to = targets[static_cast<std::size_t>(v)];
  to = mesh.points[static_cast<std::size_t>(v)];
  for (std::size_t k = 0; k < 3; ++k) to[k] += offset[k];
  return targets;
}

void set_point(LiveMesh& live, Index v, const Point3& p) {
  const std::vector<Point3> positions{p};
  live.set_points(std::array{v}, positions);
}

std::size_t changed_tets(const TetMesh& a, const TetMesh& b) {
  std::set<std::array<Index, 4>> tets(a.tets.begin(), a.tets.end());
  return static_cast<std::size_t>(
      std::count_if(b.tets.begin(), b.tets.end(), [&](const auto& tet) { return tets.count(tet) == 0; }));
}

TEST(LiveMesh, ImprovesWhatWasDisturbedAndNothingElse) {
  const TetMesh before = optimized(12);
  LiveMesh live(before);
  EXPECT_EQ(live.optimize().tets_active, 0);
  EXPECT_EQ(live.mesh().points, before.points);
  EXPECT_EQ(live.mesh().tets, before.tets);

  const Index v = inner_vertex_near(before, {0.3, 0.3, 0.3});
  Point3 p = before.points[static_cast<std::size_t>(v)];
  p[0] += 0.02;
  p[1] -= 0.015;
  set_point(live, v, p);
  EXPECT_EQ(live.disturbed(), 1);
  const double disturbed = quality(live.mesh()).mean_ratio;
  const Report report = live.optimize();
  EXPECT_EQ(live.disturbed(), 0);
  EXPECT_GT(report.tets_bad, 0);
  EXPECT_LT(report.tets_active, static_cast<std::int64_t>(before.tets.size() / 4));
  EXPECT_GT(quality(live.mesh()).mean_ratio, disturbed);
  EXPECT_TRUE(validate(live.mesh()).ok());
  ASSERT_EQ(live.mesh().points.size(), before.points.size());
  for (std::size_t i = 0; i < before.points.size(); ++i) {
    const Point3& q = before.points[i];
    if (std::hypot(q[0] - p[0], q[1] - p[1], q[2] - p[2]) > 0.6) {
      EXPECT_EQ(live.mesh().points[i], q);
    }
  }
}

TEST(LiveMesh, MovesAVertexThroughItsNeighborhood) {
  LiveMesh live(optimized(12), {}, 2);
  const TetMesh before = live.mesh();
  const Index v = inner_vertex_near(before, {0.3, 0.4, 0.5});
  const VertexTargets targets = one_moved(before, v, {0.15, 0.05, -0.1});
  const MoveReport report = live.move(targets);
  EXPECT_TRUE(report.reached());
  EXPECT_EQ(live.mesh().points[static_cast<std::size_t>(v)], targets[static_cast<std::size_t>(v)]);
  EXPECT_TRUE(validate(live.mesh()).ok());
  EXPECT_LT(changed_tets(before, live.mesh()), before.tets.size() / 2);
  EXPECT_EQ(live.disturbed(), 0);
}

TEST(LiveMesh, ReportsAlsoWhereNothingMoves) {
  Options options;
  options.targets = {{Measure::mean_ratio, 0.9}};
  LiveMesh live(optimized(4), options, 2);
  const MoveReport report = live.move(VertexTargets(live.mesh().points.begin(), live.mesh().points.end()));
  EXPECT_TRUE(report.reached());
  EXPECT_EQ(report.optimization.device, "CPU");
  EXPECT_GT(report.optimization.threads, 0);
  ASSERT_EQ(report.optimization.targets.size(), 1U);
  EXPECT_EQ(report.optimization.targets[0].tets, std::ssize(live.mesh().tets));
}

TEST(LiveMesh, StaysAsItIsWhereNothingMoves) {
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    for (const bool is_locked : {false, true}) {
      TetMesh input = test::two_materials(4, 0.2);
      if (is_locked) input.required_tets = {0};
      Options options;
      options.boundary = boundary;
      options.effort = Effort::best;
      LiveMesh live(input, options);
      const MoveReport report = live.move(VertexTargets(input.points.begin(), input.points.end()));
      EXPECT_TRUE(report.reached());
      EXPECT_TRUE(report.steps.empty());
      EXPECT_EQ(report.prescribed, std::ssize(input.points));
      EXPECT_EQ(live.mesh().points, input.points);
      EXPECT_EQ(live.mesh().tets, input.tets);
    }
  }
}

TEST(LiveMesh, RefusesANeighborhoodOutOfRange) {
  for (const int neighborhood : {-1, 0, 101, std::numeric_limits<int>::max()}) {
    EXPECT_THROW(LiveMesh(test::cube(2), {}, neighborhood), OptionError) << neighborhood;
  }
  EXPECT_NO_THROW(LiveMesh(test::cube(2), {}, 100));
}

/// A part that is moved again, in a larger neighborhood, is a part of the same run.
TEST(LiveMesh, ItsProgressDoesNotFall) {
  LiveMesh live(optimized(8), {}, 1);
  const Index v = inner_vertex_near(live.mesh(), {0.5, 0.5, 0.5});
  double fraction = 0;
  int calls = 0;
  const Context context{[&](const Progress& p) {
                          EXPECT_GE(p.fraction, fraction);
                          fraction = p.fraction;
                          ++calls;
                          return true;
                        },
                        {}};
  live.move(one_moved(live.mesh(), v, {0.3, 0, 0}), context);
  EXPECT_GT(calls, 2);
  EXPECT_TRUE(validate(live.mesh()).ok());
}

TEST(LiveMesh, GivesTheSameBitsForAnyNumberOfThreadsOverManySteps) {
  TetMesh results[2];
  for (const int threads : {1, 3}) {
    Options options;
    options.threads = threads;
    options.effort = Effort::best;
    LiveMesh live(optimized(test::kSanitized ? 6 : 8), options);
    for (int step = 0; step < (test::kSanitized ? 4 : 6); ++step) {
      const Index v = inner_vertex_near(live.mesh(), {0.2 + 0.1 * step, 0.5, 0.5});
      if (step % 2 == 0) {
        EXPECT_TRUE(live.move(one_moved(live.mesh(), v, {0.05, 0.03, 0})).reached());
      } else {
        Point3 p = live.mesh().points[static_cast<std::size_t>(v)];
        p[2] += 0.01;
        set_point(live, v, p);
        live.optimize();
      }
    }
    results[threads == 1 ? 0 : 1] = std::move(live).release();
  }
  EXPECT_EQ(results[0].points, results[1].points);
  EXPECT_EQ(results[0].tets, results[1].tets);
  EXPECT_TRUE(validate(results[0]).ok());
}

/// Points of a cube that turns and pulsates.
std::vector<Point3> place_in_step(const std::vector<Point3>& points, int step) {
  const double angle = 0.06 * step;
  const double stretch = 1 + 0.3 * std::sin(0.2 * step);
  std::vector<Point3> places;
  for (const Point3& p : points) {
    const double x = stretch * (p[0] - 0.5);
    const double y = (p[1] - 0.5) / stretch;
    places.push_back({x * std::cos(angle) - y * std::sin(angle), x * std::sin(angle) + y * std::cos(angle), p[2]});
  }
  return places;
}

/// The sides of a cube turn and pulsate, and every third step disturbs an inner vertex too.
TEST(LiveMesh, GivesTheSameBitsForAnyNumberOfThreadsOverAHundredSteps) {
  constexpr int kSteps = test::kSanitized ? 10 : 100;
  const TetMesh first = optimized(6);
  std::vector<std::vector<Point3>> points_of_one;
  for (const int threads : {1, 3}) {
    Options options;
    options.threads = threads;
    options.boundary = Boundary::fixed;  // optimize() has no targets
    LiveMesh live(first, options);
    for (int step = 1; step <= kSteps; ++step) {
      VertexTargets targets = place_in_step(first.points, step);
      for (std::size_t v = 0; v < targets.size(); ++v) {
        if (test::is_inner(first.points[v])) targets[v] = test::kFree;
      }
      ASSERT_TRUE(live.move(targets).reached()) << "step " << step;
      if (step % 3 == 0) {
        const Index v = static_cast<Index>(100 + step);
        Point3 p = live.mesh().points[static_cast<std::size_t>(v)];
        p[2] += 1e-3;
        if (test::is_inner(first.points[static_cast<std::size_t>(v)])) set_point(live, v, p);
        live.optimize();
      }
      ASSERT_TRUE(validate(live.mesh()).ok()) << "step " << step;
      if (threads == 1) {
        points_of_one.push_back(live.mesh().points);
      } else {
        ASSERT_EQ(live.mesh().points, points_of_one[static_cast<std::size_t>(step - 1)]) << "step " << step;
      }
    }
  }
}

TEST(LiveMesh, KeepsTheNumbersOfFrozenVerticesThroughInsertions) {
  TetMesh mesh = test::cube(6, 0.25, 3);
  Options options;
  options.effort = Effort::best;
  options.max_growth = 1.5;
  options.frozen_vertices.assign(mesh.points.size(), 0);
  const Index frozen = inner_vertex_near(mesh, {0.5, 0.5, 0.5});
  options.frozen_vertices[static_cast<std::size_t>(frozen)] = 1;
  LiveMesh live(mesh, options);
  const Point3 place = mesh.points[static_cast<std::size_t>(frozen)];
  for (int step = 0; step < 3; ++step) {
    const Index v = inner_vertex_near(live.mesh(), {0.3, 0.3, 0.3});
    Point3 p = live.mesh().points[static_cast<std::size_t>(v)];
    p[0] += 0.01;
    set_point(live, v, p);
    live.optimize();
    EXPECT_EQ(live.mesh().points[static_cast<std::size_t>(frozen)], place);
    EXPECT_TRUE(validate(live.mesh()).ok());
  }
}

TEST(LiveMesh, GivesNoTagToVerticesThatAMotionHasInserted) {
  int inserted = 0;
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    TetMesh mesh = test::cube(8, 0.25, seed);
    std::fill(mesh.point_tags.begin(), mesh.point_tags.end(), 7);
    Options options;
    options.effort = Effort::best;
    options.max_growth = 1.5;
    options.restarts = 0;
    LiveMesh live(mesh, options);
    const Index v = inner_vertex_near(live.mesh(), {0.5, 0.5, 0.5});
    const Report report = live.move(one_moved(live.mesh(), v, {0.1, 0.05, 0})).optimization;
    EXPECT_LT(report.tets_active, std::ssize(mesh.tets));
    for (std::size_t i = 0; i < report.vertex2original.size(); ++i) {
      const bool is_inserted = report.vertex2original[i] < 0;
      EXPECT_EQ(live.mesh().point_tags[i], is_inserted ? 0 : 7);
      inserted += is_inserted ? 1 : 0;
    }
  }
  EXPECT_GT(inserted, 0);
}

TEST(LiveMesh, GrowsByMaxGrowthOverAllSteps) {
  const TetMesh mesh = test::cube(6, 0.25, 5);
  Options options;
  options.effort = Effort::best;
  options.max_growth = 1.05;
  options.restarts = 0;
  LiveMesh live(mesh, options);
  const std::vector<Point3> start = mesh.points;
  for (int step = 1; step <= 3; ++step) {
    VertexTargets targets(live.mesh().points.size(), test::kFree);
    for (std::size_t v = 0; v < start.size(); ++v) {
      if (test::is_inner(start[v])) continue;
      const double angle = 0.4 * std::sin(step) * start[v][2];
      const double x = start[v][0] - 0.5, y = start[v][1] - 0.5;
      targets[v] = {0.5 + std::cos(angle) * x - std::sin(angle) * y, 0.5 + std::sin(angle) * x + std::cos(angle) * y,
                    start[v][2]};
    }
    ASSERT_TRUE(live.move(targets).reached());
    // Flips are not limited.
    EXPECT_LE(live.mesh().tets.size(), 1.06 * double(mesh.tets.size())) << "step " << step;
  }
  EXPECT_GE(live.mesh().tets.size(), 1.02 * double(mesh.tets.size()));
}

TEST(LiveMesh, DoesNotWarnOfGrowthThatNoVertexMade) {
  TetMesh mesh;
  mesh.points = {{1, 0, 0}, {-0.5, 0.9, 0}, {-0.5, -0.9, 0}, {0, 0, 0.3}, {0, 0, -0.3}};
  mesh.point_tags.assign(5, 0);
  mesh.tets = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  mesh.tet_tags = {0, 0};
  LiveMesh live(mesh);
  live.optimize_all();
  ASSERT_EQ(live.mesh().tets.size(), 3U);
  EXPECT_EQ(live.optimize_all().warnings, std::vector<std::string>{});
}

TEST(LiveMesh, WidensTheNeighborhoodAndNamesWhatBlocks) {
  const TetMesh before = optimized(6);
  LiveMesh live(before, {}, 1);
  // Out of the domain, through the fixed surface.
  const Index v = inner_vertex_near(before, {0.5, 0.5, 0.5});
  const MoveReport report = live.move(one_moved(before, v, {1, 0, 0}));
  EXPECT_FALSE(report.reached());
  EXPECT_FALSE(report.blocking_tets.empty());
  for (const Index t : report.blocking_tets) EXPECT_LT(t, std::ssize(live.mesh().tets));
  EXPECT_TRUE(validate(live.mesh()).ok());
}

TEST(LiveMesh, EndsInAMeshOfTwoBodies) {
  TetMesh mesh = test::cube(3, 0.1);
  const Index first = static_cast<Index>(mesh.points.size());
  const TetMesh body = mesh;
  for (const Point3& p : body.points) mesh.points.push_back({p[0] + 3, p[1], p[2]});
  for (auto tet : body.tets) {
    for (Index& v : tet) v += first;
    mesh.tets.push_back(tet);
  }
  mesh = test::with_tags(mesh);
  LiveMesh live(mesh);
  const Index v = inner_vertex_near(mesh, {0.5, 0.5, 0.5});
  EXPECT_FALSE(live.move(one_moved(mesh, v, {1, 0, 0})).reached());
  EXPECT_TRUE(validate(live.mesh()).ok());
}

TEST(LiveMesh, MovesLockedTetrahedraAndLooseVerticesAsMoveDoes) {
  TetMesh mesh = optimized(6);
  mesh.required_tets = {0, 1, 2, 3, 4, 5};
  mesh.points.push_back({9, 9, 9});
  mesh.point_tags.push_back(0);
  VertexTargets targets(mesh.points.size(), test::kFree);
  targets.back() = {8, 8, 8};
  for (const Index v : mesh.tets[0]) {
    Point3& to = targets[static_cast<std::size_t>(v)];
    to = mesh.points[static_cast<std::size_t>(v)];
    for (double& x : to) x -= 0.01;
  }
  TetMesh whole = mesh;
  const bool reached = move(whole, targets).reached();
  LiveMesh live(mesh);
  EXPECT_EQ(live.move(targets).reached(), reached);
  EXPECT_EQ(live.mesh().points, whole.points);
  EXPECT_TRUE(validate(live.mesh()).ok());
}

TEST(LiveMesh, RefusesWhatItCannotUse) {
  TetMesh curved = test::one_tet();
  curved.curved_edges.push_back({{curved.tets[0][0], curved.tets[0][1]}, {0.3, 0.1, 0.1}});
  EXPECT_THROW(LiveMesh{curved}, MeshError);
  Options options;
  options.only_below.push_back({Measure::min_dihedral, 10});
  EXPECT_THROW(LiveMesh(test::one_tet(), options), OptionError);
  EXPECT_THROW(LiveMesh(test::one_tet(), {}, 0), OptionError);
  LiveMesh live(test::cube(3, 0.1));
  const std::vector<Point3> before = live.mesh().points;
  const std::vector<Point3> origin{{0, 0, 0}};
  const std::vector<Point3> undefined{{kNan, 0, 0}};
  EXPECT_THROW(live.set_points(std::array{Index{-1}}, origin), OptionError);
  EXPECT_THROW(live.set_points(std::array{Index{0}, Index{1}}, origin), OptionError);
  EXPECT_THROW(live.set_points(std::array{Index{0}}, undefined), OptionError);
  EXPECT_THROW(live.move(VertexTargets(2)), OptionError);
  EXPECT_THROW(live.move(VertexTargets(before.size(), test::kFree)), OptionError);
  EXPECT_EQ(live.mesh().points, before);
  EXPECT_EQ(live.disturbed(), 0);
}

}  // namespace
}  // namespace tetune

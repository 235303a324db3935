// SPDX-License-Identifier: Apache-2.0
// move(): prescribed vertices arrive to the last bit, whatever happens the mesh is valid, and the boundary is kept.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "move_fixture.hpp"
#include "support/entities.hpp"
#include "support/safe_points.hpp"
#include "support/sanitized.hpp"

namespace tetune {
namespace {

using test::expect_on_way;
using test::expect_valid;
using test::is_free;
using test::kFree;
using test::options_of;
using test::original2new;
using test::random_targets;

/// Vertices that are not prescribed stay on the sides of the unit cube that they were on, to the last bit.
void expect_sides_kept(const TetMesh& before, const TetMesh& after, const VertexTargets& target, const MoveReport& r,
                       Boundary boundary) {
  const std::vector<Index> now = original2new(r, before.points.size(), after.points.size());
  for (std::size_t v = 0; v < target.size(); ++v) {
    if (!is_free(target[v]) || now[v] < 0) continue;
    const Point3& p = after.points[to_size_t(now[v])];
    bool on_boundary = false;
    for (std::size_t k = 0; k < 3; ++k) {
      if (before.points[v][k] != 0 && before.points[v][k] != 1) continue;
      on_boundary = true;
      ASSERT_EQ(p[k], before.points[v][k]);
    }
    if (on_boundary && boundary == Boundary::fixed) {
      ASSERT_EQ(p, before.points[v]);
    }
  }
}

TEST(Move, RandomMotionsOfRandomMeshes) {
  std::mt19937 random(11);
  int reached = 0;
  int blocked = 0;
  constexpr int kMotions = test::kSanitized ? 20 : 60;
  for (int i = 0; i < kMotions; ++i) {
    const int n = 3 + i % 3;
    const TetMesh base =
        i % 2 == 0 ? test::cube(n, 0.2, static_cast<std::uint32_t>(i + 1)) : test::two_materials(4, 0.2);
    const TetMesh before = test::scrambled(base, 5, static_cast<std::uint32_t>(i));
    const Boundary boundary = i % 3 == 0 ? Boundary::fixed : Boundary::preserve;
    const VertexTargets target = random_targets(before, 0.1 + 0.2 * (i % 4), 0.12 * (1 + i % 5) / n, random);
    TetMesh after = before;
    const MoveReport r = move(after, target, options_of(i % 20 == 12 ? Effort::best : Effort::standard, boundary, 2));
    SCOPED_TRACE("motion " + std::to_string(i));
    expect_valid(after);
    expect_on_way(before, after, target, r);
    expect_sides_kept(before, after, target, r, boundary);
    EXPECT_EQ(r.fraction == 1, r.reached());
    EXPECT_EQ(r.blocking_tets.empty(), r.reached());
    EXPECT_EQ(r.blocking_vertices.empty(), r.reached());
    for (const Index v : r.blocking_vertices) EXPECT_LT(to_size_t(v), after.points.size());
    for (const Index t : r.blocking_tets) EXPECT_LT(to_size_t(t), after.tets.size());
    ++(r.reached() ? reached : blocked);
  }
  EXPECT_GT(reached, kMotions / 3);
  EXPECT_GT(blocked, kMotions / 12) << "no motion was too large";
}

TEST(Move, SameBitsForAnyNumberOfThreads) {
  std::mt19937 random(5);
  for (const Effort effort : {Effort::fast, Effort::standard, Effort::best}) {
    const int n = effort == Effort::best ? 4 : test::kSanitized ? 6 : 9;
    const TetMesh before = test::scrambled(test::cube(n, 0.2, 3), 1, 2);
    std::vector<VertexTargets> targets;
    for (int i = 0; i < 2; ++i) targets.push_back(random_targets(before, 0.2, 0.3 / n, random));
    Options options = options_of(effort, Boundary::preserve, 2);
    options.threads = 1;
    TetMesh one = before;
    const MoveReport with_one = move(one, targets, options);
    options.threads = 3;
    TetMesh three = before;
    const MoveReport with_three = move(three, targets, options);
    EXPECT_EQ(one.points, three.points);
    EXPECT_EQ(one.tets, three.tets);
    EXPECT_EQ(with_one.fraction, with_three.fraction);
    EXPECT_EQ(with_one.steps.size(), with_three.steps.size());
  }
}

/// Wherever it is stopped: the mesh is valid, and the prescribed vertices are on their way.
TEST(Move, StopsAtEverySafePoint) {
  std::mt19937 random(7);
  const TetMesh before = test::scrambled(test::cube(5, 0.2, 1), 3, 1);
  const VertexTargets target = random_targets(before, 0.3, 0.08, random);
  const Options options = options_of(Effort::standard, Boundary::preserve, 2);
  TetMesh whole = before;
  MoveReport complete;
  const int points =
      test::count_safe_points([&](const Context& context) { complete = move(whole, target, options, context); });
  ASSERT_NE(complete.optimization.stop, StopReason::cancelled);
  ASSERT_GT(points, 20);
  for (int stop = 1; stop <= points; stop += 1 + stop / 6) {
    int asked = 0;
    TetMesh m = before;
    const MoveReport r = move(m, target, options, test::stop_once_at(stop, asked));
    EXPECT_EQ(r.optimization.stop, StopReason::cancelled);
    EXPECT_TRUE(r.blocking_tets.empty());
    expect_valid(m);
    EXPECT_LE(r.fraction, 1);
    expect_on_way(before, m, target, r);
    if (stop == 1) {
      EXPECT_EQ(m.points, before.points);
      EXPECT_EQ(r.fraction, 0);
    }
  }
}

/// A piston: one side of a cube is prescribed, the opposite one stays, and the vertices of the walls slide.
TEST(Move, PistonCompressesToAFifth) {
  const TetMesh before = test::scrambled(test::cube(8, 0.2, 4), 2, 2);
  VertexTargets target(before.points.size(), kFree);
  for (std::size_t v = 0; v < target.size(); ++v) {
    const Point3& p = before.points[v];
    if (p[0] == 1) target[v] = {0.2, p[1], p[2]};
  }
  TetMesh after = before;
  const MoveReport r = move(after, target, options_of(Effort::standard, Boundary::preserve, 2));
  EXPECT_TRUE(r.reached());
  expect_valid(after);
  expect_on_way(before, after, target, r);
  expect_sides_kept(before, after, target, r, Boundary::preserve);
  EXPECT_NEAR(quality(after).volume, 0.2, 1e-12);
  EXPECT_GT(quality(after).dihedral_min, 8);
  // With walls that stay, the piston is stopped by the next layer of them.
  TetMesh fixed = before;
  const MoveReport stopped = move(fixed, target, options_of(Effort::standard, Boundary::fixed, 2));
  EXPECT_FALSE(stopped.reached());
  EXPECT_LT(stopped.fraction, 0.2);
  expect_valid(fixed);
}

/// A cube becomes ten thousand times as high: every longer step would raise the energies by too much at first.
TEST(Move, OnlyShortStepsMayRaiseEnergies) {
  TetMesh mesh = test::cube(1);
  for (Point3& p : mesh.points) p = {1e-4 * p[0], 1e-4 * p[1], 1e-4 * p[2]};
  VertexTargets target(mesh.points.begin(), mesh.points.end());
  for (Point3& p : target) p[2] = p[2] > 0 ? 1 : 0;
  const MoveReport r = move(mesh, target);
  EXPECT_TRUE(r.reached());
  ASSERT_FALSE(r.steps.empty());
  EXPECT_LT(r.steps[0].fraction, 1e-3);
  expect_valid(mesh);
}

/// Beside prescribed vertices that leave a plane, the vertices of the plane stay: they must not follow into a new
/// shape.
TEST(Move, PlanesAreNotBent) {
  const TetMesh before = test::cube(6);
  VertexTargets target(before.points.size(), kFree);
  const auto is_center = [](const Point3& p) {
    return p[2] == 1 && std::fabs(p[0] - 0.5) < 0.01 && std::fabs(p[1] - 0.5) < 0.01;
  };
  for (std::size_t v = 0; v < target.size(); ++v) {
    if (is_center(before.points[v])) target[v] = {0.5, 0.5, 1.2};
  }
  TetMesh after = before;
  const MoveReport r = move(after, target, options_of(Effort::standard, Boundary::preserve, 2));
  EXPECT_EQ(r.prescribed, 1);
  ASSERT_TRUE(r.reached());
  expect_valid(after);
  expect_sides_kept(before, after, target, r, Boundary::preserve);
  // The pyramid over the triangles around the vertex, of which those neighbors are the base.
  double area = 0;
  for (const auto& tet : before.tets) {
    std::vector<Point3> corners;
    for (const Index v : tet) {
      if (before.points[to_size_t(v)][2] == 1) corners.push_back(before.points[to_size_t(v)]);
    }
    if (corners.size() != 3 || std::none_of(corners.begin(), corners.end(), is_center)) continue;
    area += 0.5 * std::fabs((corners[1][0] - corners[0][0]) * (corners[2][1] - corners[0][1]) -
                            (corners[1][1] - corners[0][1]) * (corners[2][0] - corners[0][0]));
  }
  ASSERT_GT(area, 0);
  EXPECT_NEAR(quality(after).volume, 1 + area * 0.2 / 3, 1e-12);
}

/// A target in which all vertices turn over cannot be reached.
TEST(Move, ReportsWhatBlocks) {
  const TetMesh before = test::cube(4, 0.1);
  VertexTargets target(before.points.size(), kFree);
  for (std::size_t v = 0; v < target.size(); ++v) {
    const Point3& p = before.points[v];
    target[v] = {1 - p[0], p[1], p[2]};
  }
  TetMesh after = before;
  const MoveReport r = move(after, target, options_of(Effort::standard, Boundary::preserve, 2));
  EXPECT_FALSE(r.reached());
  EXPECT_GT(r.fraction, 0.45);
  EXPECT_LT(r.fraction, 0.5);
  EXPECT_FALSE(r.blocking_tets.empty());
  EXPECT_FALSE(r.blocking_vertices.empty());
  EXPECT_TRUE(std::is_sorted(r.blocking_tets.begin(), r.blocking_tets.end()));
  expect_valid(after);
  expect_on_way(before, after, target, r);
}

TEST(Move, DataAndTagsFollow) {
  TetMesh before = test::two_materials(4, 0.2);
  std::vector<double> values;
  for (std::size_t v = 0; v < before.points.size(); ++v) values.push_back(static_cast<double>(v));
  before.point_data.push_back({"id", 1, values});
  VertexTargets target = surface_targets(before, before.points);
  for (Point3& p : target) p[2] *= 1.5;
  TetMesh after = before;
  const MoveReport r = move(after, target);
  ASSERT_TRUE(r.reached());
  EXPECT_EQ(std::get<std::vector<double>>(after.point_data[0].values), values);
  test::expect_near_by_tag(test::region_volumes(after), {{1, 0.75}, {2, 0.75}}, 1e-12);
}

TEST(Move, ProgressReachesTheEnd) {
  TetMesh mesh = test::cube(5, 0.2);
  VertexTargets target = surface_targets(mesh, mesh.points);
  for (Point3& p : target) p[0] *= 2;
  double last = 0;
  Context context;
  context.progress = [&last](const Progress& p) {
    EXPECT_GE(p.fraction, last);
    EXPECT_LE(p.fraction, 1);
    last = p.fraction;
    return true;
  };
  EXPECT_TRUE(move(mesh, target, {}, context).reached());
  EXPECT_EQ(last, 1);
}

}  // namespace
}  // namespace tetune

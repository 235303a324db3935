// SPDX-License-Identifier: Apache-2.0
// Targets of move(): sequences of them, extreme positions, and those that are refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "math/constants.hpp"
#include "move_fixture.hpp"

namespace tetune {
namespace {

using test::expect_on_way;
using test::expect_valid;
using test::is_free;
using test::kFree;
using test::options_of;
using test::same_bits;

/// A vertex that one target prescribes stays where that left it in those that do not.
TEST(Move, SequencesOfTargets) {
  const TetMesh before = test::scrambled(test::cube(5, 0.2, 9), 1, 1);
  std::vector<VertexTargets> targets(3, VertexTargets(before.points.size(), kFree));
  std::vector<std::size_t> inner;
  for (std::size_t v = 0; v < before.points.size(); ++v) {
    if (test::is_inner(before.points[v])) inner.push_back(v);
  }
  ASSERT_GT(inner.size(), 20U);
  const auto moved = [&](std::size_t v, double by) {
    Point3 p = before.points[v];
    p[0] += by;
    return p;
  };
  targets[0][inner[0]] = moved(inner[0], 0.02);
  targets[1][inner[9]] = moved(inner[9], -0.02);
  targets[2][inner[9]] = moved(inner[9], 0.01);
  TetMesh after = before;
  const MoveReport r = move(after, targets, options_of(Effort::standard, Boundary::preserve, 2));
  EXPECT_EQ(r.prescribed, 2);
  EXPECT_EQ(r.targets_reached, 3U);
  EXPECT_TRUE(same_bits(after.points[inner[0]], targets[0][inner[0]]));
  EXPECT_TRUE(same_bits(after.points[inner[9]], targets[2][inner[9]]));
  EXPECT_EQ(r.steps.back().target, 2U);
  expect_valid(after);
}

/// A vertex on its way to a target that is not reached is not put back to the one before.
TEST(Move, ALaterTargetIsReachedInPart) {
  const TetMesh before = test::cube(4);
  const auto v = static_cast<std::size_t>(std::find(before.points.begin(), before.points.end(), Point3{0.5, 0.5, 0.5}) -
                                          before.points.begin());
  ASSERT_LT(v, before.points.size());
  std::vector<VertexTargets> targets(2, VertexTargets(before.points.size(), kFree));
  targets[0][v] = {0.6, 0.5, 0.5};
  targets[1][v] = {1.5, 0.5, 0.5};  // outside
  TetMesh after = before;
  const MoveReport r = move(after, targets, options_of(Effort::standard, Boundary::preserve, 2));
  EXPECT_EQ(r.targets_reached, 1U);
  EXPECT_GT(r.fraction, 0.2);
  EXPECT_LT(r.fraction, 0.5);
  expect_valid(after);
  EXPECT_NEAR(after.points[v][0], 0.6 + 0.9 * r.fraction, 1e-9);
}

/// Positions far smaller than the mesh, and negative zeros, keep their bits.
TEST(Move, PositionsKeepTheirBits) {
  const TetMesh base = test::cube(3);
  TetMesh before = base;
  for (Point3& p : before.points) {
    for (double& x : p) x = 1e200 * (x - 0.5);
  }
  VertexTargets target(before.points.size(), kFree);
  for (std::size_t v = 0; v < target.size(); ++v) {
    if (!test::is_inner(base.points[v])) target[v] = before.points[v];
  }
  const std::size_t v = static_cast<std::size_t>(
      std::find_if(base.points.begin(), base.points.end(), [](const Point3& p) { return test::is_inner(p); }) -
      base.points.begin());
  ASSERT_LT(v, target.size());
  target[v] = before.points[v];
  target[v][0] = -0.0;
  target[v][1] = 1e-300;
  TetMesh after = before;
  const MoveReport r = move(after, target, options_of(Effort::standard, Boundary::preserve, 2));
  ASSERT_TRUE(r.reached());
  EXPECT_TRUE(same_bits(after.points[v], target[v]));
  expect_valid(after);
}

/// Coordinates grow by orders of magnitude: the scale of the work mesh is that of the targets.
TEST(Move, FarAway) {
  const TetMesh before = test::cube(4, 0.2);
  VertexTargets target = surface_targets(before, before.points);
  for (Point3& p : target) p[1] += 1e6;
  TetMesh after = before;
  const MoveReport r = move(after, target, options_of(Effort::standard, Boundary::preserve, 2));
  EXPECT_TRUE(r.reached());
  expect_valid(after);
  expect_on_way(before, after, target, r);
}

TEST(Move, SurfaceTargets) {
  TetMesh mesh = test::two_materials(4, 0.2);
  const auto count = [](const VertexTargets& t) {
    return std::count_if(t.begin(), t.end(), [](const Point3& p) { return !is_free(p); });
  };
  const VertexTargets all = surface_targets(mesh, mesh.points);
  for (std::size_t v = 0; v < all.size(); ++v) {
    EXPECT_EQ(is_free(all[v]), test::is_inner(mesh.points[v])) << "boundary and interface";
  }
  mesh.triangles = {{mesh.tets[0][0], mesh.tets[0][1], mesh.tets[0][2]}};
  mesh.triangle_tags = {7};
  EXPECT_EQ(count(surface_targets(mesh, mesh.points, {7})), 3);
  EXPECT_THROW(surface_targets(mesh, mesh.points, {8}), OptionError);
  EXPECT_THROW(surface_targets(mesh, {}), OptionError);
}

/// move() refuses the mesh; a long list of corners, for which the mesh is examined, is not to be an error before.
TEST(SurfaceTargets, OfAnInvalidMeshDoNotDependOnTheLengthOfLists) {
  TetMesh mesh = test::cube(4);
  std::swap(mesh.tets[7][2], mesh.tets[7][3]);
  const VertexTargets without = surface_targets(mesh, mesh.points);
  for (Index v = 0; v < std::ssize(mesh.points); ++v) mesh.corners.push_back(v);
  const VertexTargets with = surface_targets(mesh, mesh.points);
  for (std::size_t v = 0; v < without.size(); ++v) EXPECT_EQ(is_free(with[v]), is_free(without[v]));
}

/// Vertices inside the mesh that its lists hold are targets, so that a translation arrives in one step.
TEST(Move, TakesInnerListedVerticesAlong) {
  constexpr int n = 6;
  TetMesh before = test::cube(n, 0.2);
  const auto inner = [&before](int i) {
    const auto distance = [&](const Point3& p) { return std::hypot(p[0] - double(i) / n, p[1] - 0.5, p[2] - 0.5); };
    const auto nearest = std::min_element(before.points.begin(), before.points.end(),
                                          [&](const Point3& p, const Point3& q) { return distance(p) < distance(q); });
    return static_cast<Index>(nearest - before.points.begin());
  };
  before.edges = {{inner(2), inner(3)}};
  before.edge_tags = {5};
  before.corners = {inner(4)};
  before.required_vertices = {inner(5)};
  VertexTargets target = surface_targets(before, before.points);
  for (const int i : {2, 3, 4, 5}) EXPECT_FALSE(is_free(span_of(target)[inner(i)])) << i;
  for (Point3& p : target) p[2] += 2;
  TetMesh after = before;
  const MoveReport r = move(after, target, options_of(Effort::standard, Boundary::preserve, 2));
  EXPECT_TRUE(r.reached());
  EXPECT_EQ(r.steps.size(), 1U);
  expect_valid(after);
  expect_on_way(before, after, target, r);

  // An exhaustive list is none of corners.
  for (std::size_t v = 0; v < before.points.size(); ++v) before.corners.push_back(static_cast<Index>(v));
  before.edges.clear();
  before.edge_tags.clear();
  before.required_vertices.clear();
  const VertexTargets surface = surface_targets(before, before.points);
  for (const int i : {2, 3, 4, 5}) EXPECT_TRUE(is_free(span_of(surface)[inner(i)])) << i;
}

TEST(Move, StopsBetweenTwoTargets) {
  TetMesh mesh = test::cube(4, 0.2);
  std::vector<VertexTargets> targets(2, surface_targets(mesh, mesh.points));
  for (Point3& p : targets[1]) p[0] += 1;
  Context context;
  context.progress = [](const Progress& p) { return p.fraction < 0.5; };
  const MoveReport r = move(mesh, targets, {}, context);
  EXPECT_EQ(r.optimization.stop, StopReason::cancelled);
  EXPECT_EQ(r.targets_reached, 1U);
  EXPECT_EQ(r.fraction, 0);
  expect_valid(mesh);
}

TEST(Move, RefusesUnusableTargets) {
  const TetMesh before = test::cube(3);
  const auto refuses = [&before](const std::vector<VertexTargets>& targets, const Options& options,
                                 const std::string& said) {
    TetMesh mesh = before;
    try {
      move(mesh, targets, options);
      ADD_FAILURE() << "accepted, though: " << said;
    } catch (const OptionError& e) {
      EXPECT_NE(std::string(e.what()).find(said), std::string::npos) << e.what();
    }
    EXPECT_EQ(mesh.points, before.points);
  };
  const VertexTargets none(before.points.size(), kFree);
  refuses({}, {}, "no target");
  refuses({none}, {}, "nothing to move");
  refuses({VertexTargets(3, kFree)}, {}, "target 1 has 3 positions for 64 vertices");
  VertexTargets half = none;
  half[5] = {kNan, 0, 0};
  refuses({before.points, half}, {}, "target 2: the position of vertex 5 is not finite");
  half[5] = {kInfinity, 0, 0};
  refuses({half}, {}, "vertex 5 is not finite");
  Options options = options_of(Effort::standard, Boundary::slide, 2);
  options.max_deviation = 0.1;
  refuses({before.points}, options, "max_deviation");
  options = {};
  options.frozen_vertices = {1, 1};
  refuses({before.points}, options, "frozen_vertices has 2 entries");
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
// move() with Boundary::slide: prescribed vertices arrive to the last bit, and the others stay on the input surface.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "math/constants.hpp"
#include "support/meshes.hpp"
#include "support/options.hpp"
#include "support/sanitized.hpp"
#include "tetune/tetune.hpp"

namespace tetune {
namespace {

using test::kFree;

constexpr int kCells = 6;

/// A cylinder of radius 1 along [0, 1] on the x axis, or rather a prism: its base has corners on the circle.
TetMesh cylinder() {
  TetMesh mesh = test::cube(kCells);
  for (Point3& p : mesh.points) {
    const double y = 2 * p[1] - 1;
    const double z = 2 * p[2] - 1;
    p = {p[0], y * std::sqrt(1 - z * z / 2), z * std::sqrt(1 - y * y / 2)};
  }
  return test::scrambled(mesh, 3, 2);
}

bool is_on_wall(const Point3& p) { return std::hypot(p[1], p[2]) > 0.97; }

/// The distance of a point from the wall of cylinder().
double from_wall(const Point3& p) {
  constexpr double kQuarter = std::numbers::pi / 2;
  const double angle = std::remainder(std::atan2(p[2], p[1]), kQuarter);
  const auto corner = [](int k) { return std::asin((2.0 * k / kCells - 1) / std::numbers::sqrt2); };
  int k = 0;
  while (k + 1 < kCells && corner(k + 1) < angle) ++k;
  const double middle = (corner(k) + corner(k + 1)) / 2;
  return std::fabs(std::hypot(p[1], p[2]) * std::cos(angle - middle) - std::cos(corner(k) - middle));
}

/// The side x = 1 is pressed to `x`; the opposite side stays.
VertexTargets piston(const TetMesh& mesh, double x) {
  VertexTargets target(mesh.points.size(), kFree);
  for (std::size_t v = 0; v < target.size(); ++v) {
    const Point3& p = mesh.points[v];
    if (p[0] == 1) target[v] = {x, p[1], p[2]};
    if (p[0] == 0) target[v] = p;
  }
  return target;
}

Options sliding(Effort effort, int threads) { return test::options_of(effort, Boundary::slide, threads); }

std::size_t original_of(const Report& r, std::size_t v) {
  return r.vertex2original.empty() ? v : static_cast<std::size_t>(r.vertex2original[v]);
}

/// Prescribed vertices are at their targets, and those of the wall on it.
void expect_arrived(const TetMesh& before, const TetMesh& after, const VertexTargets& target, const Report& r) {
  const ValidationReport valid = validate(after);
  ASSERT_TRUE(valid.ok()) << valid.message(false);
  std::size_t arrived = 0;
  for (std::size_t v = 0; v < after.points.size(); ++v) {
    const std::size_t original = original_of(r, v);
    if (original >= before.points.size()) continue;
    if (!std::isnan(target[original][0])) {
      ASSERT_EQ(after.points[v], target[original]);
      ++arrived;
    } else if (is_on_wall(before.points[original])) {
      ASSERT_LT(from_wall(after.points[v]), 1e-12);
    }
  }
  EXPECT_EQ(arrived, std::count_if(target.begin(), target.end(), [](const Point3& p) { return !std::isnan(p[0]); }));
}

TEST(SlideMove, PistonInACylinder) {
  const TetMesh before = cylinder();
  const VertexTargets target = piston(before, 0.2);
  for (const Effort effort : {Effort::fast, Effort::standard}) {
    if (test::kSanitized && effort != Effort::standard) continue;
    TetMesh after[2] = {before, before};
    MoveReport report[2];
    for (int i = 0; i < 2; ++i) report[i] = move(after[i], target, sliding(effort, 1 + 2 * i));
    EXPECT_TRUE(report[0].reached()) << report[0].fraction;
    expect_arrived(before, after[0], target, report[0].optimization);
    EXPECT_EQ(after[0].points, after[1].points);
    EXPECT_EQ(after[0].tets, after[1].tets);
    EXPECT_GT(quality(after[0]).dihedral_min, 3);
  }
}

/// Vertices that are inserted on the wall slide on it too.
TEST(SlideMove, VerticesAreInsertedOnTheWall) {
  if (test::kSanitized) GTEST_SKIP() << "too slow";
  const TetMesh before = cylinder();
  const VertexTargets target = piston(before, 0.95);
  Options options = sliding(Effort::standard, 2);
  options.surface_vertices = SurfaceVertices::edit;
  TetMesh after = before;
  const MoveReport r = move(after, target, options);
  EXPECT_TRUE(r.reached());
  expect_arrived(before, after, target, r.optimization);
  EXPECT_GT(after.points.size(), before.points.size());
}

/// Vertices of the wall that slide must not get onto the triangles that the piston takes along.
TEST(SlideMove, WhatMovesIsNoReference) {
  TetMesh before = cylinder();
  Options options = sliding(Effort::standard, 2);
  options.feature_angle = 180;  // no edge between wall and piston stops the vertices
  TetMesh after = before;
  const VertexTargets target = piston(before, 0.5);
  const MoveReport r = move(after, target, options);
  EXPECT_TRUE(r.reached());
  expect_arrived(before, after, target, r.optimization);
}

/// All calls slide on the initial surface: the wall does not shrink from step to step.
TEST(SlideMove, LiveMeshKeepsItsWall) {
  const TetMesh before = cylinder();
  std::vector<Point3> points[2];
  for (int i = 0; i < 2; ++i) {
    LiveMesh live(before, sliding(Effort::standard, 1 + 2 * i));
    std::vector<Index> originals;
    for (std::size_t v = 0; v < before.points.size(); ++v) originals.push_back(static_cast<Index>(v));
    for (const double x : {0.7, 0.4, 0.9}) {
      VertexTargets target(live.mesh().points.size(), kFree);
      const VertexTargets by_original = piston(before, x);
      for (std::size_t v = 0; v < target.size(); ++v) {
        if (originals[v] >= 0) target[v] = by_original[static_cast<std::size_t>(originals[v])];
      }
      const MoveReport r = live.move(target);
      ASSERT_TRUE(r.reached());
      if (!r.optimization.vertex2original.empty()) {
        std::vector<Index> now;
        for (const Index v : r.optimization.vertex2original) {
          now.push_back(v < 0 ? v : originals[static_cast<std::size_t>(v)]);
        }
        originals.swap(now);
      }
      Report whole;
      whole.vertex2original = originals;
      expect_arrived(before, live.mesh(), by_original, whole);
    }
    points[i] = live.mesh().points;
    Options edits = sliding(Effort::best, 1);
    edits.surface_vertices = SurfaceVertices::edit;
    LiveMesh refused(before, edits);
    EXPECT_THROW(refused.move(piston(before, 0.9)), OptionError);
  }
  EXPECT_EQ(points[0], points[1]);
}

TEST(SlideMove, RefusesABoundOnTheDeviation) {
  TetMesh mesh = cylinder();
  Options options = sliding(Effort::standard, 1);
  options.max_deviation = 0.1;
  EXPECT_THROW(move(mesh, piston(mesh, 0.9), options), OptionError);
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
// Warnings of move(): elements of other kinds that it inverts, and frozen vertices that targets move.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "driver/report/run_warnings.hpp"
#include "move_fixture.hpp"

namespace tetune {
namespace {

using test::kFree;
using test::options_of;

struct Solid {
  const char* kind;
  std::vector<Point3> points;
};

const std::vector<Solid> kSolids{
    {"Pyramids", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}}},
    {"Prisms", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}}},
    {"Hexahedra", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}}};

/// A mesh with an element for each vertex of a solid, and one more.
TetMesh beside_solids(const Solid& solid, double height) {
  TetMesh m = test::cube(2);
  const std::size_t n = solid.points.size();
  ElementBlock block{solid.kind, int(n), {}, std::vector<int>(n + 1, 0), {}};
  for (std::size_t element = 0; element <= n; ++element) {
    for (const Point3& p : solid.points) {
      block.element2vertex.push_back(Index(m.points.size()));
      m.points.push_back({p[0] + 3 + 2 * double(element), p[1], height * p[2]});
      m.point_tags.push_back(0);
    }
  }
  m.others = {block};
  return m;
}

/// Targets that push one vertex of each element but the last through it, and move the last.
VertexTargets pushed(const TetMesh& m) {
  const ElementBlock& block = m.others[0];
  const auto n = to_size_t(block.vertices_per_element);
  VertexTargets target(m.points.size(), kFree);
  for (std::size_t element = 0; element < n; ++element) {
    Point3 center{};
    for (std::size_t k = 0; k < n; ++k) {
      const Point3& p = m.points[to_size_t(block.element2vertex[n * element + k])];
      for (std::size_t x = 0; x < 3; ++x) center[x] += p[x] / double(n);
    }
    const auto vertex = to_size_t(block.element2vertex[n * element + element]);
    for (std::size_t x = 0; x < 3; ++x)
      target[vertex][x] = m.points[vertex][x] + 2.5 * (center[x] - m.points[vertex][x]);
  }
  for (std::size_t k = 0; k < n; ++k) {
    const auto vertex = to_size_t(block.element2vertex[n * n + k]);
    target[vertex] = m.points[vertex];
    target[vertex][2] += 0.25;
  }
  return target;
}

TEST(MoveWarnings, NameElementsOfOtherKindsThatTheMotionInverts) {
  for (const Solid& solid : kSolids) {
    // Files may list the vertices of all elements in the other sense.
    for (const double height : {1, -1}) {
      SCOPED_TRACE(solid.kind + std::to_string(height));
      TetMesh m = beside_solids(solid, height);
      const VertexTargets target = pushed(m);
      const MoveReport r = move(m, target, options_of(Effort::fast, Boundary::preserve, 1));
      ASSERT_TRUE(r.reached());
      ASSERT_EQ(r.inverted_others.size(), 1U);
      EXPECT_EQ(r.inverted_others[0].kind, solid.kind);
      EXPECT_EQ(r.inverted_others[0].block, 0U);
      EXPECT_EQ(r.inverted_others[0].elements, identity_map(solid.points.size()));
      const std::string first = "the motion inverted " + std::to_string(solid.points.size()) + " of the " + solid.kind;
      ASSERT_EQ(r.optimization.warnings.size(), 1U);
      EXPECT_EQ(r.optimization.warnings[0].find(first + " (first, counted from 0: 0, 1, 2, 3, 4): "), 0U);
      ASSERT_EQ(r.warnings(true).size(), 1U);
      EXPECT_EQ(r.warnings(true)[0].find(first + " (first, counted from 1: 1, 2, 3, 4, 5): "), 0U);
      EXPECT_EQ(r.warnings(false), r.optimization.warnings);
    }
  }
}

/// No memory is needed when the mesh has changed.
TEST(MoveWarnings, HaveRoomForOneOfEachBlock) {
  TetMesh m = beside_solids(kSolids[0], 1);
  m.others.resize(40, m.others[0]);
  Report report;
  RunWarnings(m, {}).add_to(report);
  EXPECT_GE(report.warnings.capacity(), report.warnings.size() + 1 + m.others.size());
}

TEST(MoveWarnings, LeaveOutElementsThatWereInvertedBefore) {
  TetMesh m = beside_solids(kSolids[1], 1);
  const VertexTargets target = pushed(m);
  move(m, target, options_of(Effort::fast, Boundary::preserve, 1));
  VertexTargets further = m.points;
  for (Point3& p : further) p[2] += 0.25;
  const MoveReport r = move(m, further, options_of(Effort::fast, Boundary::preserve, 1));
  ASSERT_TRUE(r.reached());
  EXPECT_TRUE(r.inverted_others.empty());
  EXPECT_TRUE(r.optimization.warnings.empty());
}

TEST(MoveWarnings, DoNotReadElementsWithIndicesOutOfRange) {
  TetMesh m = beside_solids(kSolids[2], 1);
  const VertexTargets target = pushed(m);
  m.others[0].element2vertex.back() = 99999;
  EXPECT_THROW(move(m, target), MeshError);
}

/// Targets that move the half x > 0.6 of the surface.
VertexTargets half_moved(const TetMesh& m) {
  VertexTargets target = surface_targets(m, m.points);
  for (Point3& p : target) {
    if (p[0] > 0.6) p[2] += 0.02;
  }
  return target;
}

TEST(MoveWarnings, CountFrozenVerticesThatTargetsMove) {
  const TetMesh before = test::two_materials(4);
  const VertexTargets target = half_moved(before);
  std::set<Index> expected;
  for (std::size_t t = 0; t < before.tets.size(); ++t) {
    if (before.tet_tags[t] != 2) continue;
    for (const Index v : before.tets[t]) {
      const Point3& p = target[to_size_t(v)];
      if (!test::is_free(p) && p != before.points[to_size_t(v)]) expected.insert(v);
    }
  }
  ASSERT_GT(expected.size(), 20U);
  Options options = options_of(Effort::fast, Boundary::preserve, 1);
  options.frozen_regions = {2};
  const std::string text = "targets move " + std::to_string(expected.size()) + " frozen vertices: ";
  TetMesh m = before;
  const MoveReport r = move(m, target, options);
  EXPECT_EQ(r.frozen_moved, std::ssize(expected));
  ASSERT_EQ(r.optimization.warnings.size(), 1U);
  EXPECT_EQ(r.optimization.warnings[0].find(text), 0U);
  options.frozen_regions = {1};
  m = before;
  EXPECT_EQ(move(m, target, options).frozen_moved, 0) << "the other half stays";
}

TEST(MoveWarnings, CountFrozenVerticesOfALiveMesh) {
  const TetMesh before = test::two_materials(6);
  VertexTargets target = half_moved(before);
  for (Point3& p : target) {
    if (p[0] < 0.9) p = kFree;
  }
  Options options = options_of(Effort::fast, Boundary::preserve, 1);
  options.frozen_vertices.resize(before.points.size(), 0);
  std::int64_t expected = 0;
  for (std::size_t v = 0; v < target.size(); ++v) {
    options.frozen_vertices[v] = v % 2 == 0 ? 1 : 0;
    if (v % 2 == 0 && !test::is_free(target[v])) ++expected;
  }
  ASSERT_GT(expected, 5);
  LiveMesh live(before, options, 1);
  const MoveReport r = live.move(target);
  EXPECT_EQ(r.frozen_moved, expected);
  EXPECT_EQ(r.optimization.warnings, r.warnings(false));
}

}  // namespace
}  // namespace tetune

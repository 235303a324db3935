// SPDX-License-Identifier: Apache-2.0
// A vertex moved to where the largest cost of the angles around it is lowest, on stars with known optima.
#include "relocation/angle_cost_ring.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "support/meshes.hpp"
#include "support/work.hpp"
#include "tetune/quality.hpp"

namespace tetune {
namespace {

bool minimize(const AngleCostRing& ring, Vec3& x, const MotionSpace& space, double target_cot) {
  FreeMotion motion{space};
  MinimaxModel model;
  return ring.minimize(x, motion, target_cot, model);
}

TEST(AngleCostRing, IncreasesTheSmallestAngle) {
  TetMesh m;
  m.points = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}, {-0.3, -0.3, -0.3}};
  m.tets = {{4, 1, 3, 2}, {0, 4, 3, 2}, {0, 1, 3, 4}, {0, 1, 4, 2}};
  m = test::with_tags(m);
  test::CpuMesh work = test::to_work(m);
  const LinkFace faces[4] = {{{1, 3, 2}}, {{0, 2, 3}}, {{0, 3, 1}}, {{0, 1, 2}}};
  const AngleCostRing ring(rated(work, {kShapeObjective}), faces, 4, FloorRule::kept);
  int first = 0;
  Vec3 x = vec(m.points[4]);
  const double before = ring.largest_cost(x, 1e300, first);
  EXPECT_NEAR(before, 1 / std::tan(quality(m).dihedral_min * std::numbers::pi / 180), 1e-9);
  ASSERT_TRUE(minimize(ring, x, {VertexDof::free, {}}, 0));
  // The angles of all four tetrahedra are equal in the middle only.
  EXPECT_NEAR(norm(x), 0, 0.05);
  // The search ends where the target is reached.
  Vec3 y = vec(m.points[4]);
  ASSERT_TRUE(minimize(ring, y, {VertexDof::free, {}}, 0.9 * before));
  const double reached = ring.largest_cost(y, 1e300, first);
  EXPECT_LE(reached, 0.9 * before);
  EXPECT_GT(reached, 1.1 * ring.largest_cost(x, 1e300, first));
  // Within a plane and along a line.
  Vec3 z = vec(m.points[4]);
  ASSERT_TRUE(minimize(ring, z, {VertexDof::plane, {0, 0, 1}}, 0));
  EXPECT_EQ(z.z, m.points[4][2]);
  z = vec(m.points[4]);
  ASSERT_TRUE(minimize(ring, z, {VertexDof::line, {0, 1, 0}}, 0));
  EXPECT_EQ(z.x, m.points[4][0]);
  EXPECT_EQ(z.z, m.points[4][2]);
  z = vec(m.points[4]);
  EXPECT_FALSE(minimize(ring, z, {VertexDof::fixed, {}}, 0));
}

/// The vertices of a regular icosahedron, and its center as the last one.
TetMesh icosahedron() {
  const double golden = 0.5 * (1 + std::sqrt(5.0));
  TetMesh m;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-golden, golden}) {
      m.points.push_back({0, a, b});
      m.points.push_back({a, b, 0});
      m.points.push_back({b, 0, a});
    }
  }
  m.points.push_back({0, 0, 0});
  return m;
}

/// Its faces, so that a tetrahedron between the center and each is positive.
std::vector<LinkFace> faces_of(const TetMesh& m) {
  std::vector<Vec3> p;
  for (const Point3& point : m.points) p.push_back(vec(point));
  const auto are_neighbors = [&](std::size_t a, std::size_t b) { return norm(p[a] - p[b]) < 2.1; };
  std::vector<LinkFace> faces;
  for (std::size_t a = 0; a < 12; ++a) {
    for (std::size_t b = a + 1; b < 12; ++b) {
      for (std::size_t c = b + 1; c < 12; ++c) {
        if (!are_neighbors(a, b) || !are_neighbors(b, c) || !are_neighbors(a, c)) continue;
        const bool is_positive = orient(p[12], p[a], p[b], p[c]).det > 0;
        faces.push_back({{Index(a), Index(is_positive ? b : c), Index(is_positive ? c : b)}});
      }
    }
  }
  return faces;
}

TEST(AngleCostRing, TheFloorOnMeanRatiosHoldsPerLane) {
  TetMesh m = icosahedron();
  const std::vector<LinkFace> faces = faces_of(m);
  ASSERT_EQ(faces.size(), 20U);
  for (const LinkFace& f : faces) m.tets.push_back({12, f.v[0], f.v[1], f.v[2]});
  m = test::with_tags(m);
  test::CpuMesh work = test::to_work(m);
  const Vec3 x{0.3, 0.2, -0.4};
  std::vector<double> terms;
  for (const LinkFace& f : faces) {
    const Vec3 p[4] = {x, vec(work.points.span()[f.v[0]]), vec(work.points.span()[f.v[1]]),
                       vec(work.points.span()[f.v[2]])};
    terms.push_back(edge_term(p, orient_det(p)));
  }
  std::vector<double> sorted = terms;
  std::sort(sorted.begin(), sorted.end());
  QualityFloor floor = QualityFloor::none();
  floor.max_edge_term = sorted[9];
  floor.limit_angles(floor.extremes());  // updates what follows from it
  const AngleCostRing ring(rated(work, {kShapeObjective, floor, 1.5}), faces.data(), 20, FloorRule::ignored);
  int mixed = 0;
  for (int begin = 0; begin < 20; begin += 4) {
    const auto costs = ring.costs_of<backend::Pack4>(x, begin);
    int allowed = 0;
    for (int lane = 0; lane < 4; ++lane) {
      const bool is_allowed = terms[static_cast<std::size_t>(begin + lane)] <= floor.max_edge_term;
      EXPECT_EQ(costs[lane] < HUGE_VAL, is_allowed);
      EXPECT_EQ(costs[lane], ring.costs_of<double>(x, begin + lane));
      allowed += is_allowed ? 1 : 0;
    }
    mixed += allowed > 0 && allowed < 4 ? 1 : 0;
  }
  EXPECT_GT(mixed, 0);
}

TEST(AngleCostRing, TheLargestCostsTakePartWhereThereAreMoreThanAModelHasRoomFor) {
  TetMesh m = icosahedron();
  std::vector<LinkFace> faces = faces_of(m);
  ASSERT_EQ(faces.size(), 20U);
  for (const LinkFace& f : faces) m.tets.push_back({12, f.v[0], f.v[1], f.v[2]});
  // One vertex is near the center: the five faces there, the last ones, have the largest costs.
  for (double& coordinate : m.points[0]) coordinate *= 0.6;
  std::stable_partition(faces.begin(), faces.end(), [](const LinkFace& f) { return f.v[0] != 0; });
  m = test::with_tags(m);
  test::CpuMesh work = test::to_work(m);
  const AngleCostRing ring(rated(work, {kShapeObjective, QualityFloor::none(), 1.5}), faces.data(), 20,
                           FloorRule::ignored);
  int first = 0;
  Vec3 x{0, 0, 0};
  const double before = ring.largest_cost(x, kInfeasible, first);
  ASSERT_TRUE(minimize(ring, x, {VertexDof::free, {}}, 0));
  EXPECT_LT(ring.largest_cost(x, kInfeasible, first), 0.9 * before);
  EXPECT_LT(dot(x, vec(m.points[0])), 0);
}

}  // namespace
}  // namespace tetune

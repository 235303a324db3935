// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "operators/flips/flip_pass.hpp"
#include "support/boundary_flip_fixture.hpp"
#include "support/meshes.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

using backend::Cpu;
using test::BoundaryFlips;
using test::fan;
using test::fan_polygon;
using test::least_energy;

TEST(BoundaryFlip, FindsTheBestOfAllTriangulations) {
  for (int n = 2; n < kMaxRing; ++n) {
    int flipped = 0;
    int left = 0;
    for (std::uint32_t seed = 1; seed <= 600; ++seed) {
      const TetMesh m = fan(n, seed);
      if (!validate(m).ok()) continue;
      BoundaryFlips f(m);
      const double best = least_energy(m, fan_polygon(n));
      const bool expected = best < f.energy * (1 - kMinRelativeGain);
      const PassResult r = f.pass();
      EXPECT_EQ(r.active, 1);
      EXPECT_EQ(r.counts.boundary_flips, expected ? 1 : 0);
      EXPECT_EQ(r.counts.flips(), r.counts.boundary_flips);
      ++(expected ? flipped : left);
      if (!expected) continue;
      EXPECT_NEAR(r.decrease, f.energy - best, 1e-12 * f.energy);
      EXPECT_EQ(f.work.tets(), 2 * (n - 1));
      f.energy -= r.decrease;
      f.expect_consistent();
      EXPECT_EQ(f.pass().counts.flips(), 0);
    }
    EXPECT_GT(flipped, 10) << n;
    if (n > 2) {
      EXPECT_GT(left, 100) << n;
    }
  }
}

/// One whose flip is worth it.
TetMesh flippable_fan(int n) {
  TetMesh m;
  for (std::uint32_t seed = 1; seed < 1000; ++seed) {
    m = fan(n, seed);
    if (validate(m).ok() && BoundaryFlips(m).pass().counts.flips() == 1) break;
  }
  return m;
}

TEST(BoundaryFlip, StopsAtTheLargestRingAllowed) {
  BoundaryFlips f(flippable_fan(4));
  f.state.max_ring = 4;
  EXPECT_EQ(f.pass().evaluated, 0);
  f.state.max_ring = 5;
  EXPECT_EQ(f.pass().counts.boundary_flips, 1);
}

TEST(BoundaryFlip, EvaluatesOnlyAroundActiveVertices) {
  BoundaryFlips f(flippable_fan(2));
  f.active.assign(f.active.size(), 1);
  f.active[0] = f.active[1] = 0;
  EXPECT_EQ(f.pass().active, 0);
  f.active[1] = 1;
  EXPECT_EQ(f.pass().counts.boundary_flips, 1);
  EXPECT_EQ(f.active[0], 1);
}

TEST(BoundaryFlip, LeavesAFoldAlone) {
  std::uint32_t seed = 1;
  while (seed < 1000 && (!validate(fan(2, seed)).ok() || BoundaryFlips(fan(2, seed)).pass().counts.flips() == 0))
    ++seed;
  EXPECT_EQ(BoundaryFlips(fan(2, seed, 1e-7)).pass().active, 1);
  EXPECT_EQ(BoundaryFlips(fan(2, seed, 1e-5)).pass().active, 0);
  EXPECT_EQ(BoundaryFlips(fan(2, seed, -1e-5)).pass().active, 0);
}

TEST(BoundaryFlip, LeavesWhatMustStay) {
  const TetMesh m = flippable_fan(2);
  const std::array<Index, 3> first{0, 1, 2};
  const std::array<Index, 3> second{0, 1, 4};
  const auto flips = [](TetMesh mesh, const std::vector<std::array<Index, 3>>& triangles, std::vector<int> tags) {
    mesh.triangles = triangles;
    mesh.triangle_tags = std::move(tags);
    return BoundaryFlips(mesh).pass().counts.flips();
  };
  EXPECT_EQ(flips(m, {first, second}, {7, 7}), 1);
  EXPECT_EQ(flips(m, {first, second}, {0, 0}), 1);
  EXPECT_EQ(flips(m, {first, second}, {7, 8}), 0);
  EXPECT_EQ(flips(m, {first, second}, {7, 0}), 0);
  EXPECT_EQ(flips(m, {first}, {7}), 0);
  EXPECT_EQ(flips(m, {first}, {0}), 0);
  EXPECT_EQ(flips(m, {first, second, first}, {7, 7, 7}), 0);
  // A frozen triangle has three frozen vertices.
  EXPECT_EQ(BoundaryFlips(m, {0, 1, 2}).pass().counts.flips(), 0);
  EXPECT_EQ(BoundaryFlips(m, {0, 1, 4}).pass().counts.flips(), 0);
  EXPECT_EQ(BoundaryFlips(m, {0, 1}).pass().counts.flips(), 1);
  EXPECT_EQ(BoundaryFlips(m, {}, {{0, 1}}).pass().counts.flips(), 0);
  EXPECT_EQ(BoundaryFlips(m, {}, {{0, 2}}).pass().counts.flips(), 1);
  TetMesh two = m;
  two.tet_tags = {1, 2};
  EXPECT_EQ(BoundaryFlips(two).pass().counts.flips(), 0);
  two.tet_tags = {5, 5};
  BoundaryFlips f(two);
  EXPECT_EQ(f.pass().counts.flips(), 1);
  EXPECT_EQ(f.result().tet_tags, (std::vector<int>{5, 5}));
}

TEST(BoundaryFlip, IsRefusedWhereTheQuadrangleIsNotConvex) {
  TetMesh m;
  m.points = {{0, -20, 0}, {0, 0, 0}, {-1, 0.02, 0}, {0, -1, 1}, {1, 0.02, 0}};
  m.tets = {{0, 2, 3, 1}, {0, 3, 4, 1}};
  ASSERT_TRUE(validate(test::with_tags(m)).ok());
  BoundaryFlips f(test::with_tags(m));
  EXPECT_EQ(f.pass().active, 1);
  EXPECT_EQ(f.pass().counts.flips(), 0);
}

TEST(BoundaryFlip, EdgesCloseToDelaunayAreNotEvaluated) {
  // The angles opposite the edge are a right one and one of atan(1 / s), so that their cotangents add up to s.
  for (const double s : {0.25, 0.35}) {
    TetMesh m;
    m.points = {{0, -1, 0}, {0, 1, 0}, {-1, 0, 0}, {0, 0, 1}, {0, 0, 0}};
    m.points[4] = {s + std::sqrt(s * s + 1), 0, 0};
    m.tets = {{0, 2, 3, 1}, {0, 3, 4, 1}};
    ASSERT_TRUE(validate(test::with_tags(m)).ok());
    BoundaryFlips f(test::with_tags(m));
    EXPECT_EQ(f.pass().active, s < 0.3 ? 1 : 0);
  }
}

TEST(BoundaryFlip, ListedTrianglesFollowAndTurnAsTheyDid) {
  for (const bool turned : {false, true}) {
    TetMesh m = flippable_fan(2);
    m.triangles = {{0, 1, 3}, {1, 0, 2}, {0, 1, 4}};  // the first is inside
    if (turned) std::swap(m.triangles[1][0], m.triangles[1][2]);
    m.triangle_tags = {0, 7, 7};
    BoundaryFlips f(m);
    EXPECT_EQ(f.listed_now(m), m.triangles);
    const auto before = f.faces();
    EXPECT_EQ(before.count(BoundaryFlips::from_lowest(m.triangles[1])), turned ? 0U : 1U);
    EXPECT_EQ(before.count(BoundaryFlips::from_lowest(m.triangles[2])), 1U);
    EXPECT_EQ(f.pass().counts.flips(), 1);
    const auto listed = f.listed_now(m);
    const auto after = f.faces();
    EXPECT_EQ(listed[0], m.triangles[0]);
    for (std::size_t i : {1U, 2U}) {
      std::set<Index> vertices(listed[i].begin(), listed[i].end());
      EXPECT_TRUE(vertices.count(2) == 1 && vertices.count(4) == 1) << i;
    }
    EXPECT_NE(std::set<Index>(listed[1].begin(), listed[1].end()), std::set<Index>(listed[2].begin(), listed[2].end()));
    EXPECT_EQ(after.count(BoundaryFlips::from_lowest(listed[1])), turned ? 0U : 1U);
    EXPECT_EQ(after.count(BoundaryFlips::from_lowest(listed[2])), 1U);
  }
}

/// Passes of both kinds on a mesh whose vertices have moved within its sides, for several numbers of threads.
void check_passes(const TetMesh& mesh) {
  std::set<std::vector<std::array<Index, 4>>> results;
  for (const int threads : {1, 2, 3}) {
    BoundaryFlips f(mesh, {}, {}, threads);
    Size flips = 0;
    for (int round = 0; round < 5; ++round) {
      const PassResult r = f.pass();
      flips += r.counts.flips();
      f.energy -= r.decrease;
      f.expect_consistent();
      // First the active tetrahedra near flips are examined, then all around them.
      std::vector<std::uint8_t> flipped(f.active.size(), 1);
      do {
        const Span<std::uint8_t> flags(flipped.data(), static_cast<Size>(flipped.size()));
        for (Size more = 1; more > 0;) {
          const PassResult inside = flip_pass(f.cpu, f.work, f.criterion, f.state, flags);
          more = inside.counts.flips();
          f.energy -= inside.decrease;
        }
        activate_around(f.cpu, f.work, f.state, Span<const std::uint8_t>(flags));
        std::fill(flipped.begin(), flipped.end(), std::uint8_t{0});
      } while (f.state.active.size() > 0);
      f.expect_consistent();
    }
    EXPECT_GT(flips, 100);
    EXPECT_EQ(f.pass().counts.flips(), 0);
    // None is left.
    activate_all(f.cpu, f.work, f.criterion, f.state);
    EXPECT_EQ(flip_pass(f.cpu, f.work, f.criterion, f.state, {}).counts.flips(), 0);
    results.insert(f.result().tets);
  }
  EXPECT_EQ(results.size(), 1U);
}

TEST(BoundaryFlip, PassesKeepAllConsistent) {
  check_passes(test::sheared(test::scrambled(test::cube(12, 0.2, 3), 3, 3), 1.2));
}

TEST(BoundaryFlip, PassesKeepInterfacesConsistent) {
  const TetMesh mesh = test::sheared(test::two_materials(12, 0.2), 1.2);
  const auto before = BoundaryFlips(mesh).inner_faces();
  BoundaryFlips f(mesh);
  f.pass();
  EXPECT_NE(f.inner_faces(), before);
  EXPECT_EQ(f.inner_faces().size(), before.size());
  check_passes(mesh);
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <stdexcept>

#include "mesh/tet.hpp"
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

/// fan() of n tetrahedra of region 1 above the plane, and one of `below` of region 2 under it about the same edge.
TetMesh two_fans(int n, int below, std::uint32_t seed) {
  TetMesh m = fan(n, seed);
  const TetMesh other = fan(below, seed + 1000);
  std::vector<Index> polygon{static_cast<Index>(n + 2)};
  for (std::size_t i = 1; i < static_cast<std::size_t>(below); ++i) {
    const Point3& p = other.points[2 + i];
    polygon.push_back(static_cast<Index>(m.points.size()));
    m.points.push_back({-p[0], p[1], -p[2]});
  }
  polygon.push_back(2);
  m.tet_tags.assign(m.tets.size(), 1);
  for (std::size_t i = 0; i + 1 < polygon.size(); ++i) {
    m.tets.push_back({0, polygon[i], polygon[i + 1], 1});
    m.tet_tags.push_back(2);
  }
  return test::with_tags(m);
}
std::vector<Index> polygon_below(int n, int below) {
  std::vector<Index> polygon{static_cast<Index>(n + 2)};
  for (Index v = 0; v + 1 < below; ++v) polygon.push_back(static_cast<Index>(n + 3 + v));
  polygon.push_back(2);
  return polygon;
}

TEST(InterfaceFlip, FindsTheBestOnBothSidesOfAnInterface) {
  for (const auto& [n, below] : {std::pair{2, 2}, {2, 3}, {4, 2}, {3, 5}, {6, 6}}) {
    int flipped = 0;
    int left = 0;
    int losing_side = 0;
    for (std::uint32_t seed = 1; seed <= 600; ++seed) {
      const TetMesh m = two_fans(n, below, seed);
      if (!validate(m).ok()) continue;
      BoundaryFlips f(m);
      const double above = least_energy(m, fan_polygon(n));
      const double best = above + least_energy(m, polygon_below(n, below));
      const bool expected = best < f.energy * (1 - kMinRelativeGain);
      const PassResult r = f.pass();
      EXPECT_EQ(r.active, 1);
      EXPECT_EQ(r.counts.boundary_flips, expected ? 1 : 0);
      ++(expected ? flipped : left);
      if (!expected) continue;
      double above_before = 0;
      for (int t = 0; t < n; ++t) above_before += BoundaryFlips(m).state.energies.span()[t];
      losing_side += above > above_before || best - above > f.energy - above_before ? 1 : 0;
      EXPECT_NEAR(r.decrease, f.energy - best, 1e-12 * f.energy);
      EXPECT_EQ(f.work.tets(), 2 * (n - 1) + 2 * (below - 1));
      f.energy -= r.decrease;
      f.expect_consistent();
      const TetMesh after = f.result();
      EXPECT_EQ(std::count(after.tet_tags.begin(), after.tet_tags.end(), 1), 2 * (n - 1));
      EXPECT_EQ(f.pass().counts.flips(), 0);
    }
    EXPECT_GT(flipped, 10) << n << below;
    if (n + below > 4) {
      EXPECT_GT(left, 50) << n << below;
    }
    if (n == 2 && below == 3) {
      EXPECT_GT(losing_side, 0);
    }
  }
}

/// two_fans() of two tetrahedra each, which a flip improves.
TetMesh two_fans_that_flip() {
  for (std::uint32_t seed = 1; seed < 1000; ++seed) {
    TetMesh m = two_fans(2, 2, seed);
    if (validate(m).ok() && BoundaryFlips(m).pass().counts.flips() > 0) return m;
  }
  throw std::logic_error("no seed gives such a mesh");
}

TEST(InterfaceFlip, TrianglesOfAnInterfaceTurnAsTheyDid) {
  for (const bool turned : {false, true}) {
    TetMesh m = two_fans_that_flip();
    m.triangles = {{0, 1, 2}, {0, 1, 4}};  // they turn in opposite senses
    if (turned) std::swap(m.triangles[0], m.triangles[1]);
    m.triangle_tags = {7, 7};
    BoundaryFlips f(m);
    EXPECT_EQ(f.listed_now(m), m.triangles);
    EXPECT_EQ(f.pass().counts.flips(), 1);
    const auto listed = f.listed_now(m);
    for (std::size_t i = 0; i < 2; ++i) {
      const auto normal = [&m](const std::array<Index, 3>& t) {
        return cross(test::at(m, t[1]) - test::at(m, t[0]), test::at(m, t[2]) - test::at(m, t[0])).z;
      };
      EXPECT_GT(normal(listed[i]) * normal(m.triangles[i]), 0);
      EXPECT_EQ(f.inner_faces().count(ascending(listed[i])), 1U);
    }
  }
}

TEST(InterfaceFlip, LeavesAnInterfaceAloneWhereItsTagsDiffer) {
  TetMesh m = two_fans_that_flip();
  m.triangles = {{0, 1, 2}, {0, 1, 4}};
  m.triangle_tags = {7, 8};
  EXPECT_EQ(BoundaryFlips(m).pass().counts.flips(), 0);
  m.triangle_tags = {7, 7};
  EXPECT_EQ(BoundaryFlips(m).pass().counts.flips(), 1);
  EXPECT_EQ(BoundaryFlips(m, {0, 1, 2}).pass().counts.flips(), 0);
  EXPECT_EQ(BoundaryFlips(m, {}, {{0, 1}}).pass().counts.flips(), 0);
  m.tet_tags[1] = 3;  // a third region
  EXPECT_EQ(BoundaryFlips(m).pass().counts.flips(), 0);
}

}  // namespace
}  // namespace tetune

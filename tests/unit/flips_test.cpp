// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "flips/flip_pass.hpp"
#include "meshes.hpp"
#include "tetune/validate.hpp"
#include "work.hpp"

namespace tetune {
namespace {

using par::Cpu;

struct Fixture {
  test::CpuMesh work;
  FlipState<Cpu> state;
  Cpu cpu{1};
  double energy = 0;
  explicit Fixture(const TetMesh& mesh, const std::vector<std::array<Index, 2>>& constrained = {})
      : work(test::to_work(mesh)) {
    build_adjacency(cpu, work);
    lock_interfaces(cpu, work);
    std::vector<std::uint64_t> keys;
    std::vector<std::uint8_t> on_vertex(mesh.points.size(), 0);
    for (const auto& e : constrained) {
      keys.push_back(ConstrainedEdges::edge_key(e[0], e[1]));
      for (const Index v : e) on_vertex[static_cast<std::size_t>(v)] = 1;
    }
    std::sort(keys.begin(), keys.end());
    state.constrained_keys.upload(keys);
    state.constrained_vertex.upload(on_vertex);
    energy = refresh_energy(cpu, work, state);
    activate_all(cpu, work, state);
  }
  FlipReport pass() { return flip_pass(cpu, work, state, {}); }
  void expect_consistent() {
    EXPECT_EQ(test::check_links(work), "");
    const TetMesh mesh = test::from_work(work);
    const ValidationReport report = validate(mesh);
    EXPECT_TRUE(report.ok()) << report.message(false);
  }
};

TEST(Flip, TwoFlatTetsBecomeThreeAroundTheNewEdge) {
  Fixture f(test::two_tets(0.3));
  const FlipReport r = f.pass();
  EXPECT_EQ(r.flips23, 1);
  EXPECT_EQ(r.flips32, 0);
  EXPECT_EQ(r.evaluated, 1);
  EXPECT_NEAR(r.decrease, 37.758707605001526 - 23.902301144450508, 1e-10);
  EXPECT_EQ(f.work.tets(), 3);
  f.expect_consistent();
  for (Size t = 0; t < 3; ++t) {
    const Tet tet = f.work.tet2vertex.span()[t];
    EXPECT_TRUE(tet[local_index(tet, 0)] == 0 && tet[local_index(tet, 1)] == 1);
  }
  EXPECT_EQ(f.pass().flips23 + f.pass().flips32, 0);
}

TEST(Flip, ThreeTetsAroundALongEdgeBecomeTwo) {
  Fixture f(test::three_tets(1));
  const FlipReport r = f.pass();
  EXPECT_EQ(r.flips32, 1);
  EXPECT_EQ(r.flips23, 0);
  EXPECT_NEAR(r.decrease, 40.2701812759764 - 20.784609690826525, 1e-10);
  EXPECT_EQ(f.work.tets(), 2);
  EXPECT_EQ(f.work.free_count, 1);
  f.expect_consistent();
}

TEST(Flip, LeavesTheBetterOfTheTwoAlone) {
  EXPECT_EQ(Fixture(test::two_tets(1)).pass().flips23, 0);
  EXPECT_EQ(Fixture(test::three_tets(0.3)).pass().flips32, 0);
  // At height 1/2 both are equal but for rounding: neither is taken for better.
  EXPECT_EQ(Fixture(test::two_tets(0.5)).pass().flips23, 0);
  EXPECT_EQ(Fixture(test::three_tets(0.5)).pass().flips32, 0);
}

TEST(Flip, NeverCrossesAnInterface) {
  TetMesh two = test::two_tets(0.3);
  two.tet_tags = {1, 2};
  EXPECT_EQ(Fixture(two).pass().flips23, 0);
  TetMesh three = test::three_tets(1);
  three.tet_tags = {1, 1, 2};
  EXPECT_EQ(Fixture(three).pass().flips32, 0);
}

TEST(Flip, LeavesAConstrainedEdgeAlone) {
  EXPECT_EQ(Fixture(test::three_tets(1), {{0, 1}}).pass().flips32, 0);
  EXPECT_EQ(Fixture(test::three_tets(1), {{0, 2}}).pass().flips32, 1);
}

TEST(Flip, IsRefusedWhereTheRegionIsNotConvex) {
  TetMesh m = test::two_tets(0.3);
  m.points[0][0] = 3;  // the edge (0, 1) now passes outside the triangle
  m.points[0][2] = 0.2;
  Fixture f(m);
  EXPECT_EQ(f.pass().flips23, 0);
}

TEST(Flip, FreedSlotsAreUsedAgain) {
  // Two separate pairs: one frees a slot, the other takes it in a later pass.
  TetMesh m = test::three_tets(1);
  const TetMesh other = test::two_tets(0.3);
  for (Point3 p : other.points) m.points.push_back({p[0] + 10, p[1], p[2]});
  for (auto t : other.tets) {
    for (Index& v : t) v += 5;
    m.tets.push_back(t);
  }
  Fixture f(test::with_tags(m));
  const FlipReport r = f.pass();
  EXPECT_EQ(r.flips23, 1);
  EXPECT_EQ(r.flips32, 1);
  EXPECT_EQ(f.work.tets(), 5);
  f.expect_consistent();
}

TEST(FlipPass, KeepsLinksEnergyAndValidityOnScrambledCubes) {
  Size flips23 = 0;
  for (const std::uint32_t seed : {1U, 2U, 3U, 4U}) {
    // Sheared, what was a good flip no longer is one: flips of both kinds.
    Fixture f(test::sheared(test::scrambled(test::cube(6, 0.2, seed), 3, seed), seed % 2 == 0 ? 2.5 : 0));
    double energy = f.energy;
    Size flips = 0;
    Size f23 = 0;
    for (int pass = 0; pass < 50; ++pass) {
      const FlipReport r = f.pass();
      energy -= r.decrease;
      flips += r.flips23 + r.flips32;
      f23 += r.flips23;
      f.expect_consistent();
      EXPECT_EQ(f.work.tets(), static_cast<Size>(test::from_work(f.work).tets.size()));
      EXPECT_NEAR(refresh_energy(f.cpu, f.work, f.state), energy, 1e-9 * energy);
      if (r.flips23 + r.flips32 == 0) break;
      EXPECT_GT(r.decrease, 0);
    }
    flips23 += f23;
    EXPECT_GT(flips, 500);
    // The active sets missed nothing: a full look finds no flip either.
    activate_all(f.cpu, f.work, f.state);
    EXPECT_EQ(f.pass().flips23 + f.pass().flips32, 0);
  }
  EXPECT_GT(flips23, 10);
}

}  // namespace
}  // namespace tetune

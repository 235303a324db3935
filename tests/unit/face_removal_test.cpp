// SPDX-License-Identifier: Apache-2.0
// Faces removed together: a tiny mesh with exact figures, all subsets of small clusters as the oracle, whole meshes.
#include "operators/flips/face_removal.hpp"

#include <gtest/gtest.h>

#include <map>
#include <numbers>
#include <random>

#include "operators/flips/face_cluster.hpp"
#include "support/flip_fixture.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"

namespace tetune {
namespace {

using backend::Cpu;
using Fixture = test::FlipFixture;
using Triangle = std::array<Index, 3>;

PassResult remove_faces(Fixture& f) { return face_removal_pass(f.cpu, f.work, f.criterion, f.state, {}); }

/// Vertices 0 and 1 below and above a polygon that is divided into triangles of its corners, numbered from 0.
TetMesh sandwich(const std::vector<Point3>& ring, double height, const std::vector<Triangle>& triangles) {
  TetMesh m;
  m.points = {{0, 0, -height}, {0, 0, height}};
  m.points.insert(m.points.end(), ring.begin(), ring.end());
  for (const auto& [i, j, k] : triangles) {
    m.tets.push_back({0, i + 2, j + 2, k + 2});
    m.tets.push_back({1, i + 2, k + 2, j + 2});
  }
  return test::with_tags(m);
}

TetMesh pentagon(double height) {
  std::vector<Point3> ring;
  for (int i = 0; i < 5; ++i)
    ring.push_back({std::cos(2 * std::numbers::pi * i / 5), std::sin(2 * std::numbers::pi * i / 5), 0});
  return sandwich(ring, height, {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}});
}

/// Triangles at random, around an edge that need not be inside.
TetMesh random_sandwich(int n, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto uniform = [&random] { return test::uniform(random); };
  std::vector<Point3> ring;
  const double beside = 1.2 * uniform();
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.5 * uniform()) / n;
    const double radius = 0.7 + 0.6 * uniform();
    ring.push_back({radius * std::cos(angle) + beside, radius * std::sin(angle), 0.4 * uniform() - 0.2});
  }
  std::vector<Index> open(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) open[static_cast<std::size_t>(i)] = i;
  std::vector<Triangle> triangles;
  while (open.size() > 2) {  // an ear at random
    const std::size_t ear = random() % open.size();
    Triangle t{open[ear], open[(ear + 1) % open.size()], open[(ear + 2) % open.size()]};
    open.erase(open.begin() + static_cast<std::ptrdiff_t>((ear + 1) % open.size()));
    triangles.push_back(t);
  }
  return sandwich(ring, 0.4 + 2 * uniform(), triangles);
}

/// Plain oracle: what the best connected set of triangles with this one would change, kInfeasible where none may go.
double best_change(const TetMesh& m, std::size_t root) {
  const auto p = [&m](Index v) { return vec(m.points[static_cast<std::size_t>(v)]); };
  const auto energy = [&](Index a, Index b, Index c, Index d) {
    const TetEnergy e = tet_energy(kHarmonicObjective, p(a), p(b), p(c), p(d));
    return e.certified ? e.energy : kInfeasible;
  };
  const std::size_t count = m.tets.size() / 2;
  double best = kInfeasible;
  for (unsigned set = 0; set < 1U << count; ++set) {
    if ((set >> root & 1U) == 0) continue;
    // Sides that no other triangle of the set has the other way round.
    std::map<std::pair<Index, Index>, int> sides;
    std::size_t faces = 0;
    double change = 0;
    for (std::size_t s = 0; s < count; ++s) {
      if ((set >> s & 1U) == 0) continue;
      ++faces;
      const auto& t = m.tets[2 * s];
      for (std::size_t k = 1; k < 4; ++k) sides[{t[k], t[k % 3 + 1]}] = 1;
      for (std::size_t k = 0; k < 2; ++k) {
        const auto& old = m.tets[2 * s + k];
        change -= energy(old[0], old[1], old[2], old[3]);
      }
    }
    std::size_t around = 0;
    for (const auto& [side, one] : sides) {
      if (sides.contains({side.second, side.first})) continue;
      ++around;
      change += energy(0, side.first, side.second, 1);
    }
    if (around == faces + 2) best = std::min(best, change);  // of one piece
  }
  return best;
}

TEST(FaceRemoval, ThreeFacesOfAPentagonBecomeAnEdge) {
  Fixture f(pentagon(0.8));
  double before = 0;
  double after = 0;
  const auto p = [&f](std::size_t v) { return vec(f.original.points[v]); };
  for (std::size_t i = 0; i < 5; ++i)
    after += tet_energy(kHarmonicObjective, p(0), p(2 + i), p(2 + (i + 1) % 5), p(1)).energy;
  for (std::size_t i = 1; i < 4; ++i) {
    before += tet_energy(kHarmonicObjective, p(0), p(2), p(2 + i), p(3 + i)).energy;
    before += tet_energy(kHarmonicObjective, p(1), p(2), p(3 + i), p(2 + i)).energy;
  }
  ASSERT_LT(after, before);
  const PassResult r = remove_faces(f);
  EXPECT_EQ(r.counts.face_removals, 1);
  EXPECT_EQ(r.counts.flips(), 1);
  EXPECT_EQ(r.active, 6);
  EXPECT_EQ(r.evaluated, 1);  // the face in the middle
  EXPECT_NEAR(r.decrease, before - after, 1e-12 * before);
  EXPECT_EQ(f.work.tets(), 5);
  EXPECT_EQ(f.work.free_count, 1);
  f.expect_consistent();
  for (const auto& t : f.result().tets) {
    EXPECT_EQ(std::count(t.begin(), t.end(), 0), 1);
    EXPECT_EQ(std::count(t.begin(), t.end(), 1), 1);
  }
  // And back: the inverse of an edge removal.
  EXPECT_EQ(remove_faces(f).counts.flips(), 0);
  EXPECT_EQ(f.pass().counts.flips(), 0);
}

TEST(FaceRemoval, IsRefusedWhereTheEdgeWouldPassOutside) {
  TetMesh m = pentagon(0.8);
  m.points[0][0] = m.points[1][0] = 1.1;
  ASSERT_TRUE(validate(m).ok());
  Fixture f(m);
  EXPECT_EQ(remove_faces(f).counts.flips(), 0);
  EXPECT_EQ(f.work.tets(), 6);
}

TEST(FaceRemoval, FindsTheBestOfAllClusters) {
  int better = 0;
  int worse = 0;
  int parts = 0;
  for (int n = 5; n <= kMaxRing; ++n) {
    for (std::uint32_t seed = 1; seed <= 200; ++seed) {
      const TetMesh m = random_sandwich(n, seed);
      if (!validate(m).ok()) continue;
      Fixture f(m);
      const RatedMesh view = rated(f.work, f.criterion);
      double best = 0;
      for (std::size_t root = 0; root < m.tets.size() / 2; ++root) {
        for (Index side = 0; side < 2; ++side) {
          FaceCluster cluster(view, f.state.constrained());
          if (!cluster.grow(static_cast<Index>(2 * root) + side, 0, kMaxRemovedFaces)) continue;
          const double change = cluster.best_subtree(f.state.energies.span());
          const double expected = best_change(m, root);
          ASSERT_NEAR(std::min(change, 1e3), std::min(expected, 1e3), 1e-9 * f.energy) << n << ' ' << seed;
          best = std::min(best, change);
          if (!(change < 0)) continue;
          const FlipCandidate c = cluster.candidate();
          parts += c.old_count() < static_cast<int>(m.tets.size()) ? 1 : 0;
          EXPECT_EQ(c.old_count(), 2 * (c.new_count() - 2));
        }
      }
      const PassResult r = remove_faces(f);
      EXPECT_EQ(r.counts.flips() > 0, best < -1e-9 * f.energy);
      EXPECT_GE(r.decrease, -best * (1 - 1e-9));
      f.expect_consistent();
      EXPECT_NEAR(refresh_energy(f.cpu, f.work, f.criterion, f.state.energies), f.energy - r.decrease, 1e-9 * f.energy);
      (r.counts.flips() > 0 ? better : worse) += 1;
    }
  }
  EXPECT_GT(better, 50);
  EXPECT_GT(worse, 50);
  EXPECT_GT(parts, 10);
}

TEST(FaceRemoval, StopsAtTheLargestRingAllowed) {
  Fixture f(pentagon(0.8));
  f.state.max_ring = 4;
  EXPECT_EQ(remove_faces(f).counts.flips(), 0);
  f.state.max_ring = 5;
  EXPECT_EQ(remove_faces(f).counts.flips(), 1);
}

TEST(FaceRemoval, NeverCrossesAnInterfaceNorTakesAConstrainedEdge) {
  TetMesh halves = pentagon(0.8);
  halves.tet_tags = {1, 2, 1, 2, 1, 2};  // the faces themselves
  EXPECT_EQ(remove_faces(*std::make_unique<Fixture>(halves)).counts.flips(), 0);
  TetMesh end = pentagon(0.8);
  end.tet_tags = {1, 1, 1, 1, 2, 2};  // the faces between two of them
  EXPECT_EQ(remove_faces(*std::make_unique<Fixture>(end)).counts.flips(), 0);
  EXPECT_EQ(
      remove_faces(*std::make_unique<Fixture>(pentagon(0.8), std::vector<std::array<Index, 2>>{{2, 4}})).counts.flips(),
      0);
  EXPECT_EQ(
      remove_faces(*std::make_unique<Fixture>(pentagon(0.8), std::vector<std::array<Index, 2>>{{2, 3}})).counts.flips(),
      1);
}

TEST(FaceRemoval, KeepsToTheFloor) {
  Fixture f(pentagon(0.8));
  f.criterion.floor.worst_shape = 1.01;  // better than any that would be made
  f.criterion.floor.safe_shape = 1.01;
  EXPECT_EQ(remove_faces(f).counts.flips(), 0);
  f.criterion.floor = QualityFloor::none();
  EXPECT_EQ(remove_faces(f).counts.flips(), 1);
}

TEST(FaceRemoval, PassesKeepAllThatTheyMustOnScrambledCubes) {
  Size removals = 0;
  for (const std::uint32_t seed : {1U, 2U, 3U, 4U}) {
    const bool two = seed > 2;
    Fixture f(test::scrambled(two ? test::two_materials(8, 0.15) : test::cube(8, 0.2, seed), 3, seed));
    f.flip_to_the_last();
    const auto locked = test::locked_faces(f.work);
    const auto volumes = test::region_volumes(f.result());
    for (int round = 0; round < 5; ++round) {
      const double energy = refresh_energy(f.cpu, f.work, f.criterion, f.state.energies);
      activate_all(f.cpu, f.work, f.criterion, f.state);
      std::vector<std::uint8_t> active(static_cast<std::size_t>(f.work.vertices()), 0);
      const std::vector<Tet> before = f.work.tet2vertex.download();
      const PassResult r =
          face_removal_pass(f.cpu, f.work, f.criterion, f.state, {active.data(), static_cast<Size>(active.size())});
      removals += r.counts.face_removals;
      f.expect_consistent();
      EXPECT_NEAR(refresh_energy(f.cpu, f.work, f.criterion, f.state.energies), energy - r.decrease, 1e-9 * energy);
      EXPECT_EQ(test::locked_faces(f.work), locked);
      test::expect_near_by_tag(test::region_volumes(f.result()), volumes, 1e-12);
      // The vertices of changed tetrahedra are flagged.
      for (std::size_t t = 0; t < before.size(); ++t) {
        const Tet tet = f.work.tet2vertex.span()[static_cast<Size>(t)];
        if (tet[0] == kFreeSlot || std::equal(tet.v, tet.v + 4, before[t].v)) continue;
        for (int k = 0; k < 4; ++k) EXPECT_EQ(active[static_cast<std::size_t>(tet[k])], 1);
      }
      if (r.counts.flips() == 0) break;
      f.flipped = active;
      f.flip_to_the_last();
      // The active sets missed nothing.
      activate_all(f.cpu, f.work, f.criterion, f.state);
      EXPECT_EQ(f.pass().counts.flips(), 0);
    }
  }
  EXPECT_GT(removals, 40);
}

TEST(FaceRemoval, IsTheSameForAnyNumberOfThreads) {
  const TetMesh m = test::scrambled(test::cube(12, 0.2), 3, 7);
  std::vector<Tet> expected;
  for (const int threads : {1, 2, 3, 8}) {
    Fixture f(m);
    const Cpu cpu(threads);
    const PassResult r = face_removal_pass(cpu, f.work, f.criterion, f.state, {});
    EXPECT_GT(r.counts.face_removals, 20);
    const std::vector<Tet> tets = f.work.tet2vertex.download();
    if (threads == 1) expected = tets;
    ASSERT_EQ(tets.size(), expected.size());
    for (std::size_t t = 0; t < tets.size(); ++t) EXPECT_TRUE(std::equal(tets[t].v, tets[t].v + 4, expected[t].v));
  }
}

}  // namespace
}  // namespace tetune

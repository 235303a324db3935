// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numeric>

#include <set>

#include "driver/boundary_triangles.inl"
#include "flips/triangulate.hpp"
#include "meshes.hpp"
#include "tetune/validate.hpp"
#include "work.hpp"

namespace tetune {
namespace {

using par::Cpu;

/// A mesh with its boundary, as load() finds it.
struct Fixture {
  Cpu cpu;
  test::CpuMesh work;
  FlipState<Cpu> state;
  BoundaryTriangles<Cpu> boundary;
  std::vector<std::uint8_t> awake;
  double energy = 0;

  explicit Fixture(const TetMesh& mesh, const std::vector<Index>& frozen = {},
                   const std::vector<std::array<Index, 2>>& constrained = {}, int threads = 1)
      : cpu(threads), work(test::to_work(mesh)) {
    build_adjacency(cpu, work);
    lock_interfaces(cpu, work);
    std::vector<std::uint64_t> keys;
    std::vector<std::uint8_t> on_edge(mesh.points.size(), 0);
    for (const auto& e : constrained) {
      keys.push_back(ConstrainedEdges::edge_key(e[0], e[1]));
      for (const Index v : e) on_edge[static_cast<std::size_t>(v)] = 1;
    }
    state.constrained_keys.upload(keys);
    state.constrained_vertex.upload(on_edge);
    std::vector<Index> vertices(mesh.points.size());
    std::iota(vertices.begin(), vertices.end(), 0);
    const ListedTriangles listed{
        {reinterpret_cast<const Index*>(mesh.triangles.data()), 3 * static_cast<Size>(mesh.triangles.size())},
        {mesh.triangle_tags.data(), static_cast<Size>(mesh.triangle_tags.size())},
        {},
        {},
        {vertices.data(), static_cast<Size>(vertices.size())},
        false};
    Cpu::Buffer<Listed> state_buffer;
    Surface<Cpu> surface;
    build_surface(cpu, work, listed, state_buffer, surface);
    std::vector<std::uint8_t> held(mesh.points.size(), kMovable);
    for (const Index v : frozen) held[static_cast<std::size_t>(v)] = kFrozen;
    build_boundary(cpu, work, surface, listed, Span<const std::uint8_t>(held.data(), static_cast<Size>(held.size())),
                   boundary);
    awake.assign(mesh.points.size(), 1);
    energy = refresh_energy(cpu, work, state);
    activate_all(cpu, work, state);
  }
  FlipReport pass() {
    return boundary_flip_pass(cpu, work, state, boundary, {awake.data(), static_cast<Size>(awake.size())});
  }
  std::vector<std::array<Index, 3>> listed_now(const TetMesh& mesh) {
    std::vector<Index> same(mesh.points.size());
    for (std::size_t v = 0; v < same.size(); ++v) same[v] = static_cast<Index>(v);
    return listed_after(mesh.triangles, boundary.triangles.download(), same);
  }
  /// The boundary's faces, each turned as its tetrahedron has it and from its lowest vertex on.
  std::set<std::array<Index, 3>> faces() {
    std::set<std::array<Index, 3>> all;
    for (Size t = 0; t < work.slots(); ++t) {
      for (int f = 0; f < 4 && work.view().alive(t); ++f) {
        if (work.view().tet2tet[t][f] != kNoLink) continue;
        std::array<Index, 3> v{};
        for (int k = 0; k < 3; ++k) v[static_cast<std::size_t>(k)] = work.view().tet2vertex[t][face_vertex(f, k)];
        all.insert(from_lowest(v));
      }
    }
    return all;
  }
  static std::array<Index, 3> from_lowest(std::array<Index, 3> v) {
    std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
    return v;
  }
  void expect_consistent() {
    EXPECT_EQ(test::check_links(work), "");
    const ValidationReport report = validate(test::from_work(work));
    EXPECT_TRUE(report.ok()) << report.message(false);
    std::set<std::array<Index, 3>> triangles;
    for (const BoundaryTriangle& t : boundary.triangles.download()) {
      triangles.insert(from_lowest({t.v[0], t.v[1], t.v[2]}));
    }
    EXPECT_EQ(triangles, faces());
    EXPECT_NEAR(refresh_energy(cpu, work, state), energy, 1e-9 * energy);
  }
};

/// A fan of n tetrahedra around the edge (0, 1) on the plane z = 0, from vertex 2 on; the vertices of its half ring are
/// shaken. Its two triangles on the plane are flat to the last bit.
TetMesh fan(int n, std::uint32_t seed, double height = 0) {
  std::mt19937 random(seed);
  const auto uniform = [&random] { return static_cast<double>(random()) / 4294967296.0; };
  TetMesh m;
  m.points = {{0.3 * uniform(), -1.5 - uniform(), 0}, {0.3 * uniform(), 1.5 + uniform(), 0}};
  for (int i = 0; i <= n; ++i) {
    const bool in_plane = i == 0 || i == n;
    const double angle = M_PI * (i + (in_plane ? 0 : 0.3 * (uniform() - 0.5))) / n;
    const double radius = 0.7 + 0.6 * uniform();
    m.points.push_back({-radius * std::cos(angle), 0.6 * uniform() - 0.3, in_plane ? 0 : radius * std::sin(angle)});
  }
  m.points.back()[2] = height;
  for (int i = 0; i < n; ++i) m.tets.push_back({0, static_cast<Index>(2 + i), static_cast<Index>(3 + i), 1});
  return test::with_tags(m);
}

/// Plain oracle: the least energy over all triangulations of the polygon's places i..k.
double least_energy(const TetMesh& m, int i, int k) {
  if (k == i + 1) return 0;
  const auto p = [&m](int v) { return vec(m.points[static_cast<std::size_t>(v)]); };
  double least = kNever;
  for (int j = i + 1; j < k; ++j) {
    const TetEnergy below = tet_energy(kHarmonicLaw, p(0), p(2 + i), p(2 + j), p(2 + k));
    const TetEnergy above = tet_energy(kHarmonicLaw, p(1), p(2 + i), p(2 + k), p(2 + j));
    if (!below.certified || !above.certified) continue;
    least = std::min(least, least_energy(m, i, j) + least_energy(m, j, k) + below.eta + above.eta);
  }
  return least;
}

TEST(BoundaryFlip, FindsTheBestOfAllTriangulations) {
  for (int n = 2; n < kMaxRing; ++n) {
    int flipped = 0;
    int left = 0;
    for (std::uint32_t seed = 1; seed <= 600; ++seed) {
      const TetMesh m = fan(n, seed);
      if (!validate(m).ok()) continue;
      Fixture f(m);
      const double best = least_energy(m, 0, n);
      const bool expected = best < f.energy * (1 - kMinRelativeGain);
      const FlipReport r = f.pass();
      EXPECT_EQ(r.active, 1);
      EXPECT_EQ(r.boundary_flips, expected ? 1 : 0);
      EXPECT_EQ(r.flips(), r.boundary_flips);
      ++(expected ? flipped : left);
      if (!expected) continue;
      EXPECT_NEAR(r.decrease, f.energy - best, 1e-12 * f.energy);
      EXPECT_EQ(f.work.tets(), 2 * (n - 1));
      f.energy -= r.decrease;
      f.expect_consistent();
      EXPECT_EQ(f.pass().flips(), 0);
    }
    EXPECT_GT(flipped, 10) << n;
    EXPECT_GT(left, n == 2 ? -1 : 100) << n;
  }
}

/// One whose flip is worth it.
TetMesh worth_it(int n) {
  TetMesh m;
  for (std::uint32_t seed = 1; seed < 1000; ++seed) {
    m = fan(n, seed);
    if (validate(m).ok() && Fixture(m).pass().flips() == 1) break;
  }
  return m;
}

TEST(BoundaryFlip, StopsAtTheLargestRingAllowed) {
  Fixture f(worth_it(4));
  f.state.max_ring = 4;
  EXPECT_EQ(f.pass().evaluated, 0);
  f.state.max_ring = 5;
  EXPECT_EQ(f.pass().boundary_flips, 1);
}

TEST(BoundaryFlip, AsksOnlyAroundAwakeVertices) {
  Fixture f(worth_it(2));
  f.awake.assign(f.awake.size(), 1);
  f.awake[0] = f.awake[1] = 0;
  EXPECT_EQ(f.pass().active, 0);
  f.awake[1] = 1;
  EXPECT_EQ(f.pass().boundary_flips, 1);
  EXPECT_EQ(f.awake[0], 1);
}

TEST(BoundaryFlip, LeavesAFoldAlone) {
  std::uint32_t seed = 1;
  while (seed < 1000 && (!validate(fan(2, seed)).ok() || Fixture(fan(2, seed)).pass().flips() == 0)) ++seed;
  EXPECT_EQ(Fixture(fan(2, seed, 1e-7)).pass().active, 1);
  EXPECT_EQ(Fixture(fan(2, seed, 1e-5)).pass().active, 0);
  EXPECT_EQ(Fixture(fan(2, seed, -1e-5)).pass().active, 0);
}

TEST(BoundaryFlip, LeavesWhatMustStay) {
  const TetMesh m = worth_it(2);
  const std::array<Index, 3> first{0, 1, 2};
  const std::array<Index, 3> second{0, 1, 4};
  const auto flips = [](TetMesh mesh, const std::vector<std::array<Index, 3>>& triangles, std::vector<int> tags) {
    mesh.triangles = triangles;
    mesh.triangle_tags = std::move(tags);
    return Fixture(mesh).pass().flips();
  };
  EXPECT_EQ(flips(m, {first, second}, {7, 7}), 1);
  EXPECT_EQ(flips(m, {first, second}, {0, 0}), 1);
  EXPECT_EQ(flips(m, {first, second}, {7, 8}), 0);
  EXPECT_EQ(flips(m, {first, second}, {7, 0}), 0);
  EXPECT_EQ(flips(m, {first}, {7}), 0);
  EXPECT_EQ(flips(m, {first}, {0}), 0);
  EXPECT_EQ(flips(m, {first, second, first}, {7, 7, 7}), 0);
  // A frozen triangle has three frozen vertices.
  EXPECT_EQ(Fixture(m, {0, 1, 2}).pass().flips(), 0);
  EXPECT_EQ(Fixture(m, {0, 1, 4}).pass().flips(), 0);
  EXPECT_EQ(Fixture(m, {0, 1}).pass().flips(), 1);
  EXPECT_EQ(Fixture(m, {}, {{0, 1}}).pass().flips(), 0);
  EXPECT_EQ(Fixture(m, {}, {{0, 2}}).pass().flips(), 1);
  TetMesh two = m;
  two.tet_tags = {1, 2};
  EXPECT_EQ(Fixture(two).pass().flips(), 0);
  two.tet_tags = {5, 5};
  Fixture f(two);
  EXPECT_EQ(f.pass().flips(), 1);
  EXPECT_EQ(test::from_work(f.work).tet_tags, (std::vector<int>{5, 5}));
}

TEST(BoundaryFlip, IsRefusedWhereTheQuadrangleIsNotConvex) {
  TetMesh m;
  m.points = {{0, -1, 0}, {0, 1, 0}, {-0.2, 1.5, 0}, {0, 0, 1}, {0.2, 1.5, 0}};
  m.tets = {{0, 2, 3, 1}, {0, 3, 4, 1}};
  ASSERT_TRUE(validate(test::with_tags(m)).ok());
  Fixture f(test::with_tags(m));
  EXPECT_EQ(f.pass().active, 1);
  EXPECT_EQ(f.pass().flips(), 0);
}

TEST(BoundaryFlip, ListedTrianglesFollowAndTurnAsTheyDid) {
  for (const bool turned : {false, true}) {
    TetMesh m = worth_it(2);
    m.triangles = {{0, 1, 3}, {1, 0, 2}, {0, 1, 4}};  // the first is inside
    if (turned) std::swap(m.triangles[1][0], m.triangles[1][2]);
    m.triangle_tags = {0, 7, 7};
    Fixture f(m);
    EXPECT_EQ(f.listed_now(m), m.triangles);
    const auto before = f.faces();
    EXPECT_EQ(before.count(Fixture::from_lowest(m.triangles[1])), turned ? 0U : 1U);
    EXPECT_EQ(before.count(Fixture::from_lowest(m.triangles[2])), 1U);
    EXPECT_EQ(f.pass().flips(), 1);
    const auto listed = f.listed_now(m);
    const auto after = f.faces();
    EXPECT_EQ(listed[0], m.triangles[0]);
    for (std::size_t i : {1U, 2U}) {
      std::set<Index> vertices(listed[i].begin(), listed[i].end());
      EXPECT_TRUE(vertices.count(2) == 1 && vertices.count(4) == 1) << i;
    }
    EXPECT_NE(std::set<Index>(listed[1].begin(), listed[1].end()), std::set<Index>(listed[2].begin(), listed[2].end()));
    EXPECT_EQ(after.count(Fixture::from_lowest(listed[1])), turned ? 0U : 1U);
    EXPECT_EQ(after.count(Fixture::from_lowest(listed[2])), 1U);
  }
}

/// Passes of both kinds on a cube whose vertices have moved within its sides.
TEST(BoundaryFlip, PassesKeepAllConsistent) {
  std::set<std::vector<std::array<Index, 4>>> results;
  for (const int threads : {1, 2, 3}) {
    Fixture f(test::sheared(test::scrambled(test::cube(12, 0.2, 3), 3, 3), 1.2), {}, {}, threads);
    Size flips = 0;
    for (int round = 0; round < 4; ++round) {
      const FlipReport r = f.pass();
      flips += r.flips();
      f.energy -= r.decrease;
      f.expect_consistent();
      for (Size more = 1; more > 0;) {
        const FlipReport inside = flip_pass(f.cpu, f.work, f.state, {});
        more = inside.flips();
        f.energy -= inside.decrease;
      }
      f.expect_consistent();
    }
    EXPECT_GT(flips, 100);
    EXPECT_EQ(f.pass().flips(), 0);
    // What flips made was looked at.
    activate_all(f.cpu, f.work, f.state);
    EXPECT_EQ(flip_pass(f.cpu, f.work, f.state, {}).flips(), 0);
    results.insert(test::from_work(f.work).tets);
  }
  EXPECT_EQ(results.size(), 1U);
}

}  // namespace
}  // namespace tetune

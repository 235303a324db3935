// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <set>

#include "boundary/boundary_triangles.hpp"
#include "boundary/classify.hpp"
#include "operators/flips/boundary_flip.hpp"
#include "operators/flips/flip_energy.hpp"
#include "operators/flips/flip_pass.hpp"
#include "support/meshes.hpp"
#include "support/work.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

using backend::Cpu;

/// A mesh with its boundary, as load() finds it.
struct BoundaryFlips {
  TetMesh original;
  Cpu cpu;
  test::CpuMesh work;
  Criterion criterion;
  FlipState<Cpu> state;
  BoundaryTriangles<Cpu> boundary;
  std::vector<std::uint8_t> active;
  double energy = 0;

  explicit BoundaryFlips(const TetMesh& mesh, const std::vector<Index>& frozen = {},
                         const std::vector<std::array<Index, 2>>& constrained = {}, int threads = 1)
      : original(mesh), cpu(threads), work(test::to_work(mesh)) {
    build_adjacency(cpu, work);
    test::lock_interfaces(cpu, work, mesh);
    std::vector<std::uint64_t> keys;
    std::vector<std::uint8_t> on_edge(mesh.points.size(), 0);
    for (const auto& e : constrained) {
      keys.push_back(ConstrainedEdges::edge_key(e[0], e[1]));
      for (const Index v : e) on_edge[static_cast<std::size_t>(v)] = 1;
    }
    state.constrained_keys.upload(cpu, keys);
    state.constrained_vertex.upload(cpu, on_edge);
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
    build_boundary(cpu, surface, listed, Span<const std::uint8_t>(held.data(), static_cast<Size>(held.size())),
                   boundary);
    active.assign(mesh.points.size(), 1);
    energy = refresh_energy(cpu, work, criterion, state.energies);
    activate_all(cpu, work, criterion, state);
  }
  PassResult pass() {
    return boundary_flip_pass(cpu, work, criterion, state, boundary, {active.data(), static_cast<Size>(active.size())});
  }
  std::vector<std::array<Index, 3>> listed_now(const TetMesh& mesh) {
    std::vector<Index> same(mesh.points.size());
    for (std::size_t v = 0; v < same.size(); ++v) same[v] = static_cast<Index>(v);
    std::vector<std::array<Index, 3>> now = mesh.triangles;
    for (const auto& [entry, triangle] : follow_changes(boundary.triangles.download(), same, mesh.triangles).changes) {
      now[static_cast<std::size_t>(entry)] = triangle;
    }
    return now;
  }
  /// The outer faces, each turned as its tetrahedron has it and from its lowest vertex on.
  std::set<std::array<Index, 3>> faces() {
    std::set<std::array<Index, 3>> all;
    each_face([&](const std::array<Index, 3>& v, HalfFace link) {
      if (link == kNoHalfFace) all.insert(from_lowest(v));
    });
    return all;
  }
  /// The faces that must stay inside, sorted.
  std::set<std::array<Index, 3>> inner_faces() {
    std::set<std::array<Index, 3>> all;
    each_face([&](std::array<Index, 3> v, HalfFace link) {
      std::sort(v.begin(), v.end());
      if (link != kNoHalfFace && is_locked(link)) all.insert(v);
    });
    return all;
  }
  template <class Visit>
  void each_face(const Visit& visit) {
    for (Size t = 0; t < work.slots(); ++t) {
      for (int f = 0; f < 4 && work.view().alive(t); ++f) {
        std::array<Index, 3> v{};
        for (int k = 0; k < 3; ++k) v[static_cast<std::size_t>(k)] = work.view().tet2vertex[t][face_vertex(f, k)];
        visit(v, work.view().tet2tet[t][f]);
      }
    }
  }
  static std::array<Index, 3> from_lowest(std::array<Index, 3> v) {
    std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
    return v;
  }
  TetMesh result() { return test::from_work(work, original); }
  void expect_consistent() {
    EXPECT_EQ(test::check_adjacency(work), "");
    const ValidationReport report = validate(result());
    EXPECT_TRUE(report.ok()) << report.message(false);
    const auto inside = inner_faces();
    std::set<std::array<Index, 3>> outer_triangles;
    std::set<std::array<Index, 3>> inner_triangles;
    for (const BoundaryTriangle& t : boundary.triangles.download()) {
      std::array<Index, 3> v{t.v[0], t.v[1], t.v[2]};
      std::sort(v.begin(), v.end());
      if (inside.count(v) == 1) {
        inner_triangles.insert(v);
      } else {
        outer_triangles.insert(from_lowest({t.v[0], t.v[1], t.v[2]}));
      }
    }
    EXPECT_EQ(outer_triangles, faces());
    EXPECT_EQ(inner_triangles, inside);
    EXPECT_NEAR(refresh_energy(cpu, work, criterion, state.energies), energy, 1e-9 * energy);
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

/// Plain oracle: the least energy over all triangulations of the places i..k of a polygon around the edge (0, 1).
double least_energy(const TetMesh& m, const std::vector<Index>& polygon, std::size_t i, std::size_t k) {
  if (k == i + 1) return 0;
  const auto p = [&m](Index v) { return vec(m.points[static_cast<std::size_t>(v)]); };
  double least = kInfeasible;
  for (std::size_t j = i + 1; j < k; ++j) {
    const Vec3 r[3] = {p(polygon[i]), p(polygon[j]), p(polygon[k])};
    const TetEnergy below = tet_energy(kHarmonicObjective, p(0), r[0], r[1], r[2]);
    const TetEnergy above = tet_energy(kHarmonicObjective, p(1), r[0], r[2], r[1]);
    if (!below.certified || !above.certified) continue;
    least =
        std::min(least, least_energy(m, polygon, i, j) + least_energy(m, polygon, j, k) + below.energy + above.energy);
  }
  return least;
}
double least_energy(const TetMesh& m, const std::vector<Index>& polygon) {
  return least_energy(m, polygon, 0, polygon.size() - 1);
}

/// The polygon of fan().
std::vector<Index> fan_polygon(int n) {
  std::vector<Index> polygon;
  for (Index v = 2; v <= n + 2; ++v) polygon.push_back(v);
  return polygon;
}

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
    EXPECT_GT(left, n == 2 ? -1 : 100) << n;
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

TEST(BoundaryFlip, FindsTheBestOnBothSidesOfAnInterface) {
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
    EXPECT_GT(left, n + below == 4 ? -1 : 50) << n << below;
    if (n == 2 && below == 3) {
      EXPECT_GT(losing_side, 0);
    }
  }
}

TEST(BoundaryFlip, TrianglesOfAnInterfaceTurnAsTheyDid) {
  std::uint32_t seed = 1;
  while (seed < 1000 &&
         (!validate(two_fans(2, 2, seed)).ok() || BoundaryFlips(two_fans(2, 2, seed)).pass().counts.flips() == 0))
    ++seed;
  for (const bool turned : {false, true}) {
    TetMesh m = two_fans(2, 2, seed);
    m.triangles = {{0, 1, 2}, {0, 1, 4}};  // they turn in opposite senses
    if (turned) std::swap(m.triangles[0], m.triangles[1]);
    m.triangle_tags = {7, 7};
    BoundaryFlips f(m);
    EXPECT_EQ(f.listed_now(m), m.triangles);
    EXPECT_EQ(f.pass().counts.flips(), 1);
    const auto listed = f.listed_now(m);
    for (std::size_t i = 0; i < 2; ++i) {
      const auto normal = [&m](const std::array<Index, 3>& t) {
        const auto p = [&](std::size_t k) { return vec(m.points[static_cast<std::size_t>(t[k])]); };
        return cross(p(1) - p(0), p(2) - p(0)).z;
      };
      EXPECT_GT(normal(listed[i]) * normal(m.triangles[i]), 0);
      std::array<Index, 3> sorted = listed[i];
      std::sort(sorted.begin(), sorted.end());
      EXPECT_EQ(f.inner_faces().count(sorted), 1U);
    }
  }
}

TEST(BoundaryFlip, LeavesAnInterfaceAloneWhereItsTagsDiffer) {
  std::uint32_t seed = 1;
  while (seed < 1000 &&
         (!validate(two_fans(2, 2, seed)).ok() || BoundaryFlips(two_fans(2, 2, seed)).pass().counts.flips() == 0))
    ++seed;
  TetMesh m = two_fans(2, 2, seed);
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

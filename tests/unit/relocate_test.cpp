// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "core/connect.hpp"
#include "energy/ring_simd.hpp"
#include "meshes.hpp"
#include "relocate/brent.hpp"
#include "relocate/coloring.hpp"
#include "relocate/step.hpp"
#include "relocate/sweep.hpp"
#include "work.hpp"

namespace tetune {
namespace {

struct Parabola {
  double at;
  double value(double t) const { return (t - at) * (t - at); }
};
struct Barrier {
  double value(double t) const { return 1 / t + 1 / (3 - t) + t; }
};

TEST(Brent, FindsTheMinimumInsideAndAtTheEnds) {
  EXPECT_NEAR(brent_minimum(Parabola{0.3}, 0, 1), 0.3, 1e-5);
  EXPECT_NEAR(brent_minimum(Parabola{-1}, 0, 1), 0, 1e-5);
  EXPECT_NEAR(brent_minimum(Parabola{7}, 0, 1), 1, 1e-5);
  // 1/t^2 = 1/(3-t)^2 + 1 at the minimum.
  const double t = brent_minimum(Barrier{}, 1e-9, 3 - 1e-9);
  EXPECT_NEAR(1 / (t * t), 1 / ((3 - t) * (3 - t)) + 1, 1e-4);
}

/// Rings of a cube mesh.
struct Fixture {
  test::CpuMesh work;
  Rings<par::Cpu> rings;
  explicit Fixture(const TetMesh& mesh) : work(test::to_work(mesh)) { build_rings(par::Cpu(1), work, rings); }
  SimdRing simd(Index v) {
    const Size begin = rings.offsets.span()[v];
    return {work.law, work.points.span(), rings.faces.span().data() + begin, rings.offsets.span()[v + 1] - begin};
  }
  PlainRing plain(Index v) {
    const Size begin = rings.offsets.span()[v];
    return {work.law, work.points.span(), rings.faces.span().data() + begin, rings.offsets.span()[v + 1] - begin};
  }
  Vec3 at(Index v) { return vec(work.points.span()[v]); }
};

Index inner_vertex(int n) { return static_cast<Index>((1 * (n + 1) + 1) * (n + 1) + 1); }

TEST(Rings, OfOneTetAreItsFaces) {
  Fixture f(test::one_tet());
  EXPECT_EQ(f.rings.faces.size(), 4);
  for (Index v = 0; v < 4; ++v) EXPECT_TRUE(f.simd(v).value(f.at(v)).certified);
}

template <class Step>
Vec3 converge(Fixture& f, Index v, Vec3 x, const Motion& motion, const Step& step, int times) {
  for (int i = 0; i < times; ++i) {
    SimdRing ring = f.simd(v);
    const double before = ring.value(x).value;
    const StepResult r = step(ring, x, motion);
    EXPECT_LE(ring.value(r.position).value, before * (1 + 1e-14));
    EXPECT_TRUE(ring.value(r.position).certified);
    x = r.position;
  }
  return x;
}

TEST(NewtonStep, EndsWhereTheGradientVanishes) {
  Fixture f(test::cube(3, 0.2));
  const Index v = inner_vertex(3);
  const Vec3 x = converge(f, v, f.at(v), {Mobility::free, {}}, NewtonStep{1, 0}, 30);
  SimdRing ring = f.simd(v);
  EXPECT_LT(norm(ring.model(x).gradient), 1e-5);
}

TEST(NewtonStep, InAPlaneStaysThereAndEndsWhereTheTangentGradientVanishes) {
  Fixture f(test::cube(3, 0.2));
  const Index v = 1 * 4 + 1;  // inside the face z = 0
  ASSERT_EQ(f.at(v).z, 0);
  const Motion motion{Mobility::plane, {0, 0, 1}};
  const Vec3 x = converge(f, v, f.at(v), motion, NewtonStep{1, 0}, 30);
  SimdRing ring = f.simd(v);
  EXPECT_EQ(x.z, 0);
  EXPECT_LT(norm(tangent_gradient(ring.model(x).gradient, motion)), 1e-5);
}

TEST(NewtonStep, OnALineStaysThere) {
  Fixture f(test::cube(3, 0.2));
  const Index v = 1;  // on the edge y = z = 0
  const Motion motion{Mobility::line, {1, 0, 0}};
  const Vec3 x = converge(f, v, f.at(v), motion, NewtonStep{1, 0}, 30);
  EXPECT_EQ(x.y, 0);
  EXPECT_EQ(x.z, 0);
  SimdRing ring = f.simd(v);
  EXPECT_LT(std::fabs(ring.model(x).gradient.x), 1e-5);
}

TEST(GradientStep, FindsTheSameMinimum) {
  Fixture f(test::cube(3, 0.2));
  const Index v = inner_vertex(3);
  const Motion motion{Mobility::free, {}};
  const Vec3 newton = converge(f, v, f.at(v), motion, NewtonStep{1, 0}, 30);
  const Vec3 gradient = converge(f, v, f.at(v), motion, GradientStep{1e-9}, 200);
  EXPECT_NEAR(norm(newton - gradient), 0, 1e-4);
}

TEST(NewtonStep, PullsASliverOpenInOneVisit) {
  // The vertex a hair inside one face of its ring.
  Fixture f(test::cube(3));
  const Index v = inner_vertex(3);
  const LinkFace face = f.rings.faces.span()[f.rings.offsets.span()[v]];
  const Vec3 centre = (1.0 / 3) * (f.at(face.v[0]) + f.at(face.v[1]) + f.at(face.v[2]));
  const Vec3 x = centre + 1e-10 * (f.at(v) - centre);
  SimdRing ring = f.simd(v);
  ASSERT_TRUE(ring.value(x).certified);
  const double best = ring.value(converge(f, v, f.at(v), {Mobility::free, {}}, NewtonStep{1, 0}, 50)).value;
  ASSERT_GT(ring.value(x).value, 1e10);
  const StepResult r = NewtonStep{1.6, 1e-10}(ring, x, {Mobility::free, {}});
  EXPECT_LT(ring.value(r.position).value, 10 * best);
}

TEST(NewtonStep, LeavesAVolumeThatRoundingHides) {
  int tried = 0;
  Fixture f(test::cube(3, 0.2));
  const Index v = inner_vertex(3);
  for (Size i = f.rings.offsets.span()[v]; i < f.rings.offsets.span()[v + 1]; ++i) {
    const LinkFace face = f.rings.faces.span()[i];
    const Vec3 centre = (1.0 / 3) * (f.at(face.v[0]) + f.at(face.v[1]) + f.at(face.v[2]));
    const Vec3 x = centre + 1e-16 * (f.at(v) - centre);
    const auto p3 = [](const Vec3& p) { return Point3{p.x, p.y, p.z}; };
    if (orient_sign(p3(x), p3(f.at(face.v[0])), p3(f.at(face.v[1])), p3(f.at(face.v[2]))) <= 0) continue;
    ++tried;
    SimdRing ring = f.simd(v);
    PlainRing plain = f.plain(v);
    ASSERT_FALSE(ring.value(x).certified);
    const StepResult r = NewtonStep{1.6, 1e-10}(ring, x, {Mobility::free, {}});
    EXPECT_TRUE(ring.value(r.position).certified);
    EXPECT_LT(ring.value(r.position).value, 1e4);
    EXPECT_TRUE(plain.value(NewtonStep{1.6, 1e-10}(plain, x, {Mobility::free, {}}).position).certified);
  }
  EXPECT_GT(tried, 5);
}

TEST(Steps, OfAFixedVertexDoNothing) {
  Fixture f(test::cube(3, 0.2));
  const Index v = inner_vertex(3);
  SimdRing ring = f.simd(v);
  EXPECT_EQ(NewtonStep({1.6, 1e-10})(ring, f.at(v), {Mobility::fixed, {}}).decrease, 0);
  EXPECT_EQ(GradientStep{1e-5}(ring, f.at(v), {Mobility::fixed, {}}).decrease, 0);
}

void expect_proper(Fixture& f, const Coloring<par::Cpu>& coloring, Span<const Mobility> mobility) {
  for (Size v = 0; v < mobility.size(); ++v) {
    const std::uint8_t c = coloring.color.span()[v];
    if (mobility[v] == Mobility::fixed) continue;
    ASSERT_LT(c, 128);
    for (Size i = f.rings.offsets.span()[v]; i < f.rings.offsets.span()[v + 1]; ++i) {
      for (const Index w : f.rings.faces.span()[i].v) ASSERT_NE(coloring.color.span()[w], c);
    }
  }
}

TEST(Coloring, GivesIndependentSetsWhichHoldEachMovableVertexOnce) {
  Fixture f(test::cube(6, 0.2));
  const Size n = f.work.vertices();
  std::vector<Mobility> host(static_cast<std::size_t>(n), Mobility::free);
  host[0] = host[100] = Mobility::fixed;
  par::Cpu::Buffer<Mobility> mobility;
  mobility.upload(host);
  std::vector<std::uint8_t> first_run;
  for (const int threads : {1, 2, 3}) {
    Coloring<par::Cpu> coloring;
    color_vertices(par::Cpu(threads), f.rings.view(), mobility.span(), coloring);
    expect_proper(f, coloring, mobility.span());
    EXPECT_EQ(coloring.vertices.size(), n - 2);
    EXPECT_LE(coloring.colors(), 16);
    std::vector<int> seen(static_cast<std::size_t>(n), 0);
    for (Size i = 0; i < coloring.vertices.size(); ++i) ++seen[static_cast<std::size_t>(coloring.vertices.span()[i])];
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), n - 2);
    if (first_run.empty()) first_run = coloring.color.download();
    EXPECT_EQ(coloring.color.download(), first_run);
  }
}

/// They need not share a tetrahedron, and the bound on the deviation asks for both.
TEST(Coloring, KeepsNeighboursOnLinesApart) {
  Fixture f(test::cube(6, 0.2));
  build_adjacency(par::Cpu(1), f.work);
  const Index n = static_cast<Index>(f.work.vertices());
  par::Cpu::Buffer<Mobility> mobility;
  mobility.upload(std::vector<Mobility>(static_cast<std::size_t>(n), Mobility::curve));
  constexpr Index kFar = 25;
  std::vector<LineVertex> line;
  for (Index v = 0; v < n; ++v) line.push_back({{v - kFar, v + kFar < n ? v + kFar : -1}});
  const std::vector<std::uint32_t> offsets(static_cast<std::size_t>(n) + 1, 0);
  const SurfaceStars stars{{}, {{offsets.data(), Size{n} + 1}, {}}, {line.data(), static_cast<Size>(line.size())}};
  const auto alike = [&](const SurfaceStars& apart) {
    Rings<par::Cpu> rings;
    build_rings(par::Cpu(1), f.work, rings);
    Coloring<par::Cpu> coloring;
    color_vertices(par::Cpu(1), rings.view(), mobility.span(), coloring, apart);
    const std::vector<std::uint8_t> color = coloring.color.download();
    int count = 0;
    for (Index v = kFar; v < n; ++v) {
      count += color[static_cast<std::size_t>(v)] == color[static_cast<std::size_t>(v - kFar)] ? 1 : 0;
    }
    return count;
  };
  EXPECT_GT(alike({}), 10);
  EXPECT_EQ(alike(stars), 0);
}

TEST(Coloring, KeepsTheSurfaceThreeEdgesApartWhereAsked) {
  const TetMesh mesh = test::cube(6, 0.2);
  Fixture f(mesh);
  build_adjacency(par::Cpu(1), f.work);
  const auto n = static_cast<std::size_t>(f.work.vertices());
  par::Cpu::Buffer<Mobility> mobility;
  mobility.upload(std::vector<Mobility>(n, Mobility::surface));
  // The mesh's boundary, in the numbers of the work mesh.
  std::vector<SurfaceTriangle> triangles;
  const auto tets = f.work.tet2vertex.download();
  const auto links = f.work.tet2tet.download();
  std::vector<std::vector<std::uint32_t>> corners(n);
  for (std::size_t t = 0; t < tets.size(); ++t) {
    for (int face = 0; face < 4; ++face) {
      if (links[t][face] != kNoLink) continue;
      SurfaceTriangle triangle;
      for (int k = 0; k < 3; ++k) {
        triangle.v[k] = tets[t][face_vertex(face, k)];
        corners[static_cast<std::size_t>(triangle.v[k])].push_back(static_cast<std::uint32_t>(3 * triangles.size()) +
                                                                   static_cast<std::uint32_t>(k));
      }
      triangles.push_back(triangle);
    }
  }
  ASSERT_FALSE(triangles.empty());
  std::vector<std::uint32_t> offsets{0};
  std::vector<std::uint32_t> items;
  for (const auto& row : corners) {
    items.insert(items.end(), row.begin(), row.end());
    offsets.push_back(static_cast<std::uint32_t>(items.size()));
  }
  const std::vector<LineVertex> line(corners.size(), LineVertex{{-1, -1}});
  const SurfaceStars stars{
      {triangles.data(), static_cast<Size>(triangles.size())},
      {{offsets.data(), static_cast<Size>(offsets.size())}, {items.data(), static_cast<Size>(items.size())}},
      {line.data(), static_cast<Size>(line.size())}};
  const auto too_near = [&](const Coloring<par::Cpu>& coloring) {
    const std::vector<std::uint8_t> color = coloring.color.download();
    int count = 0;
    for (std::size_t v = 0; v < n; ++v) {
      for (const std::uint32_t c : corners[v]) {
        for (const Index near : triangles[c / 3].v) {
          for (const std::uint32_t d : corners[static_cast<std::size_t>(near)]) {
            for (const Index far : triangles[d / 3].v) {
              if (static_cast<std::size_t>(far) != v && color[static_cast<std::size_t>(far)] == color[v]) ++count;
            }
          }
        }
      }
    }
    return count;
  };
  Coloring<par::Cpu> plain;
  color_vertices(par::Cpu(2), f.rings.view(), mobility.span(), plain);
  EXPECT_GT(too_near(plain), 0);
  for (const int threads : {1, 3}) {
    Coloring<par::Cpu> apart;
    color_vertices(par::Cpu(threads), f.rings.view(), mobility.span(), apart, stars);
    expect_proper(f, apart, mobility.span());
    const std::vector<std::uint8_t> before = apart.color.download();
    EXPECT_EQ(too_near(apart), 0);
    EXPECT_EQ(apart.vertices.size(), static_cast<Size>(n));
    // Rings change: the colours that are new keep apart as well.
    Fixture flipped(test::scrambled(mesh, 3));
    color_vertices(par::Cpu(threads), flipped.rings.view(), mobility.span(), apart, stars);
    expect_proper(flipped, apart, mobility.span());
    EXPECT_EQ(too_near(apart), 0);
    EXPECT_NE(apart.color.download(), before);
  }
}

TEST(Coloring, RepairsWhatAChangeBroke) {
  Fixture f(test::cube(6, 0.2));
  const Size n = f.work.vertices();
  par::Cpu::Buffer<Mobility> mobility;
  mobility.upload(std::vector<Mobility>(static_cast<std::size_t>(n), Mobility::free));
  Coloring<par::Cpu> coloring;
  color_vertices(par::Cpu(2), f.rings.view(), mobility.span(), coloring);
  auto broken = coloring.color.download();
  std::fill(broken.begin(), broken.begin() + 100, std::uint8_t{3});
  coloring.color.upload(broken);
  color_vertices(par::Cpu(2), f.rings.view(), mobility.span(), coloring);
  expect_proper(f, coloring, mobility.span());
  int kept = 0;
  for (std::size_t v = 150; v < broken.size(); ++v)
    kept += coloring.color.span()[static_cast<Size>(v)] == broken[v] ? 1 : 0;
  EXPECT_GT(kept, static_cast<int>(broken.size()) - 200);
}

}  // namespace
}  // namespace tetune

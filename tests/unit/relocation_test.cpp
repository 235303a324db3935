// SPDX-License-Identifier: Apache-2.0
// The steps of one vertex, and the coloring of the vertices.
#include <gtest/gtest.h>

#include "energy/simd_ring.hpp"
#include "math/brent.hpp"
#include "mesh/connect.hpp"
#include "relocation/coloring.hpp"
#include "relocation/rings.hpp"
#include "relocation/step.hpp"
#include "relocation/sweep.hpp"
#include "support/meshes.hpp"
#include "support/work.hpp"

namespace tetune {
namespace {

struct Parabola {
  double at;
  double operator()(double t) const { return (t - at) * (t - at); }
};
struct Barrier {
  double operator()(double t) const { return 1 / t + 1 / (3 - t) + t; }
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
  Rings<backend::Cpu> rings;
  explicit Fixture(const TetMesh& mesh) : work(test::to_work(mesh)) { build_rings(backend::Cpu(1), work, rings); }
  SimdRing simd(Index v) {
    const Size begin = rings.offsets.span()[v];
    return {kHarmonicObjective, work.points.span(), rings.faces.span().data() + begin,
            rings.offsets.span()[v + 1] - begin};
  }
  PlainRing<> plain(Index v) {
    const Size begin = rings.offsets.span()[v];
    return {kHarmonicObjective, work.points.span(), rings.faces.span().data() + begin,
            rings.offsets.span()[v + 1] - begin};
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
Vec3 converge(Fixture& f, Index v, Vec3 x, const MotionSpace& motion, const Step& step, int times) {
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
  const Vec3 x = converge(f, v, f.at(v), {VertexDof::free, {}}, NewtonStep{1, 0}, 30);
  SimdRing ring = f.simd(v);
  EXPECT_LT(norm(ring.model(x).gradient), 1e-5);
}

TEST(NewtonStep, InAPlaneStaysThereAndEndsWhereTheTangentGradientVanishes) {
  Fixture f(test::cube(3, 0.2));
  const Index v = 1 * 4 + 1;  // inside the face z = 0
  ASSERT_EQ(f.at(v).z, 0);
  const MotionSpace motion{VertexDof::plane, {0, 0, 1}};
  const Vec3 x = converge(f, v, f.at(v), motion, NewtonStep{1, 0}, 30);
  SimdRing ring = f.simd(v);
  EXPECT_EQ(x.z, 0);
  EXPECT_LT(norm(project(ring.model(x).gradient, motion)), 1e-5);
}

TEST(NewtonStep, OnALineStaysThere) {
  Fixture f(test::cube(3, 0.2));
  const Index v = 1;  // on the edge y = z = 0
  const MotionSpace motion{VertexDof::line, {1, 0, 0}};
  const Vec3 x = converge(f, v, f.at(v), motion, NewtonStep{1, 0}, 30);
  EXPECT_EQ(x.y, 0);
  EXPECT_EQ(x.z, 0);
  SimdRing ring = f.simd(v);
  EXPECT_LT(std::fabs(ring.model(x).gradient.x), 1e-5);
}

TEST(GradientStep, FindsTheSameMinimum) {
  Fixture f(test::cube(3, 0.2));
  const Index v = inner_vertex(3);
  const MotionSpace motion{VertexDof::free, {}};
  const Vec3 newton = converge(f, v, f.at(v), motion, NewtonStep{1, 0}, 30);
  const Vec3 gradient = converge(f, v, f.at(v), motion, GradientStep{1e-9}, 200);
  EXPECT_NEAR(norm(newton - gradient), 0, 1e-4);
}

TEST(NewtonStep, OpensASliverInOneVisit) {
  // The vertex is at a distance of 1e-10 inside one face of its ring.
  Fixture f(test::cube(3));
  const Index v = inner_vertex(3);
  const LinkFace face = f.rings.faces.span()[f.rings.offsets.span()[v]];
  const Vec3 center = (1.0 / 3) * (f.at(face.v[0]) + f.at(face.v[1]) + f.at(face.v[2]));
  const Vec3 x = center + 1e-10 * (f.at(v) - center);
  SimdRing ring = f.simd(v);
  ASSERT_TRUE(ring.value(x).certified);
  const double best = ring.value(converge(f, v, f.at(v), {VertexDof::free, {}}, NewtonStep{1, 0}, 50)).value;
  ASSERT_GT(ring.value(x).value, 1e10);
  const StepResult r = NewtonStep{1.6, 1e-10}(ring, x, {VertexDof::free, {}});
  EXPECT_LT(ring.value(r.position).value, 10 * best);
}

TEST(NewtonStep, LeavesAVolumeBelowTheRoundingError) {
  int tried = 0;
  Fixture f(test::cube(3, 0.2));
  const Index v = inner_vertex(3);
  for (Size i = f.rings.offsets.span()[v]; i < f.rings.offsets.span()[v + 1]; ++i) {
    const LinkFace face = f.rings.faces.span()[i];
    const Vec3 center = (1.0 / 3) * (f.at(face.v[0]) + f.at(face.v[1]) + f.at(face.v[2]));
    const Vec3 x = center + 1e-16 * (f.at(v) - center);
    const auto p3 = [](const Vec3& p) { return Point3{p.x, p.y, p.z}; };
    if (orient_sign(p3(x), p3(f.at(face.v[0])), p3(f.at(face.v[1])), p3(f.at(face.v[2]))) <= 0) continue;
    ++tried;
    SimdRing ring = f.simd(v);
    PlainRing<> plain = f.plain(v);
    ASSERT_FALSE(ring.value(x).certified);
    const StepResult r = NewtonStep{1.6, 1e-10}(ring, x, {VertexDof::free, {}});
    EXPECT_TRUE(ring.value(r.position).certified);
    EXPECT_LT(ring.value(r.position).value, 1e4);
    EXPECT_TRUE(plain.value(NewtonStep{1.6, 1e-10}(plain, x, {VertexDof::free, {}}).position).certified);
  }
  EXPECT_GT(tried, 5);
}

TEST(Steps, OfAFixedVertexDoNothing) {
  Fixture f(test::cube(3, 0.2));
  const Index v = inner_vertex(3);
  SimdRing ring = f.simd(v);
  EXPECT_EQ(NewtonStep({1.6, 1e-10})(ring, f.at(v), {VertexDof::fixed, {}}).decrease, 0);
  EXPECT_EQ(GradientStep{1e-5}(ring, f.at(v), {VertexDof::fixed, {}}).decrease, 0);
}

void expect_proper(Fixture& f, const Coloring<backend::Cpu>& coloring, Span<const VertexDof> dof) {
  for (Size v = 0; v < dof.size(); ++v) {
    const std::uint8_t c = coloring.color.span()[v];
    if (dof[v] == VertexDof::fixed) continue;
    ASSERT_LT(c, 128);
    for (Size i = f.rings.offsets.span()[v]; i < f.rings.offsets.span()[v + 1]; ++i) {
      for (const Index w : f.rings.faces.span()[i].v) ASSERT_NE(coloring.color.span()[w], c);
    }
  }
}

TEST(Coloring, IsOfIndependentSetsWithEachMovableVertexInOne) {
  Fixture f(test::cube(6, 0.2));
  const Size n = f.work.vertices();
  std::vector<VertexDof> host(static_cast<std::size_t>(n), VertexDof::free);
  host[0] = host[100] = VertexDof::fixed;
  backend::Cpu::Buffer<VertexDof> dof;
  dof.upload(backend::Cpu(1), host);
  std::vector<std::uint8_t> first_run;
  for (const int threads : {1, 2, 3}) {
    Coloring<backend::Cpu> coloring;
    color_vertices(backend::Cpu(threads), f.rings.view(), dof.span(), coloring);
    expect_proper(f, coloring, dof.span());
    EXPECT_EQ(coloring.vertices.size(), n - 2);
    EXPECT_LE(coloring.colors(), 16);
    std::vector<int> seen(static_cast<std::size_t>(n), 0);
    for (Size i = 0; i < coloring.vertices.size(); ++i) ++seen[static_cast<std::size_t>(coloring.vertices.span()[i])];
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), n - 2);
    if (first_run.empty()) first_run = coloring.color.download();
    EXPECT_EQ(coloring.color.download(), first_run);
  }
}

/// Neighbors on a line need not share a tetrahedron; the bound on the deviation reads the positions of both.
TEST(Coloring, SeparatesNeighborsOnLines) {
  Fixture f(test::cube(6, 0.2));
  build_adjacency(backend::Cpu(1), f.work);
  const Index n = static_cast<Index>(f.work.vertices());
  backend::Cpu::Buffer<VertexDof> dof;
  dof.upload(backend::Cpu(1), std::vector<VertexDof>(static_cast<std::size_t>(n), VertexDof::curve));
  constexpr Index kFar = 25;
  std::vector<LineVertex> line;
  for (Index v = 0; v < n; ++v) line.push_back({{v - kFar, v + kFar < n ? v + kFar : -1}});
  const std::vector<std::uint32_t> offsets(static_cast<std::size_t>(n) + 1, 0);
  ReferenceView surface;
  surface.vertex2corner.offsets = span_of(offsets);
  surface.line = span_of(line);
  const auto equal_colors = [&](const ReferenceView& adjacency) {
    Rings<backend::Cpu> rings;
    build_rings(backend::Cpu(1), f.work, rings);
    Coloring<backend::Cpu> coloring;
    color_vertices(backend::Cpu(1), rings.view(), dof.span(), coloring, adjacency);
    const std::vector<std::uint8_t> color = coloring.color.download();
    int count = 0;
    for (Index v = kFar; v < n; ++v) {
      count += color[static_cast<std::size_t>(v)] == color[static_cast<std::size_t>(v - kFar)] ? 1 : 0;
    }
    return count;
  };
  EXPECT_GT(equal_colors({}), 10);
  EXPECT_EQ(equal_colors(surface), 0);
}

TEST(Coloring, WithASurfaceSeparatesItsVerticesByThreeEdges) {
  const TetMesh mesh = test::cube(6, 0.2);
  Fixture f(mesh);
  build_adjacency(backend::Cpu(1), f.work);
  const auto n = static_cast<std::size_t>(f.work.vertices());
  backend::Cpu::Buffer<VertexDof> dof;
  dof.upload(backend::Cpu(1), std::vector<VertexDof>(n, VertexDof::surface));
  // The boundary of the mesh, in work vertices.
  std::vector<SurfaceTriangle> triangles;
  const auto tets = f.work.tet2vertex.download();
  const auto adjacency = f.work.tet2tet.download();
  std::vector<std::vector<std::uint32_t>> corners(n);
  for (std::size_t t = 0; t < tets.size(); ++t) {
    for (int face = 0; face < 4; ++face) {
      if (adjacency[t][face] != kNoHalfFace) continue;
      SurfaceTriangle triangle;
      for (int k = 0; k < 3; ++k) triangle.v[k] = tets[t][face_vertex(face, k)];
      // Triangles within one patch may be oriented differently.
      if (triangles.size() % 3 == 0) std::swap(triangle.v[0], triangle.v[1]);
      for (int k = 0; k < 3; ++k) {
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
  ReferenceView surface;
  surface.triangles = span_of(triangles);
  surface.vertex2corner = {span_of(offsets), span_of(items)};
  surface.line = span_of(line);
  std::vector<Index> across(3 * triangles.size());
  find_across(backend::Cpu(1), surface.triangles, surface.vertex2corner, span_of(across));
  for (std::size_t c = 0; c < across.size(); c += 7) {
    if (across[c] == kFeatureEdge) continue;
    across[static_cast<std::size_t>(across[c])] = kFeatureEdge;
    across[c] = kFeatureEdge;
  }
  surface.across = span_of(across);
  const auto too_near = [&](const Coloring<backend::Cpu>& coloring) {
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
  Coloring<backend::Cpu> plain;
  color_vertices(backend::Cpu(2), f.rings.view(), dof.span(), plain);
  EXPECT_GT(too_near(plain), 0);
  for (const int threads : {1, 3}) {
    Coloring<backend::Cpu> coloring;
    color_vertices(backend::Cpu(threads), f.rings.view(), dof.span(), coloring, surface);
    expect_proper(f, coloring, dof.span());
    const std::vector<std::uint8_t> before = coloring.color.download();
    EXPECT_EQ(too_near(coloring), 0);
    EXPECT_EQ(coloring.vertices.size(), static_cast<Size>(n));
    // Rings change: new colors are separated as well.
    Fixture flipped(test::scrambled(mesh, 3));
    color_vertices(backend::Cpu(threads), flipped.rings.view(), dof.span(), coloring, surface);
    expect_proper(flipped, coloring, dof.span());
    EXPECT_EQ(too_near(coloring), 0);
    EXPECT_NE(coloring.color.download(), before);
  }
}

/// Of more vertices than there are colors, all neighbors of each other, the others do not move.
TEST(Coloring, VerticesForWhichThereIsNoColorGetNone) {
  constexpr Index kVertices = 150;
  std::vector<std::uint32_t> offsets{0};
  std::vector<LinkFace> faces;
  for (Index v = 0; v < kVertices; ++v) {
    for (Index i = 1; i + 2 < kVertices; ++i) {
      faces.push_back({{(v + i) % kVertices, (v + i + 1) % kVertices, (v + i + 2) % kVertices}});
    }
    offsets.push_back(static_cast<std::uint32_t>(faces.size()));
  }
  const std::vector<VertexDof> dof(kVertices, VertexDof::free);
  const RingsView rings{span_of(std::as_const(offsets)), span_of(std::as_const(faces))};
  for (const int threads : {1, 3}) {
    const backend::Cpu cpu(threads);
    Coloring<backend::Cpu> coloring;
    for (int again = 0; again < 2; ++again) {
      color_vertices(cpu, rings, span_of(dof), coloring);
      EXPECT_EQ(coloring.colors(), 128);
      EXPECT_EQ(coloring.vertices.size(), 128);
      std::vector<std::uint8_t> colors = coloring.color.download();
      std::sort(colors.begin(), colors.end());
      EXPECT_EQ(std::unique(colors.begin(), colors.end()) - colors.begin(), 129);
    }
  }
}

TEST(Coloring, ResolvesConflictsAndKeepsOtherColors) {
  Fixture f(test::cube(6, 0.2));
  const Size n = f.work.vertices();
  backend::Cpu::Buffer<VertexDof> dof;
  dof.upload(backend::Cpu(1), std::vector<VertexDof>(static_cast<std::size_t>(n), VertexDof::free));
  Coloring<backend::Cpu> coloring;
  color_vertices(backend::Cpu(2), f.rings.view(), dof.span(), coloring);
  auto broken = coloring.color.download();
  std::fill(broken.begin(), broken.begin() + 100, std::uint8_t{3});
  coloring.color.upload(backend::Cpu(1), broken);
  color_vertices(backend::Cpu(2), f.rings.view(), dof.span(), coloring);
  expect_proper(f, coloring, dof.span());
  int kept = 0;
  for (std::size_t v = 150; v < broken.size(); ++v)
    kept += coloring.color.span()[static_cast<Size>(v)] == broken[v] ? 1 : 0;
  EXPECT_GT(kept, static_cast<int>(broken.size()) - 200);
}

}  // namespace
}  // namespace tetune

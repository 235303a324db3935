// SPDX-License-Identifier: Apache-2.0
// Motion of a vertex on the reference surface (Sect. 4.3): the element of steepest descent (Alg. 3), steps (Alg. 4).
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "boundary/sliding/trace.hpp"
#include "support/surface.hpp"

namespace tetune {
namespace {

using test::descent;
using test::flat;
using test::folded;
using test::height_field;
using test::random_vec;
using test::TinySurface;
using test::uniform;

/// Alg. 3 as printed, except for its lines 33 to 35 (in a triangle, the result is that triangle): the largest
/// derivative among all adjacent triangles and edges whose descent leads into them.
double steepest_by_listing(const TinySurface& s, const SurfacePoint& surface_point, const Vec3& g) {
  const ReferenceView ref = s.view();
  double best = 0;
  const auto normal = [&](Index t) {
    const SurfaceTriangle v = ref.triangles[t];
    const Vec3 n = cross(ref.point(v.v[1]) - ref.point(v.v[0]), ref.point(v.v[2]) - ref.point(v.v[0]));
    return (1 / norm(n)) * n;
  };
  const auto in_triangle = [&](Index t, const Vec3& x) {
    const Vec3 n = normal(t);
    const Vec3 steepest = dot(g, n) * n - g;
    const Vec3 y = x + (1e-6 / norm(steepest)) * steepest;
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = ref.point(ref.triangles[t].v[k]);
      const Vec3 b = ref.point(ref.triangles[t].v[(k + 1) % 3]);
      if (dot(cross(b - a, y - a), n) < -1e-12) return;
    }
    best = std::max(best, norm(steepest));
  };
  const auto along = [&](const Vec3& from, const Vec3& to) {
    const Vec3 unit = (1 / norm(to - from)) * (to - from);
    best = std::max(best, -dot(g, unit));
  };
  if (surface_point.kind == SurfacePointKind::vertex) {
    const Vec3 x = ref.point(surface_point.item);
    for (Size t = 0; t < ref.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        if (ref.triangles[t].v[k] != surface_point.item) continue;
        in_triangle(static_cast<Index>(t), x);
        for (int o = 1; o < 3; ++o) along(x, ref.point(ref.triangles[t].v[(k + o) % 3]));
      }
    }
  } else if (surface_point.kind == SurfacePointKind::edge) {
    const EdgeVertices e = edge_vertices(ref, surface_point);
    const Vec3 x = 0.5 * (ref.point(e.a) + ref.point(e.b));
    in_triangle(surface_point.item / 3, x);
    if (ref.across[surface_point.item] != kFeatureEdge) in_triangle(ref.across[surface_point.item] / 3, x);
    along(ref.point(e.a), ref.point(e.b));
    along(ref.point(e.b), ref.point(e.a));
  } else {
    const Vec3 n = normal(surface_point.item);
    best = norm(g - dot(g, n) * n);
  }
  return best;
}

/// A fan of n triangles at vertex 0 with random heights.
TinySurface fan(int n, double height, std::mt19937& random) {
  std::vector<Vec3> points{{0, 0, height * (2 * uniform(random) - 1)}};
  std::vector<std::array<Index, 3>> triangles;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.4 * uniform(random)) / n;
    points.push_back({std::cos(angle), std::sin(angle), height * (2 * uniform(random) - 1)});
    triangles.push_back({0, static_cast<Index>(1 + i), static_cast<Index>(1 + (i + 1) % n)});
  }
  return {points, triangles};
}

TEST(Steepest, AtAVertexIsTheLargestDerivativeOfItsElements) {
  std::mt19937 random(1);
  int on_edges = 0;
  for (int i = 0; i < 2000; ++i) {
    const double heights[] = {0, 0.3, 1, 4};
    const TinySurface s = fan(3 + i % 6, heights[i % 4], random);
    const Vec3 g = random_vec(random);
    const SurfaceElement best = steepest(s.view(), VertexDof::surface, {SurfacePointKind::vertex, 0}, g);
    EXPECT_NEAR(norm(descent(best)), steepest_by_listing(s, {SurfacePointKind::vertex, 0}, g), 1e-12) << i;
    EXPECT_GE(-dot(descent(best), g), 0);
    on_edges += best.on.kind == SurfacePointKind::edge ? 1 : 0;
  }
  EXPECT_GT(on_edges, 50);
}

TEST(Steepest, OnAPlaneIsTheNegativeGradientAtAnySurfacePoint) {
  std::mt19937 random(2);
  const TinySurface s = height_field(2, flat);
  for (int i = 0; i < 300; ++i) {
    const Vec3 g = random_vec(random);
    for (const SurfacePoint& surface_point :
         {SurfacePoint{SurfacePointKind::vertex, 4}, SurfacePoint{SurfacePointKind::triangle, 3}}) {
      EXPECT_NEAR(norm(descent(steepest(s.view(), VertexDof::surface, surface_point, g)) - Vec3{-g.x, -g.y, 0}), 0,
                  1e-14);
    }
    // Inner edges: from one of the two triangles.
    for (Index c = 0; c < 24; ++c) {
      if (s.across[static_cast<std::size_t>(c)] == kFeatureEdge) continue;
      const SurfaceElement best = steepest(s.view(), VertexDof::surface, {SurfacePointKind::edge, c}, g);
      EXPECT_NEAR(norm(descent(best) - Vec3{-g.x, -g.y, 0}), 0, 1e-14);
      EXPECT_TRUE(best.on.item == c / 3 || best.on.item == s.across[static_cast<std::size_t>(c)] / 3);
    }
  }
}

TEST(Steepest, OnAnEdgeIsTheLargestDerivativeOfItAndItsTriangles) {
  std::mt19937 random(3);
  int along = 0;
  for (int i = 0; i < 1000; ++i) {
    const TinySurface s = folded(3 * (2 * uniform(random) - 1));
    const Vec3 g = random_vec(random);
    const SurfacePoint surface_point{SurfacePointKind::edge, 2};
    const SurfaceElement best = steepest(s.view(), VertexDof::surface, surface_point, g);
    EXPECT_NEAR(norm(descent(best)), steepest_by_listing(s, surface_point, g), 1e-13);
    along += best.on.kind == SurfacePointKind::edge ? 1 : 0;
  }
  EXPECT_GT(along, 100);  // the bottom of a valley
}

TEST(Steepest, DoesNotCrossAFeatureEdge) {
  const TinySurface s({{0, 0, 0}, {0, 1, 0}, {-1, 0.5, 0}, {1, 0.5, 0}}, {{0, 1, 2}, {1, 0, 3}}, {{0, 1}});
  // The energy increases to the left, so the descent leads to the right, across the feature edge.
  const SurfaceElement best = steepest(s.view(), VertexDof::surface, {SurfacePointKind::edge, 2}, {-1, 0.1, 0});
  EXPECT_EQ(best.on.kind, SurfacePointKind::edge);
  EXPECT_EQ(steepest(s.view(), VertexDof::surface, {SurfacePointKind::edge, 2}, {1, 0.1, 0}).on.item, 0);
}

TEST(Steepest, AtAVertexOfAFeatureLineLeadsAlongIt) {
  TinySurface s({{0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {1, 2, 3}}, {});
  s.add_line({0, 1, 2, 3});
  EXPECT_EQ(s.dof[0], VertexDof::surface);  // unused: there is no triangle
  const SurfaceElement towards_2 = steepest(s.view(), VertexDof::curve, {SurfacePointKind::vertex, 1}, {2, -1, 5});
  EXPECT_EQ(towards_2.on.kind, SurfacePointKind::segment);
  // The descent towards vertex 0 has length 2, that towards vertex 2 only 1.
  EXPECT_NEAR(norm(descent(towards_2) - Vec3{-2, 0, 0}), 0, 1e-15);
  EXPECT_NEAR(
      norm(descent(steepest(s.view(), VertexDof::curve, {SurfacePointKind::vertex, 1}, {1, -2, 5})) - Vec3{0, 2, 0}), 0,
      1e-15);
  EXPECT_EQ(steepest(s.view(), VertexDof::curve, {SurfacePointKind::vertex, 1}, {-1, 2, 5}).on.kind,
            SurfacePointKind::none);
  // Between two vertices both directions are possible.
  for (const double g : {3.0, -3.0}) {
    const SurfaceElement p = steepest(s.view(), VertexDof::curve, {SurfacePointKind::segment, 2 * 1 + 1}, {7, g, 7});
    EXPECT_NEAR(norm(descent(p) - Vec3{0, -g, 0}), 0, 1e-15);
  }
}

TEST(Steepest, SkipsDegenerateTriangles) {
  // The vertices 0, 1, 2 are collinear; 0, 2, 3 are not.
  const TinySurface s({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}}, {{0, 1, 2}, {0, 2, 3}});
  const SurfaceElement up = steepest(s.view(), VertexDof::surface, {SurfacePointKind::vertex, 0}, {-2, -1, 0});
  EXPECT_EQ(up.on.kind, SurfacePointKind::triangle);
  EXPECT_EQ(up.on.item, 1);
  const SurfaceElement along_edge = steepest(s.view(), VertexDof::surface, {SurfacePointKind::vertex, 0}, {-1, 5, 0});
  EXPECT_EQ(along_edge.on.kind, SurfacePointKind::edge);
  EXPECT_EQ(steepest(s.view(), VertexDof::surface, {SurfacePointKind::triangle, 0}, {1, 1, 1}).on.kind,
            SurfacePointKind::none);
  // All vertices of the triangle coincide.
  const TinySurface point({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {{0, 1, 2}});
  EXPECT_EQ(steepest(point.view(), VertexDof::surface, {SurfacePointKind::vertex, 0}, {1, 1, 1}).on.kind,
            SurfacePointKind::none);
}

TEST(Advance, EndsInsideOrOnAnEdgeOrVertex) {
  // Alg. 4 on the triangle (0, 1, 2) of a flat grid.
  TinySurface s = height_field(3, flat);
  std::fill(s.dof.begin(), s.dof.end(), VertexDof::surface);
  const ReferenceView ref = s.view();
  const SurfacePoint inside{SurfacePointKind::triangle, 0};
  const SurfaceElement element(ref, inside, {});
  const Vec3 y{0.2, 0.1, 0};  // in the triangle (0, 0), (1/3, 0), (1/3, 1/3)
  const auto tangent = [&](const Vec3& p) {
    const Frame& f = element.frame;
    return TangentVector{f.inverse_u2 * dot(f.u, p), f.inverse_v2 * dot(f.v, p)};
  };
  const auto move = [&](const Vec3& p, double t) {
    return advance(ref, {y, inside, VertexDof::surface}, element, tangent(p), t);
  };

  const TraceResult within = move({0.1, 0, 0}, 1);
  EXPECT_EQ(within.surface_point.kind, SurfacePointKind::triangle);
  EXPECT_EQ(within.t, 1);
  EXPECT_FALSE(within.at_boundary);
  EXPECT_NEAR(norm(within.position - Vec3{0.3, 0.1, 0}), 0, 1e-16);

  const TraceResult on_edge = move({0.1, 0, 0}, 100);
  EXPECT_EQ(on_edge.surface_point.kind, SurfacePointKind::edge);
  EXPECT_EQ(on_edge.surface_point.item, 0);  // opposite corner 0
  EXPECT_TRUE(on_edge.at_boundary);
  EXPECT_NEAR(on_edge.t, (1.0 / 3 - 0.2) / 0.1, 1e-14);
  EXPECT_NEAR(norm(on_edge.position - Vec3{1.0 / 3, 0.1, 0}), 0, 1e-16);

  const TraceResult on_vertex = move(vec(s.points[5]) - y, 100);  // (1/3, 1/3)
  EXPECT_EQ(on_vertex.surface_point.kind, SurfacePointKind::vertex);
  EXPECT_EQ(on_vertex.surface_point.item, 5);
  EXPECT_EQ(norm(on_vertex.position - vec(s.points[5])), 0);  // to the last bit

  // The lower edge is a feature: the step ends before it.
  const TraceResult at_feature = move({0, -0.1, 0}, 100);
  EXPECT_EQ(at_feature.surface_point.kind, SurfacePointKind::triangle);
  EXPECT_FALSE(at_feature.at_boundary);
  EXPECT_NEAR(at_feature.position.y, 0.001, 1e-15);

  // A vertex with other degrees of freedom is not reached either.
  s.dof[5] = VertexDof::fixed;
  const TraceResult at_corner =
      advance(s.view(), {y, inside, VertexDof::surface}, element, tangent(vec(s.points[5]) - y), 100);
  EXPECT_EQ(at_corner.surface_point.kind, SurfacePointKind::triangle);
  EXPECT_NEAR(at_corner.t, kStandoff, 1e-9);
}

TEST(Advance, AlongALineStopsAtItsVerticesAndBeforeItsCorner) {
  TinySurface s({{0, 0, 0}, {1, 0, 0}, {1, 2, 0}}, {});
  s.add_line({0, 1, 2});
  s.dof[0] = s.dof[2] = VertexDof::fixed;
  const SurfacePoint start{SurfacePointKind::vertex, 1};
  const TangentVector p{0.5, 0};  // the segment has length 2
  const SurfaceElement segment(s.view(), {SurfacePointKind::segment, 2 * 1 + 1}, {});
  const TraceResult inside = advance(s.view(), {{1, 0, 0}, start, VertexDof::curve}, segment, p, 0.5);
  EXPECT_EQ(inside.surface_point.kind, SurfacePointKind::segment);
  EXPECT_EQ(inside.position.y, 0.5);
  const TraceResult at_corner = advance(s.view(), {{1, 0, 0}, start, VertexDof::curve}, segment, p, 50);
  EXPECT_EQ(at_corner.surface_point.kind, SurfacePointKind::segment);
  EXPECT_FALSE(at_corner.at_boundary);
  EXPECT_NEAR(at_corner.position.y, 2 * kStandoff, 1e-15);
  const TraceResult back =
      advance(s.view(), {inside.position, inside.surface_point, VertexDof::curve}, segment, {-0.5, 0}, 50);
  EXPECT_EQ(back.surface_point.kind, SurfacePointKind::vertex);
  EXPECT_EQ(back.surface_point.item, 1);
  EXPECT_TRUE(back.at_boundary);
  EXPECT_EQ(back.t, 0.5);
}

}  // namespace
}  // namespace tetune

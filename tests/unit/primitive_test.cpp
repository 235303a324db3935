// SPDX-License-Identifier: Apache-2.0
// Where a vertex goes on the input surface (Sect. 4.3): the steepest way (Alg. 3), moves and places (Alg. 4).
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "surface.hpp"
#include "surface/primitive.hpp"

namespace tetune {
namespace {

using test::descent;
using test::flat;
using test::folded;
using test::height_field;
using test::random_vec;
using test::TinySurface;
using test::uniform;

/// Alg. 3 word for word but for its lines 33 to 35 (on a triangle, that triangle): the largest derivative among all
/// adjacent triangles and edges whose descent leads into them.
double steepest_by_listing(const TinySurface& s, const Site& site, const Vec3& g) {
  const ReferenceView ref = s.view();
  double best = 0;
  const auto normal = [&](Index t) {
    const SurfaceTriangle v = ref.triangles[t];
    const Vec3 n = cross(ref.point(v.v[1]) - ref.point(v.v[0]), ref.point(v.v[2]) - ref.point(v.v[0]));
    return (1 / norm(n)) * n;
  };
  const auto in_triangle = [&](Index t, const Vec3& x) {
    const Vec3 n = normal(t);
    const Vec3 down = dot(g, n) * n - g;
    const Vec3 y = x + (1e-6 / norm(down)) * down;
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = ref.point(ref.triangles[t].v[k]);
      const Vec3 b = ref.point(ref.triangles[t].v[(k + 1) % 3]);
      if (dot(cross(b - a, y - a), n) < -1e-12) return;
    }
    best = std::max(best, norm(down));
  };
  const auto along = [&](const Vec3& from, const Vec3& to, bool both) {
    const Vec3 unit = (1 / norm(to - from)) * (to - from);
    if (both || dot(g, unit) < 0) best = std::max(best, std::fabs(dot(g, unit)));
  };
  if (site.kind == SiteKind::vertex) {
    const Vec3 x = ref.point(site.item);
    for (Size t = 0; t < ref.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        if (ref.triangles[t].v[k] != site.item) continue;
        in_triangle(static_cast<Index>(t), x);
        for (int o = 1; o < 3; ++o) along(x, ref.point(ref.triangles[t].v[(k + o) % 3]), false);
      }
    }
  } else if (site.kind == SiteKind::edge) {
    const Ends e = ends_of(ref, site);
    const Vec3 x = 0.5 * (ref.point(e.a) + ref.point(e.b));
    in_triangle(site.item / 3, x);
    if (ref.across[site.item] != kWall) in_triangle(ref.across[site.item] / 3, x);
    along(ref.point(e.a), ref.point(e.b), true);
  } else {
    const Vec3 n = normal(site.item);
    best = norm(g - dot(g, n) * n);
  }
  return best;
}

/// A fan around vertex 0 with `n` vertices at random heights.
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

TEST(Steepest, OfAVertexIsTheLargestDerivativeAround) {
  std::mt19937 random(1);
  int on_edges = 0;
  for (int i = 0; i < 2000; ++i) {
    const double heights[] = {0, 0.3, 1, 4};
    const TinySurface s = fan(3 + i % 6, heights[i % 4], random);
    const Vec3 g = random_vec(random);
    const Primitive best = steepest(s.view(), Mobility::surface, {SiteKind::vertex, 0}, g);
    EXPECT_NEAR(norm(descent(best)), steepest_by_listing(s, {SiteKind::vertex, 0}, g), 1e-12) << i;
    EXPECT_GE(-dot(descent(best), g), 0);
    on_edges += best.on.kind == SiteKind::edge ? 1 : 0;
  }
  EXPECT_GT(on_edges, 50);
}

TEST(Steepest, OnAPlaneIsTheGradientWhereverTheSite) {
  std::mt19937 random(2);
  const TinySurface s = height_field(2, flat);
  for (int i = 0; i < 300; ++i) {
    const Vec3 g = random_vec(random);
    for (const Site& site : {Site{SiteKind::vertex, 4}, Site{SiteKind::triangle, 3}}) {
      EXPECT_NEAR(norm(descent(steepest(s.view(), Mobility::surface, site, g)) - Vec3{-g.x, -g.y, 0}), 0, 1e-14);
    }
    // Inner edges: from one of the two triangles.
    for (Index c = 0; c < 24; ++c) {
      if (s.across[static_cast<std::size_t>(c)] == kWall) continue;
      const Primitive best = steepest(s.view(), Mobility::surface, {SiteKind::edge, c}, g);
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
    const Site site{SiteKind::edge, 2};
    const Primitive best = steepest(s.view(), Mobility::surface, site, g);
    EXPECT_NEAR(norm(descent(best)), steepest_by_listing(s, site, g), 1e-13);
    along += best.on.kind == SiteKind::edge ? 1 : 0;
  }
  EXPECT_GT(along, 100);  // the bottom of a valley
}

TEST(Steepest, DoesNotCrossAWall) {
  const TinySurface s({{0, 0, 0}, {0, 1, 0}, {-1, 0.5, 0}, {1, 0.5, 0}}, {{0, 1, 2}, {1, 0, 3}}, {{0, 1}});
  // Uphill is to the left, so down is to the right, across the wall.
  const Primitive best = steepest(s.view(), Mobility::surface, {SiteKind::edge, 2}, {-1, 0.1, 0});
  EXPECT_EQ(best.on.kind, SiteKind::edge);
  EXPECT_EQ(steepest(s.view(), Mobility::surface, {SiteKind::edge, 2}, {1, 0.1, 0}).on.item, 0);
}

TEST(Steepest, OfAVertexOnAFeatureLineLeadsAlongIt) {
  TinySurface s({{0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {1, 2, 3}}, {});
  s.add_line({0, 1, 2, 3});
  EXPECT_EQ(s.kind[0], Mobility::surface);  // no triangle: the test does not ask
  const Primitive towards_2 = steepest(s.view(), Mobility::curve, {SiteKind::vertex, 1}, {2, -1, 5});
  EXPECT_EQ(towards_2.on.kind, SiteKind::segment);
  // Down along (0,1)-(1,1) is 2 long, towards vertex 0; along (1)-(2) only 1.
  EXPECT_NEAR(norm(descent(towards_2) - Vec3{-2, 0, 0}), 0, 1e-15);
  EXPECT_NEAR(norm(descent(steepest(s.view(), Mobility::curve, {SiteKind::vertex, 1}, {1, -2, 5})) - Vec3{0, 2, 0}), 0,
              1e-15);
  EXPECT_EQ(steepest(s.view(), Mobility::curve, {SiteKind::vertex, 1}, {-1, 2, 5}).on.kind, SiteKind::none);
  // Between two vertices: either way.
  for (const double g : {3.0, -3.0}) {
    const Primitive p = steepest(s.view(), Mobility::curve, {SiteKind::segment, 2 * 1 + 1}, {7, g, 7});
    EXPECT_NEAR(norm(descent(p) - Vec3{0, -g, 0}), 0, 1e-15);
  }
}

TEST(Steepest, PassesOverDegenerateTriangles) {
  // The triangle (0, 1, 2) is flat on a line; (0, 2, 3) is not.
  const TinySurface s({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}}, {{0, 1, 2}, {0, 2, 3}});
  const Primitive up = steepest(s.view(), Mobility::surface, {SiteKind::vertex, 0}, {-2, -1, 0});
  EXPECT_EQ(up.on.kind, SiteKind::triangle);
  EXPECT_EQ(up.on.item, 1);
  const Primitive aside = steepest(s.view(), Mobility::surface, {SiteKind::vertex, 0}, {-1, 5, 0});
  EXPECT_EQ(aside.on.kind, SiteKind::edge);
  EXPECT_EQ(steepest(s.view(), Mobility::surface, {SiteKind::triangle, 0}, {1, 1, 1}).on.kind, SiteKind::none);
  // A point for a triangle, an edge without length.
  const TinySurface point({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {{0, 1, 2}});
  EXPECT_EQ(steepest(point.view(), Mobility::surface, {SiteKind::vertex, 0}, {1, 1, 1}).on.kind, SiteKind::none);
}

TEST(Advance, EndsInsideOnAnEdgeOrOnAVertex) {
  // Alg. 4 on the triangle (0, 1, 2) of a flat grid.
  TinySurface s = height_field(3, flat);
  std::fill(s.kind.begin(), s.kind.end(), Mobility::surface);
  const ReferenceView ref = s.view();
  const Site inside{SiteKind::triangle, 0};
  const Primitive primitive(ref, inside, {});
  const Vec3 y{0.2, 0.1, 0};  // of the triangle (0, 0), (1/3, 0), (1/3, 1/3)
  const auto way = [&](const Vec3& p) {
    const Frame& f = primitive.frame;
    return Way{f.inverse_along2 * dot(f.along, p), f.inverse_aside2 * dot(f.aside, p)};
  };
  const auto move = [&](const Vec3& p, double t) {
    return advance(ref, Mobility::surface, primitive, inside, y, way(p), t);
  };

  const Landing short_of_it = move({0.1, 0, 0}, 1);
  EXPECT_EQ(short_of_it.site.kind, SiteKind::triangle);
  EXPECT_EQ(short_of_it.t, 1);
  EXPECT_FALSE(short_of_it.at_rim);
  EXPECT_NEAR(norm(short_of_it.at - Vec3{0.3, 0.1, 0}), 0, 1e-16);

  const Landing on_edge = move({0.1, 0, 0}, 100);
  EXPECT_EQ(on_edge.site.kind, SiteKind::edge);
  EXPECT_EQ(on_edge.site.item, 0);  // opposite corner 0
  EXPECT_TRUE(on_edge.at_rim);
  EXPECT_NEAR(on_edge.t, (1.0 / 3 - 0.2) / 0.1, 1e-14);
  EXPECT_NEAR(norm(on_edge.at - Vec3{1.0 / 3, 0.1, 0}), 0, 1e-16);

  const Landing on_vertex = move(vec(s.points[5]) - y, 100);  // (1/3, 1/3)
  EXPECT_EQ(on_vertex.site.kind, SiteKind::vertex);
  EXPECT_EQ(on_vertex.site.item, 5);
  EXPECT_EQ(norm(on_vertex.at - vec(s.points[5])), 0);  // to the last bit

  // The lower edge is a wall: short of it.
  const Landing at_wall = move({0, -0.1, 0}, 100);
  EXPECT_EQ(at_wall.site.kind, SiteKind::triangle);
  EXPECT_FALSE(at_wall.at_rim);
  EXPECT_NEAR(at_wall.at.y, 0.001, 1e-15);

  // Nor onto a vertex of another kind.
  s.kind[5] = Mobility::fixed;
  const Landing at_corner = advance(s.view(), Mobility::surface, primitive, inside, y, way(vec(s.points[5]) - y), 100);
  EXPECT_EQ(at_corner.site.kind, SiteKind::triangle);
  EXPECT_NEAR(at_corner.t, kShort, 1e-9);
}

TEST(Advance, AlongALineStopsAtItsVerticesAndShortOfItsCorner) {
  TinySurface s({{0, 0, 0}, {1, 0, 0}, {1, 2, 0}}, {});
  s.add_line({0, 1, 2});
  s.kind[0] = s.kind[2] = Mobility::fixed;
  const Site start{SiteKind::vertex, 1};
  const Way p{0.5, 0};  // of a segment of length 2
  const Primitive segment(s.view(), {SiteKind::segment, 2 * 1 + 1}, {});
  const Landing inside = advance(s.view(), Mobility::curve, segment, start, {1, 0, 0}, p, 0.5);
  EXPECT_EQ(inside.site.kind, SiteKind::segment);
  EXPECT_EQ(inside.at.y, 0.5);
  const Landing at_corner = advance(s.view(), Mobility::curve, segment, start, {1, 0, 0}, p, 50);
  EXPECT_EQ(at_corner.site.kind, SiteKind::segment);
  EXPECT_FALSE(at_corner.at_rim);
  EXPECT_NEAR(at_corner.at.y, 2 * kShort, 1e-15);
  const Landing back = advance(s.view(), Mobility::curve, segment, inside.site, inside.at, {-0.5, 0}, 50);
  EXPECT_EQ(back.site.kind, SiteKind::vertex);
  EXPECT_EQ(back.site.item, 1);
  EXPECT_TRUE(back.at_rim);
  EXPECT_EQ(back.t, 0.5);
}

}  // namespace
}  // namespace tetune

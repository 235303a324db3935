// SPDX-License-Identifier: Apache-2.0
// One vertex on the input surface (Sect. 4.3): descent (Alg. 3), moves and places (Alg. 4), walks, the bound.
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "boundary/closest_triangle.hpp"
#include "relocate/slide.hpp"
#include "surface.hpp"

namespace tetune {
namespace {

using test::height_field;
using test::TinySurface;

constexpr double kFarAway = 1e3;

double uniform(std::mt19937& random) { return static_cast<double>(random()) / 4294967296.0; }
Vec3 random_vec(std::mt19937& random) {
  const double x = 2 * uniform(random) - 1;
  const double y = 2 * uniform(random) - 1;
  return {x, y, 2 * uniform(random) - 1};
}

double flat(double, double) { return 0; }
double bumpy(double x, double y) { return 0.08 * std::sin(7 * x) * std::cos(5 * y + 1); }

/// Stands for a ring: a quadratic energy over all of space, or over a ball.
struct Bowl {
  Vec3 lowest;
  Sym3 hessian;
  double radius = kFarAway;

  RingModel model(const Vec3& x) const { return {value(x).value, hessian * (x - lowest), hessian, 100}; }
  double step_bound(const Vec3&, const Vec3&) const { return std::numeric_limits<double>::infinity(); }
  RingValue value(const Vec3& x) const {
    const Vec3 d = x - lowest;
    return {1 + 0.5 * dot(d, hessian * d), norm(d) < radius};
  }
  struct Ray {
    const Bowl& bowl;
    Vec3 x, p;
    double value(double t) const { return bowl.value(x + t * p).value; }
  };
  Ray ray(const Vec3& x, const Vec3& p) const { return {*this, x, p}; }
};
const Sym3 kRound{1, 1, 1, 0, 0, 0};

Bowl random_bowl(std::mt19937& random) {
  // B^T B of a random B, lifted.
  const Vec3 a = random_vec(random);
  const Vec3 b = random_vec(random);
  const Vec3 c = random_vec(random);
  const auto entry = [&](double ai, double aj, double bi, double bj, double ci, double cj) {
    return ai * aj + bi * bj + ci * cj;
  };
  return {{uniform(random), uniform(random), 0.3 * uniform(random) - 0.15},
          {entry(a.x, a.x, b.x, b.x, c.x, c.x) + 0.2, entry(a.y, a.y, b.y, b.y, c.y, c.y) + 0.2,
           entry(a.z, a.z, b.z, b.z, c.z, c.z) + 0.2, entry(a.x, a.y, b.x, b.y, c.x, c.y),
           entry(a.x, a.z, b.x, b.z, c.x, c.z), entry(a.y, a.z, b.y, b.z, c.y, c.z)}};
}

/// A vertex that slides on a surface, each visit in another ring.
struct Slider {
  const TinySurface& surface;
  Mobility walker;
  Vec3 x;
  Site site;
  std::vector<Point> mesh_points;
  std::vector<Site> mesh_sites;

  Slider(const TinySurface& s, Index v)
      : surface(s),
        walker(s.kind[static_cast<std::size_t>(v)]),
        x(vec(s.points[static_cast<std::size_t>(v)])),
        site{SiteKind::vertex, v},
        mesh_points(s.points),
        mesh_sites(s.points.size()) {}

  template <class Step>
  bool visit(const Step& step, Bowl bowl) {
    const DeviationBound anywhere(surface.view(), {mesh_points.data(), static_cast<Size>(mesh_points.size())},
                                  {mesh_sites.data(), static_cast<Size>(mesh_sites.size())}, 0, 0);
    const double before = bowl.value(x).value;
    const SlideResult r = step(bowl, x, site, walker, surface.view(), anywhere, Leash{});
    EXPECT_NEAR(r.step.decrease, before - bowl.value(r.step.position).value, 1e-12);
    EXPECT_GE(r.step.decrease, 0);
    if (r.step.decrease == 0) return false;
    x = r.step.position;
    site = r.site;
    return true;
  }
};
const NewtonSlide kNewton{1.6, 1e-14};
const NewtonSlide kPureNewton{1, 1e-14};
const GradientSlide kGradient{1e-12};

/// How far a position is from what its site says.
double off_site(const TinySurface& s, const Site& site, const Vec3& x) {
  const ReferenceView ref = s.view();
  if (site.kind == SiteKind::vertex) return norm(x - ref.point(site.item));
  if (site.kind == SiteKind::triangle) {
    const SurfaceTriangle t = ref.triangles[site.item];
    return std::sqrt(ClosestTriangle({{ref.point(t.v[0]), ref.point(t.v[1]), ref.point(t.v[2])}}).distance2(x));
  }
  const Ends e = ends_of(ref, site);
  return std::sqrt(ClosestTriangle({{ref.point(e.a), ref.point(e.b), ref.point(e.b)}}).distance2(x));
}

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

/// Two triangles over the common edge (0, 1), folded upwards at it.
TinySurface folded(double apex_height) {
  return {{{0, 0, 0}, {0, 1, 0}, {-1, 0.5, apex_height}, {1, 0.5, apex_height}}, {{0, 1, 2}, {1, 0, 3}}};
}

Vec3 descent(const Primitive& p) { return p.frame.in_space(p.down); }

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

TEST(NewtonDirection, EndsAtTheModelsMinimumOnThePrimitive) {
  std::mt19937 random(8);
  int along_edge = 0;
  for (int i = 0; i < 300; ++i) {
    const TinySurface s = folded(3 * (2 * uniform(random) - 1));
    const Bowl bowl = random_bowl(random);
    const Vec3 x{0.3 * uniform(random) - 0.4, uniform(random), uniform(random)};
    const Vec3 g = bowl.model(x).gradient;
    const Site site{SiteKind::triangle, i % 2};
    const Primitive inside = steepest(s.view(), Mobility::surface, site, g);
    const Frame& frame = inside.frame;
    const Vec3 p = frame.in_space(slide_detail::newton_direction(s.view(), bowl.hessian, site, inside));
    EXPECT_NEAR(dot(p, cross(frame.along, frame.edge2)), 0, 1e-12) << i;
    for (const Vec3& edge : {frame.along, frame.edge2}) EXPECT_NEAR(dot(g + bowl.hessian * p, edge), 0, 1e-11) << i;

    const Site edge{SiteKind::edge, 2};
    const Primitive along = steepest(s.view(), Mobility::surface, edge, g);
    if (along.on.kind != SiteKind::edge) continue;
    ++along_edge;
    const Vec3 q = along.frame.in_space(slide_detail::newton_direction(s.view(), bowl.hessian, edge, along));
    EXPECT_EQ(norm(cross(q, {0, 1, 0})), 0) << i;
    EXPECT_NEAR(g.y + (bowl.hessian * q).y, 0, 1e-12) << i;
  }
  EXPECT_GT(along_edge, 30);
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

TEST(Slide, OnAPlaneEndsAtThePlanarMinimumAcrossEdgesAndVertices) {
  std::mt19937 random(4);
  const TinySurface s = height_field(9, flat);
  int hops = 0;
  for (int i = 0; i < 300; ++i) {
    // Reachable in one visit: at most 16 hops.
    Bowl bowl = random_bowl(random);
    bowl.lowest = {0.3 + 0.4 * uniform(random), 0.3 + 0.4 * uniform(random), 0.1};
    if (i % 2 == 0) bowl.hessian = kRound;
    // Gradient in the plane vanishes at `goal`.
    const Sym3& h = bowl.hessian;
    const double det = h.xx * h.yy - h.xy * h.xy;
    const double rx = h.xz * bowl.lowest.z;
    const double ry = h.yz * bowl.lowest.z;
    const Vec3 goal{bowl.lowest.x + (h.yy * rx - h.xy * ry) / det, bowl.lowest.y + (h.xx * ry - h.xy * rx) / det, 0};
    if (goal.x < 0.05 || goal.x > 0.95 || goal.y < 0.05 || goal.y > 0.95) continue;
    Slider a(s, 4 * 10 + 5);
    a.visit(kPureNewton, bowl);
    if (i % 2 == 0) {
      EXPECT_LT(norm(a.x - goal), 1e-12);
      hops += a.site.item != 0 ? 1 : 0;
    }
    for (int k = 0; k < 30; ++k) a.visit(kPureNewton, bowl);
    EXPECT_LT(norm(a.x - goal), 1e-6);
    Slider b(s, 4 * 10 + 5);
    for (int k = 0; k < 60; ++k) b.visit(kNewton, bowl);
    EXPECT_LT(norm(b.x - goal), 1e-6);
    Slider c(s, 4 * 10 + 5);
    for (int k = 0; k < 2000 && c.visit(kGradient, bowl); ++k) continue;
    EXPECT_LT(norm(c.x - goal), 1e-3);
  }
  EXPECT_GT(hops, 50);
}

TEST(Slide, StaysOnABumpySurfaceToTheLastBitOverManyVisits) {
  std::mt19937 random(5);
  const TinySurface s = height_field(8, bumpy);
  const auto check = [&](const auto& step, std::size_t least) {
    Slider v(s, 4 * 9 + 4);
    int moves = 0;
    std::set<Index> triangles;
    for (int i = 0; i < 5000; ++i) {
      moves += v.visit(step, random_bowl(random)) ? 1 : 0;
      ASSERT_LT(off_site(s, v.site, v.x), 1e-15);
      if (v.site.kind == SiteKind::triangle) triangles.insert(v.site.item);
    }
    EXPECT_GT(moves, 2000);
    EXPECT_GT(triangles.size(), least);
  };
  check(kNewton, 100);
  check(kGradient, 20);  // one primitive a visit
}

TEST(Slide, NeverCrossesAWall) {
  std::mt19937 random(6);
  // A wall across the middle, x = 1/2, which is no fold.
  std::set<std::pair<Index, Index>> walls;
  for (Index j = 0; j < 8; ++j) walls.insert({j * 9 + 4, (j + 1) * 9 + 4});
  TinySurface s = height_field(8, bumpy, walls);
  std::vector<Index> wall;
  for (Index j = 0; j <= 8; ++j) wall.push_back(j * 9 + 4);
  s.add_line(wall);
  const auto check = [&](const auto& step) {
    Slider left(s, 4 * 9 + 1);
    Slider right(s, 4 * 9 + 7);
    Slider middle(s, 4 * 9 + 4);
    double closest = 1;
    double low = 1;
    double high = 0;
    for (int i = 0; i < 4000; ++i) {
      const Bowl bowl = random_bowl(random);
      left.visit(step, bowl);
      right.visit(step, bowl);
      middle.visit(step, bowl);
      ASSERT_LE(left.x.x, 0.5);
      ASSERT_GE(right.x.x, 0.5);
      for (const Slider* v : {&left, &right}) {
        ASSERT_TRUE(v->x.x >= 0 && v->x.x <= 1 && v->x.y >= 0 && v->x.y <= 1);
        ASSERT_LT(off_site(s, v->site, v->x), 1e-15);
      }
      ASSERT_EQ(middle.x.x, 0.5);
      ASSERT_TRUE(middle.x.y >= 0 && middle.x.y <= 1);
      ASSERT_LT(off_site(s, middle.site, middle.x), 1e-15);
      closest = std::min(closest, 0.5 - left.x.x);
      low = std::min(low, middle.x.y);
      high = std::max(high, middle.x.y);
    }
    EXPECT_LT(closest, 0.01);
    EXPECT_LT(low, 0.1);
    EXPECT_GT(high, 0.9);
  };
  check(kNewton);
  check(kGradient);
}

TEST(Slide, DoesNotEnterWhatRoundingOrTheRingForbids) {
  // Where only a small ball is certified, the vertex ends in it.
  const TinySurface s = height_field(8, flat);
  Bowl bowl{{0.9, 0.5, 0}, kRound, kFarAway};
  bowl.radius = 0.41;  // around the goal: the start, 0.4 away, is inside
  Slider v(s, 4 * 9 + 4);
  EXPECT_TRUE(v.visit(kNewton, bowl));
  EXPECT_TRUE(bowl.value(v.x).certified);
  // Nothing lower is to be had: stays.
  Slider at_minimum(s, 4 * 9 + 4);
  EXPECT_FALSE(at_minimum.visit(kNewton, {{0.5, 0.5, 1}, kRound, kFarAway}));
  EXPECT_FALSE(at_minimum.visit(kGradient, {{0.5, 0.5, 1}, kRound, kFarAway}));
}

// The bound.

/// A mesh surface of the reference's own triangles whose vertices have slid.
struct SlidSurface {
  const TinySurface& s;
  std::vector<Point> points;
  std::vector<Site> sites;
  explicit SlidSurface(const TinySurface& surface) : s(surface), points(surface.points) {
    for (std::size_t v = 0; v < points.size(); ++v) sites.push_back({SiteKind::vertex, static_cast<Index>(v)});
  }
  bool allows(Index v, const Landing& landing, double limit) const {
    return DeviationBound(s.view(), {points.data(), static_cast<Size>(points.size())},
                          {sites.data(), static_cast<Size>(sites.size())}, v, limit)
        .allows(landing.at, landing.site);
  }
  /// A random walk of a few hops from where the vertex is.
  Landing wander(Index v, double far, std::mt19937& random) const {
    const auto i = static_cast<std::size_t>(v);
    Landing at{vec(points[i]), sites[i], 0, false};
    for (int hop = 0; hop < 4; ++hop) {
      const Primitive p = steepest(s.view(), s.kind[i], at.site, random_vec(random));
      if (p.on.kind == SiteKind::none) continue;
      at = advance(s.view(), s.kind[i], p, at.site, at.at, (1 / norm(descent(p))) * p.down, far * uniform(random));
    }
    return at;
  }
  void put(Index v, const Landing& landing) {
    points[static_cast<std::size_t>(v)] = point(landing.at);
    sites[static_cast<std::size_t>(v)] = landing.site;
  }
  TrianglePoints triangle(std::size_t t, const std::vector<Point>& at) const {
    TrianglePoints p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = vec(at[static_cast<std::size_t>(s.triangles[t].v[k])]);
    return p;
  }
  /// Stays a graph over the plane, as a mesh of positive volumes below it would.
  bool upright() const {
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
      const TrianglePoints p = triangle(t, points);
      if (!(cross(p[1] - p[0], p[2] - p[0]).z > 1e-4)) return false;
    }
    return true;
  }
  /// Plain oracle: both surfaces sampled densely.
  double distance() const {
    std::vector<TrianglePoints> now;
    std::vector<TrianglePoints> before;
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
      now.push_back(triangle(t, points));
      before.push_back(triangle(t, s.points));
    }
    return std::max(farthest(now, ClosestTriangle(before)), farthest(before, ClosestTriangle(now)));
  }

 private:
  static double farthest(const std::vector<TrianglePoints>& from, const ClosestTriangle& to) {
    constexpr int kSamples = 8;
    double most = 0;
    for (const TrianglePoints& t : from) {
      for (int a = 0; a <= kSamples; ++a) {
        for (int b = 0; a + b <= kSamples; ++b) {
          const Vec3 p = t[0] + (static_cast<double>(a) / kSamples) * (t[1] - t[0]) +
                         (static_cast<double>(b) / kSamples) * (t[2] - t[0]);
          most = std::max(most, to.distance2(p));
        }
      }
    }
    return std::sqrt(most);
  }
};

TEST(DeviationBound, LetsVerticesOfAPlaneGoAnywhere) {
  std::mt19937 random(7);
  const TinySurface s = height_field(6, flat);
  SlidSurface mesh(s);
  int moves = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto v = static_cast<Index>(random() % s.points.size());
    if (s.kind[static_cast<std::size_t>(v)] != Mobility::surface) continue;
    const Landing landing = mesh.wander(v, 0.05, random);
    SlidSurface moved = mesh;
    moved.put(v, landing);
    if (!moved.upright()) continue;
    ASSERT_TRUE(mesh.allows(v, landing, 1e-9));
    mesh.put(v, landing);
    ++moves;
  }
  EXPECT_GT(moves, 500);
}

TEST(DeviationBound, HoldsBothWaysOnACurvedSurface) {
  std::mt19937 random(8);
  for (const double limit : {0.1, 0.02, 0.005, 0.001}) {
    const TinySurface s = height_field(7, bumpy);
    SlidSurface mesh(s);
    int allowed = 0;
    int refused = 0;
    for (int i = 0; i < 3000; ++i) {
      const auto v = static_cast<Index>(random() % s.points.size());
      if (s.kind[static_cast<std::size_t>(v)] != Mobility::surface) continue;
      const Landing landing = mesh.wander(v, 0.1, random);
      SlidSurface moved = mesh;
      moved.put(v, landing);
      if (!moved.upright()) continue;
      const bool fine = mesh.allows(v, landing, limit);
      (fine ? allowed : refused) += 1;
      if (!fine) continue;
      mesh.put(v, landing);
      if (allowed % 10 == 0) {
        ASSERT_LE(mesh.distance(), limit) << limit;
      }
    }
    EXPECT_LE(mesh.distance(), limit);
    EXPECT_GT(mesh.distance(), 0.2 * limit);
    EXPECT_GT(allowed, limit > 0.001 ? 200 : 20) << limit;
    EXPECT_GT(refused, limit < 0.1 ? 50 : -1) << limit;
  }
}

TEST(DeviationBound, HoldsAlongAFeatureLine) {
  std::mt19937 random(9);
  // The line x = 1/2 over a fold of varying height: of a bent polyline every chord leaves something out.
  const auto roof = [](double x, double y) { return 0.4 * std::fabs(x - 0.5) + 0.06 * std::sin(9 * y); };
  std::set<std::pair<Index, Index>> walls;
  for (Index j = 0; j < 8; ++j) walls.insert({j * 9 + 4, (j + 1) * 9 + 4});
  TinySurface s = height_field(8, roof, walls);
  std::vector<Index> wall;
  for (Index j = 0; j <= 8; ++j) wall.push_back(j * 9 + 4);
  s.add_line(wall);
  for (const double limit : {0.05, 0.01, 0.003}) {
    SlidSurface mesh(s);
    int allowed[2] = {0, 0};
    int refused = 0;
    for (int i = 0; i < 6000; ++i) {
      const auto v = static_cast<Index>(random() % s.points.size());
      const Mobility kind = s.kind[static_cast<std::size_t>(v)];
      if (kind == Mobility::fixed) continue;
      const Landing landing = mesh.wander(v, 0.1, random);
      SlidSurface moved = mesh;
      moved.put(v, landing);
      if (!moved.upright()) continue;
      if (!mesh.allows(v, landing, limit)) {
        ++refused;
        continue;
      }
      mesh.put(v, landing);
      ++allowed[kind == Mobility::curve ? 1 : 0];
    }
    EXPECT_LE(mesh.distance(), limit);
    EXPECT_GT(mesh.distance(), 0.2 * limit);
    EXPECT_GT(allowed[0], 50) << limit;
    EXPECT_GT(allowed[1], 10) << limit;
    EXPECT_GT(refused, 10) << limit;
    // The line itself, both ways.
    double off = 0;
    for (Index j = 0; j < 8; ++j) {
      for (int k = 0; k <= 20; ++k) {
        const auto at = [&](const std::vector<Point>& p) {
          const Vec3 a = vec(p[static_cast<std::size_t>(j * 9 + 4)]);
          return a + (k / 20.0) * (vec(p[static_cast<std::size_t>((j + 1) * 9 + 4)]) - a);
        };
        const auto lines = [&](const std::vector<Point>& p) {
          std::vector<TrianglePoints> all;
          for (std::size_t i = 0; i + 1 < wall.size(); ++i) {
            const Vec3 b = vec(p[static_cast<std::size_t>(wall[i + 1])]);
            all.push_back({vec(p[static_cast<std::size_t>(wall[i])]), b, b});
          }
          return ClosestTriangle(all);
        };
        off = std::max(off, lines(s.points).distance2(at(mesh.points)));
        off = std::max(off, lines(mesh.points).distance2(at(s.points)));
      }
    }
    EXPECT_LE(std::sqrt(off), limit);
  }
}

TEST(DeviationBound, CountsWhatItCannotDecideAsTooFar) {
  // A star triangle without area has no heights.
  const TinySurface s = height_field(3, flat);
  const SlidSurface mesh(s);
  const Landing onto_neighbour{vec(s.points[6]), {SiteKind::vertex, 6}, 0, true};
  EXPECT_FALSE(mesh.allows(5, onto_neighbour, 100));
  EXPECT_TRUE(mesh.allows(5, onto_neighbour, 0));  // no bound
  // One large triangle over more small ones than there is room for.
  const TinySurface fine = height_field(24, flat);
  SlidSurface spread(fine);
  const auto go = [&](Index v, Index to) {
    spread.put(v, {vec(fine.points[static_cast<std::size_t>(to)]), {SiteKind::vertex, to}, 0, true});
  };
  const auto id = [](int i, int j) { return static_cast<Index>(j * 25 + i); };
  go(id(12, 12), id(2, 2));
  go(id(13, 12), id(22, 2));
  EXPECT_FALSE(spread.allows(
      id(13, 13), {vec(fine.points[static_cast<std::size_t>(id(12, 22))]), {SiteKind::vertex, id(12, 22)}, 0, true},
      100));
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
// Relocation of one vertex on the reference surface (Sect. 4.3).
#include <gtest/gtest.h>

#include <random>

#include "boundary/sliding/deviation_bound.hpp"
#include "math/closest_triangle.hpp"
#include "relocation/slide.hpp"
#include "support/surface.hpp"

namespace tetune {
namespace {

using test::bumpy;
using test::flat;
using test::folded;
using test::height_field;
using test::height_field_with_line;
using test::random_vec;
using test::TinySurface;
using test::uniform;

constexpr double kFarAway = 1e3;

/// A mock of a ring: a quadratic energy over all of space, or over a ball.
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
  auto ray(const Vec3& x, const Vec3& p) const {
    return [this, x, p](double t) { return value(x + t * p).value; };
  }
};
const Sym3 kRound{1, 1, 1, 0, 0, 0};

Bowl random_bowl(std::mt19937& random) {
  // B^T B + 0.2 I of a random B.
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

/// A vertex that slides on a surface, in another ring at each visit.
struct Slider {
  const TinySurface& surface;
  VertexDof dof;
  Vec3 x;
  SurfacePoint surface_point;

  Slider(const TinySurface& s, Index v)
      : surface(s),
        dof(s.dof[static_cast<std::size_t>(v)]),
        x(vec(s.points[static_cast<std::size_t>(v)])),
        surface_point{SurfacePointKind::vertex, v} {}

  template <class Step>
  bool visit(const Step& step, Bowl bowl) {
    const ReferenceView ref = surface.view();
    DeviationBound<backend::Cpu::Pack> no_bound({ref, {}, {}, 0, 0}, {});
    const double before = bowl.value(x).value;
    const SlideResult r =
        step(bowl, SurfacePlace{x, surface_point, dof}, surface.view(), no_bound, DisplacementBound{});
    EXPECT_NEAR(r.step.decrease, before - bowl.value(r.step.position).value, 1e-12);
    EXPECT_GE(r.step.decrease, 0);
    if (r.step.decrease == 0) return false;
    x = r.step.position;
    surface_point = r.surface_point;
    return true;
  }
};
const NewtonSlide kNewton{1.6, 1e-14};
const NewtonSlide kPureNewton{1, 1e-14};
const GradientSlide kGradient{1e-12};

/// The distance of a position from its surface element.
double distance_from_element(const TinySurface& s, const SurfacePoint& surface_point, const Vec3& x) {
  const ReferenceView ref = s.view();
  if (surface_point.kind == SurfacePointKind::vertex) return norm(x - ref.point(surface_point.item));
  if (surface_point.kind == SurfacePointKind::triangle) {
    const SurfaceTriangle t = ref.triangles[surface_point.item];
    return std::sqrt(ClosestTriangle({{ref.point(t.v[0]), ref.point(t.v[1]), ref.point(t.v[2])}}).distance2(x));
  }
  const EdgeVertices e = edge_vertices(ref, surface_point);
  return std::sqrt(ClosestTriangle({{ref.point(e.a), ref.point(e.b), ref.point(e.b)}}).distance2(x));
}

TEST(NewtonDirection, EndsAtTheMinimumOfTheModelOnTheElement) {
  std::mt19937 random(8);
  int along_edge = 0;
  for (int i = 0; i < 300; ++i) {
    const TinySurface s = folded(3 * (2 * uniform(random) - 1));
    const Bowl bowl = random_bowl(random);
    const Vec3 x{0.3 * uniform(random) - 0.4, uniform(random), uniform(random)};
    const Vec3 g = bowl.model(x).gradient;
    const SurfacePoint surface_point{SurfacePointKind::triangle, i % 2};
    const SurfaceElement inside = steepest(s.view(), VertexDof::surface, surface_point, g);
    const Frame& frame = inside.frame;
    const Vec3 p = frame.in_space(slide_detail::newton_direction(s.view(), bowl.hessian, surface_point, inside));
    EXPECT_NEAR(dot(p, cross(frame.u, frame.edge2)), 0, 1e-12) << i;
    for (const Vec3& edge : {frame.u, frame.edge2}) EXPECT_NEAR(dot(g + bowl.hessian * p, edge), 0, 1e-11) << i;

    const SurfacePoint edge{SurfacePointKind::edge, 2};
    const SurfaceElement along = steepest(s.view(), VertexDof::surface, edge, g);
    if (along.on.kind != SurfacePointKind::edge) continue;
    ++along_edge;
    const Vec3 q = along.frame.in_space(slide_detail::newton_direction(s.view(), bowl.hessian, edge, along));
    EXPECT_EQ(norm(cross(q, {0, 1, 0})), 0) << i;
    EXPECT_NEAR(g.y + (bowl.hessian * q).y, 0, 1e-12) << i;
  }
  EXPECT_GT(along_edge, 30);
}

TEST(Slide, OnAPlaneEndsAtThePlanarMinimumAcrossEdgesAndVertices) {
  std::mt19937 random(4);
  const TinySurface s = height_field(9, flat);
  int crossings = 0;
  for (int i = 0; i < 300; ++i) {
    // Reachable in one visit of at most 16 trace steps.
    Bowl bowl = random_bowl(random);
    bowl.lowest = {0.3 + 0.4 * uniform(random), 0.3 + 0.4 * uniform(random), 0.1};
    if (i % 2 == 0) bowl.hessian = kRound;
    // The gradient in the plane vanishes at `goal`.
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
      crossings += a.surface_point.item != 0 ? 1 : 0;
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
  EXPECT_GT(crossings, 50);
}

TEST(Slide, StaysOnABumpySurfaceToRoundingOverManyVisits) {
  std::mt19937 random(5);
  const TinySurface s = height_field(8, bumpy);
  const auto check = [&](const auto& step, std::size_t min_triangles) {
    Slider v(s, 4 * 9 + 4);
    int moves = 0;
    std::set<Index> triangles;
    for (int i = 0; i < 5000; ++i) {
      moves += v.visit(step, random_bowl(random)) ? 1 : 0;
      ASSERT_LT(distance_from_element(s, v.surface_point, v.x), 1e-15);
      if (v.surface_point.kind == SurfacePointKind::triangle) triangles.insert(v.surface_point.item);
    }
    EXPECT_GT(moves, 2000);
    EXPECT_GT(triangles.size(), min_triangles);
  };
  check(kNewton, 100);
  check(kGradient, 20);  // one element per visit
}

TEST(Slide, NeverCrossesAFeatureLine) {
  std::mt19937 random(6);
  // The feature line x = 1/2 is no fold.
  const TinySurface s = height_field_with_line(8, bumpy);
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
        ASSERT_LT(distance_from_element(s, v->surface_point, v->x), 1e-15);
      }
      ASSERT_EQ(middle.x.x, 0.5);
      ASSERT_TRUE(middle.x.y >= 0 && middle.x.y <= 1);
      ASSERT_LT(distance_from_element(s, middle.surface_point, middle.x), 1e-15);
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

TEST(Slide, StopsWhereTheRingIsNotCertifiedOrNotLower) {
  // Only a small ball is certified: the vertex ends in it.
  const TinySurface s = height_field(8, flat);
  Bowl bowl{{0.9, 0.5, 0}, kRound, kFarAway};
  bowl.radius = 0.41;  // around the goal: the start, 0.4 away, is inside
  Slider v(s, 4 * 9 + 4);
  EXPECT_TRUE(v.visit(kNewton, bowl));
  EXPECT_TRUE(bowl.value(v.x).certified);
  // No position is lower: the vertex does not move.
  Slider at_minimum(s, 4 * 9 + 4);
  EXPECT_FALSE(at_minimum.visit(kNewton, {{0.5, 0.5, 1}, kRound, kFarAway}));
  EXPECT_FALSE(at_minimum.visit(kGradient, {{0.5, 0.5, 1}, kRound, kFarAway}));
}

}  // namespace
}  // namespace tetune

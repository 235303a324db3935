// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <set>

#include "curved/quadratic_sheet.hpp"
#include "curved/surface_distance.hpp"
#include "driver/curved/curved_sheets.hpp"
#include "driver/curved/curved_slide.hpp"
#include "math/constants.hpp"
#include "support/curved.hpp"
#include "support/meshes.hpp"
#include "support/sanitized.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

using Quadratic = QuadraticSheet::Triangle;

/// A point of a quadratic triangle by its six shape functions.
Vec3 plain_point(const Quadratic& t, double u, double v) {
  const std::array<double, 3> l{1 - u - v, u, v};
  Vec3 p{0, 0, 0};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    const Vec3 middle = 0.5 * (t.corners[k] + t.corners[next]) + t.offsets[k];
    p = p + l[k] * (2 * l[k] - 1) * t.corners[k] + 4 * l[k] * l[next] * middle;
  }
  return p;
}

/// The distance of a point from a quadratic triangle: the closest point of a lattice, and Gauss-Newton steps from it
/// within the triangle.
double plain_distance(const Quadratic& t, const Vec3& p) {
  constexpr int kSteps = 6;
  double u = 0;
  double v = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; i + j <= kSteps; ++j) {
      const double d = norm(plain_point(t, double(i) / kSteps, double(j) / kSteps) - p);
      if (d >= least) continue;
      least = d;
      u = double(i) / kSteps;
      v = double(j) / kSteps;
    }
  }
  for (int step = 0; step < 30; ++step) {
    constexpr double h = 1e-4;  // central differences of a quadratic polynomial are exact
    const Vec3 a = (1 / (2 * h)) * (plain_point(t, u + h, v) - plain_point(t, u - h, v));
    const Vec3 b = (1 / (2 * h)) * (plain_point(t, u, v + h) - plain_point(t, u, v - h));
    const Vec3 r = p - plain_point(t, u, v);
    const double det = dot(a, a) * dot(b, b) - dot(a, b) * dot(a, b);
    u = std::clamp(u + (dot(b, b) * dot(a, r) - dot(a, b) * dot(b, r)) / det, 0.0, 1.0);
    v = std::clamp(v + (dot(a, a) * dot(b, r) - dot(a, b) * dot(a, r)) / det, 0.0, 1 - u);
    least = std::min(least, norm(plain_point(t, u, v) - p));
  }
  return least;
}

double plain_distance(const std::vector<Quadratic>& surface, const Vec3& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Quadratic& t : surface) {
    Vec3 center{0, 0, 0};
    double radius = 0;
    for (const Vec3& c : t.corners) center = center + (1.0 / 3) * c;
    for (std::size_t k = 0; k < 3; ++k) radius = std::max(radius, norm(t.corners[k] - center) + 2 * norm(t.offsets[k]));
    if (norm(p - center) - radius < least) least = std::min(least, plain_distance(t, p));
  }
  return least;
}

/// Quadratic triangles on a part of a graph z = f(x, y) over a shaken grid.
template <class F>
std::vector<Quadratic> graph(int n, std::uint32_t seed, const F& f) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.2, 0.2);
  const auto lifted = [&f](double x, double y) { return Vec3{x, y, f(x, y)}; };
  std::vector<Vec3> nodes;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const bool inner = i > 0 && j > 0 && i < n && j < n;
      const double dx = shift(random);
      const double dy = shift(random);
      nodes.push_back(lifted((i + inner * dx) / n, (j + inner * dy) / n));
    }
  }
  std::vector<Quadratic> triangles;
  const auto add = [&](int a, int b, int c) {
    Quadratic t{{nodes[std::size_t(a)], nodes[std::size_t(b)], nodes[std::size_t(c)]}, {}};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 m = 0.5 * (t.corners[k] + t.corners[(k + 1) % 3]);
      t.offsets[k] = lifted(m.x, m.y) - m;
    }
    triangles.push_back(t);
  };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i;
      add(a, a + 1, a + n + 2);
      add(a, a + n + 2, a + n + 1);
    }
  }
  return triangles;
}

double sphere(double x, double y) { return std::sqrt(3 - x * x - y * y); }
double cylinder(double x, double /*y*/) { return std::sqrt(2 - x * x); }

TEST(CurvedSlide, LiftedPointsAreOnTheQuadraticSurface) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0.05, 0.95);
  for (const auto& surface : {graph(4, 1, sphere), graph(4, 1, cylinder)}) {
    const QuadraticSheet sheet(surface);
    for (const Quadratic& t : surface) {
      EXPECT_LT(norm(sheet.lift(t.corners[0]) - t.corners[0]), 1e-14);
      const Vec3 middle = 0.5 * (t.corners[0] + t.corners[1]);
      EXPECT_LT(norm(sheet.lift(middle) - (middle + t.offsets[0])), 1e-14);
    }
    for (int i = 0; i < 100; ++i) {
      const double x = unit(random);
      const double y = unit(random);
      const Vec3 lifted = sheet.lift({x, y, 0.95 * sphere(x, y)});
      EXPECT_LT(plain_distance(surface, lifted), 1e-12);
    }
  }
}

TEST(CurvedSlide, LiftedPointsOfALineAreOnTheParabola) {
  const std::vector<Point3> points{{0, 0, 0}, {1, 0, 0}, {2, 0.5, 0}};
  const std::vector<CurvedEdge> edges{{{0, 1}, {0.5, 0.1, 0}}};
  const QuadraticTriangles quadratic(points, edges);
  const QuadraticSheet line({quadratic.of(std::array<Index, 2>{0, 1}), quadratic.of(std::array<Index, 2>{1, 2})});
  const Vec3 on_parabola = line.lift({0.25, 0.3, 0.1});
  EXPECT_NEAR(on_parabola.x, 0.25, 1e-15);
  EXPECT_NEAR(on_parabola.y, 0.075, 1e-15);
  EXPECT_NEAR(on_parabola.z, 0, 1e-15);
  const Vec3 on_segment = line.lift({1.5, 0.25, 2});
  EXPECT_LT(norm(on_segment - Vec3{1.5, 0.25, 0}), 1e-15);
}

TEST(CurvedSlide, DistanceIsBoundedFromAboveAndSharply) {
  for (const double height : {0.0, 0.01}) {
    const std::vector<Quadratic> old_surface = graph(4, 1, sphere);
    const std::vector<Quadratic> new_surface =
        graph(4, 2, [height](double x, double y) { return sphere(x, y) + 16 * height * x * (1 - x) * y * (1 - y); });
    double sampled = 0;
    std::vector<double> each;
    for (const Quadratic& t : new_surface) {
      double largest = 0;
      for (int i = 0; i <= 5; ++i) {
        for (int j = 0; i + j <= 5; ++j) {
          largest = std::max(largest, plain_distance(old_surface, plain_point(t, i / 5.0, j / 5.0)));
        }
      }
      each.push_back(largest);
      sampled = std::max(sampled, largest);
    }
    ASSERT_GT(sampled, height / 3);
    const double limit = 2 * sampled;
    const std::vector<double> bounds = bound_distances(new_surface, old_surface, limit, 1);
    for (std::size_t i = 0; i < bounds.size(); ++i) {
      EXPECT_GE(bounds[i], each[i]);
      EXPECT_LE(bounds[i], std::max(limit / 2, 1.1 * each[i] + 0.35 * limit));
    }
    EXPECT_EQ(bounds, bound_distances(new_surface, old_surface, limit, 3));
    const std::vector<double> none(bounds.size(), kInfinity);
    EXPECT_EQ(bound_distances(new_surface, old_surface, limit, 3, [] { return true; }), none);
    const std::vector<double> small = bound_distances(new_surface, old_surface, 0.5 * sampled, 1);
    EXPECT_GT(*std::max_element(small.begin(), small.end()), 0.5 * sampled);
  }
}

/// A bent box of second-order elements of two regions, with every node of its surface on the bent shape.
TetMesh bent_box(std::uint32_t seed) {
  TetMesh m = test::cube(4, 0.2, seed);
  const auto bend = [](const Point3& p) {
    return Point3{p[0] + 0.08 * std::sin(2 * p[1]), p[1] + 0.06 * std::sin(3 * p[2]), p[2] + 0.1 * p[0] * p[0]};
  };
  for (std::size_t t = 0; t < m.tets.size(); ++t) {
    double x = 0;
    for (const Index v : m.tets[t]) x += m.points[std::size_t(v)][0] / 4;
    m.tet_tags[t] = x < 0.5 ? 1 : 2;
  }
  std::set<std::array<Index, 2>> edges;
  for (const SheetTriangle& t : find_sheets(m)) {
    for (std::size_t k = 0; k < 3; ++k) edges.insert(ascending(t.vertices[k], t.vertices[(k + 1) % 3]));
  }
  m.second_order = true;
  for (const auto& e : edges) {
    Point3 middle{};
    for (const Index v : e) {
      for (std::size_t k = 0; k < 3; ++k) middle[k] += m.points[std::size_t(v)][k] / 2;
    }
    m.curved_edges.push_back({e, bend(middle)});
  }
  for (Point3& p : m.points) p = bend(p);
  return m;
}

std::vector<Quadratic> surface_of(const TetMesh& m) {
  const QuadraticTriangles quadratic(m.points, m.curved_edges);
  std::vector<Quadratic> surface;
  for (const SheetTriangle& t : find_sheets(m)) surface.push_back(quadratic.of(t.vertices));
  return surface;
}

/// The largest distance of the nodes of a surface from another.
double farthest_node(const TetMesh& m, const std::vector<Quadratic>& surface) {
  double largest = 0;
  for (const Quadratic& t : surface_of(m)) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 middle = 0.5 * (t.corners[k] + t.corners[(k + 1) % 3]) + t.offsets[k];
      largest = std::max({largest, plain_distance(surface, t.corners[k]), plain_distance(surface, middle)});
    }
  }
  return largest;
}

void expect_slid(const TetMesh& before, const Options& options) {
  TetMesh m = before;
  const Report report = optimize(m, options);
  EXPECT_TRUE(validate(m).ok()) << validate(m).message(false);
  EXPECT_LT(farthest_node(m, surface_of(before)), 1e-12);
  Options preserving = options;
  preserving.boundary = Boundary::preserve;
  preserving.max_deviation = 0;
  TetMesh kept = before;
  optimize(kept, preserving);
  const Quality q = quality(m);
  EXPECT_TRUE(q.curved.all_valid());
  EXPECT_GE(q.curved.min_scaled_jacobian, quality(kept).curved.min_scaled_jacobian - 2e-3);
  EXPECT_GE(q.dihedral_min, (1 - 1e-9) * quality(kept).dihedral_min);
  EXPECT_LE(q.shape_sum, quality(kept).shape_sum);
  if (options.effort == Effort::standard) {
    EXPECT_GT(report.surface_vertices, 0);
  }
  EXPECT_EQ(m.triangles.size(), before.triangles.size());
  EXPECT_EQ(m.edges.size(), before.edges.size());
  EXPECT_EQ(m.ridges, before.ridges);
  EXPECT_EQ(m.required_vertices, before.required_vertices);
  std::set<int> regions(m.tet_tags.begin(), m.tet_tags.end());
  EXPECT_EQ(regions, (std::set<int>{1, 2}));
  if (options.max_deviation > 0) {
    EXPECT_GT(report.deviation, 0);
    EXPECT_LE(report.deviation, options.max_deviation);
    const auto old_surface = surface_of(before);
    for (const Quadratic& t : surface_of(m)) {
      EXPECT_LE(plain_distance(old_surface, plain_point(t, 1.0 / 3, 1.0 / 3)), options.max_deviation);
    }
  }
  TetMesh again = before;
  Options more = options;
  more.threads = 3;
  optimize(again, more);
  EXPECT_EQ(again.points, m.points);
  EXPECT_EQ(again.tets, m.tets);
  EXPECT_EQ(again.curved_edges, m.curved_edges);
}

TEST(CurvedSlide, NodesStayOnTheQuadraticSurfaceAndNoElementGetsWorse) {
  for (const Effort effort : {Effort::standard, Effort::best}) {
    for (const double deviation : {0.0, 4e-3}) {
      if (effort == Effort::best && (test::kSanitized || deviation > 0)) continue;
      Options options;
      options.boundary = Boundary::slide;
      options.effort = effort;
      options.max_deviation = deviation;
      options.threads = 1;
      expect_slid(bent_box(3), options);
    }
  }
}

TEST(CurvedSlide, VerticesAreInsertedInsideWithInterpolatedData) {
  if (test::kSanitized) GTEST_SKIP() << "too slow";
  const TetMesh before = bent_box(3);
  Options options;
  options.boundary = Boundary::slide;
  options.effort = Effort::best;
  options.data = DataTransfer::interpolate;
  for (const bool keeps : {true, false}) {
    options.keep_vertices = keeps;
    TetMesh m = before;
    const Report report = optimize(m, options);
    EXPECT_EQ(report.vertices_inserted == 0, keeps);
    EXPECT_EQ(report.places.size(), m.points.size());
    EXPECT_TRUE(validate(m).ok()) << validate(m).message(false);
    EXPECT_TRUE(quality(m).curved.all_valid());
    EXPECT_GE(quality(m).curved.min_scaled_jacobian, quality(before).curved.min_scaled_jacobian - 2e-3);
    EXPECT_LT(farthest_node(m, surface_of(before)), 1e-12);
    EXPECT_EQ(m.triangles.size(), before.triangles.size());
  }
}

TEST(CurvedSlide, NodesAreLiftedInPartsBetweenWhichItMayBeStopped) {
  const TetMesh before = bent_box(3);
  const CurvedSlide slide(before, 45);
  TetMesh skeleton = before;
  skeleton.curved_edges.clear();
  slide.constrain(skeleton);
  Options options;
  options.boundary = Boundary::slide;
  options.feature_angle = 180;
  const Report report = optimize(skeleton, options);
  int calls = 0;
  const auto count = [&calls] { return ++calls < 0; };
  const std::optional<LiftedNodes> one = slide.lift(skeleton, report, 1, count);
  ASSERT_TRUE(one.has_value());
  EXPECT_FALSE(one->vertices.empty());
  EXPECT_GT(calls, 0);
  const std::optional<LiftedNodes> several = slide.lift(skeleton, report, 3, {});
  ASSERT_TRUE(several.has_value());
  EXPECT_EQ(several->vertices, one->vertices);
  EXPECT_EQ(several->points, one->points);
  EXPECT_EQ(several->middles, one->middles);
  EXPECT_FALSE(slide.lift(skeleton, report, 3, [] { return true; }).has_value());
}

TEST(CurvedSlide, AStopAtAnyCallLeavesAValidMesh) {
  const TetMesh before = bent_box(3);
  Options options;
  options.boundary = Boundary::slide;
  options.threads = 1;
  for (const DataTransfer data : {DataTransfer::carry, DataTransfer::interpolate}) {
    options.data = data;
    int call = 0;
    for (int last = 1;; last += 31) {
      TetMesh m = before;
      call = 0;
      const Report report = optimize(m, options, {{}, [&] { return ++call >= last; }});
      EXPECT_EQ(report.stop == StopReason::cancelled, call >= last);
      EXPECT_TRUE(validate(m).ok());
      EXPECT_TRUE(quality(m).curved.all_valid());
      EXPECT_LT(farthest_node(m, surface_of(before)), 1e-12);
      if (call < last) break;
    }
  }
}

}  // namespace
}  // namespace tetune

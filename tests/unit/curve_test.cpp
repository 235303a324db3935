// SPDX-License-Identifier: Apache-2.0
#include "tetune/curve.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <thread>

#include "curved/curved_edges.hpp"
#include "curved/finer_surface.hpp"
#include "curved/surface_middles.hpp"
#include "math/constants.hpp"
#include "support/curved.hpp"
#include "tetune/error.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

double distance_to_sphere(const Point3& p) { return std::fabs(std::hypot(p[0], p[1], p[2]) - 1); }

constexpr double kTube = 0.4;
double distance_to_torus(const Point3& p) { return std::fabs(std::hypot(std::hypot(p[0], p[1]) - 1, p[2]) - kTube); }

constexpr std::array<int, 3> kOneSheet{0, 0, -1};

/// A part of a sphere, or of a torus, over a shaken grid of n x n squares, each in two triangles.
template <class Place>
std::vector<SheetTriangle> make_sheet(int n, const Place& place, std::vector<Point3>& points) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> shift(-0.2, 0.2);
  points.clear();
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double v = (j + shift(random)) / n;  // a compiler may evaluate arguments of one call in any order
      const double u = (i + shift(random)) / n;
      points.push_back(place(u, v));
    }
  }
  std::vector<SheetTriangle> triangles;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const Index a = j * (n + 1) + i;
      triangles.push_back({{a, a + 1, a + n + 2}, kOneSheet});
      triangles.push_back({{a, a + n + 2, a + n + 1}, kOneSheet});
    }
  }
  return triangles;
}

template <class Place>
FinerSurface make_finer(int n, const Place& place) {
  std::vector<Point3> points;
  const std::vector<SheetTriangle> sheet = make_sheet(n, place, points);
  return {points, sheet, find_surface_parts(points, sheet, {}, 45), find_surface_middles(points, sheet, {}, 45)};
}

/// The mean distance from the surface of points of the quadratic triangles inside a sheet; with `finer` > 0 their
/// mid-side nodes are on a sheet of that many squares.
template <class Place, class Distance>
double error(int n, const Place& place, const Distance& distance, int finer = 0) {
  std::vector<Point3> points;
  const std::vector<SheetTriangle> sheet = make_sheet(n, place, points);
  std::optional<FinerSurface> surface;
  if (finer > 0) surface = make_finer(finer, place);
  TetMesh mesh;
  mesh.points = points;
  mesh.curved_edges = find_surface_middles(points, sheet, {}, 45, surface ? &*surface : nullptr);
  const CurvedEdges edges(mesh);
  double sum = 0;
  int samples = 0;
  for (const SheetTriangle& t : sheet) {
    const auto& [a, b, c] = t.vertices;
    const bool is_inner = std::all_of(t.vertices.begin(), t.vertices.end(), [n](Index v) {
      return v > n && v < n * (n + 1) && v % (n + 1) != 0 && v % (n + 1) != n;
    });
    if (!is_inner) continue;
    for (int i = 0; i <= 4; ++i) {
      for (int j = 0; i + j <= 4; ++j) {
        const double u = i / 4.0;
        const double v = j / 4.0;
        const double w = 1 - u - v;
        const Vec3 p = u * (2 * u - 1) * test::at(mesh, a) + v * (2 * v - 1) * test::at(mesh, b) +
                       w * (2 * w - 1) * test::at(mesh, c) + 4 * u * v * edges.middle(a, b) +
                       4 * v * w * edges.middle(b, c) + 4 * w * u * edges.middle(c, a);
        sum += distance({p.x, p.y, p.z});
        ++samples;
      }
    }
  }
  EXPECT_EQ(samples, 15 * 2 * (n - 2) * (n - 2));
  return sum / samples;
}

Point3 on_sphere(double u, double v) { return {std::cos(u) * std::cos(v), std::sin(u) * std::cos(v), std::sin(v)}; }
Point3 on_torus(double u, double v) {
  const double r = 1 + kTube * std::cos(2 * v);
  return {r * std::cos(u), r * std::sin(u), kTube * std::sin(2 * v)};
}

TEST(Curve, ErrorFallsWithThirdOrder) {
  const double sphere = error(10, on_sphere, distance_to_sphere);
  const double torus = error(10, on_torus, distance_to_torus);
  EXPECT_GT(sphere, 0);
  EXPECT_GE(std::log2(sphere / error(20, on_sphere, distance_to_sphere)), 3);
  EXPECT_GE(std::log2(torus / error(20, on_torus, distance_to_torus)), 3);
}

TEST(Curve, ErrorOnAFinerSurfaceFallsWithThirdOrder) {
  const double sphere = error(5, on_sphere, distance_to_sphere, 13);
  const double torus = error(5, on_torus, distance_to_torus, 13);
  EXPECT_GE(std::log2(sphere / error(10, on_sphere, distance_to_sphere, 26)), 3);
  EXPECT_GE(std::log2(torus / error(10, on_torus, distance_to_torus, 26)), 3);
  // Far less than the error of the finer triangles themselves, of which a square has the side 1/13.
  EXPECT_LT(sphere, 0.05 / (8 * 13 * 13));
  EXPECT_LT(5 * sphere, error(5, on_sphere, distance_to_sphere));
  EXPECT_LT(5 * torus, error(5, on_torus, distance_to_torus));
}

TEST(Curve, EdgesThatAreNoFeaturesOfTheFinerSurfaceAreSmooth) {
  const auto on_cylinder = [](double u, double v) -> Point3 { return {std::cos(5.5 * u), std::sin(5.5 * u), v}; };
  const auto distance = [](const Point3& p) { return std::fabs(std::hypot(p[0], p[1]) - 1); };
  EXPECT_GT(error(6, on_cylinder, distance), 0.01);  // it turns by about 52 degrees at edges
  EXPECT_LT(error(6, on_cylinder, distance, 40), 1e-3);
}

TEST(Curve, FlatPartsStayStraight) {
  TetMesh box = test::cube(4, 0.2, 1);
  const CurveReport report = curve(box);
  EXPECT_TRUE(box.second_order);
  EXPECT_TRUE(box.curved_edges.empty());
  EXPECT_EQ(report.curved_tets, 0);
}

/// The cube with a curved top.
TetMesh domed(int n) {
  TetMesh m = test::cube(n, 0.1, 1);
  for (Point3& p : m.points) p[2] *= 1.3 - 0.5 * (std::pow(p[0] - 0.5, 2) + std::pow(p[1] - 0.5, 2));
  return m;
}

TEST(Curve, EachElementIsProvedValid) {
  TetMesh mesh = domed(4);
  const TetMesh before = mesh;
  const CurveReport report = curve(mesh);
  EXPECT_TRUE(measure_curved(mesh).all_valid());
  EXPECT_TRUE(validate(mesh).ok());
  EXPECT_TRUE(report.straightened.empty());
  EXPECT_EQ(report.curved_edges, std::ssize(mesh.curved_edges));
  EXPECT_GE(report.curved_edges, 3 * 16);
  for (const CurvedEdge& e : mesh.curved_edges) EXPECT_GT(e.middle[2], 0.9);
  CurveOptions three;
  three.threads = 3;
  TetMesh again = before;
  curve(again, three);
  EXPECT_EQ(again.points, mesh.points);
  EXPECT_EQ(again.curved_edges, mesh.curved_edges);
}

/// The mean distance of mid-side nodes from the dome.
double error_of_dome(const TetMesh& mesh) {
  double sum = 0;
  int n = 0;
  for (const CurvedEdge& e : mesh.curved_edges) {
    const auto& [x, y, z] = e.middle;
    if (z < 1) continue;
    sum += std::fabs(z - 1.3 + 0.5 * (std::pow(x - 0.5, 2) + std::pow(y - 0.5, 2)));
    ++n;
  }
  return sum / n;
}

TEST(Curve, AFinerMeshGivesTheSurface) {
  TetMesh without = domed(3);
  curve(without);
  const TetMesh linear = domed(8);
  TetMesh second = linear;
  curve(second);
  TetMesh triangles;
  triangles.points = linear.points;
  for (const auto& face : test::skin(linear)) triangles.triangles.push_back(face.v);
  triangles.triangle_tags.assign(triangles.triangles.size(), 0);
  triangles.point_tags.assign(triangles.points.size(), 0);
  for (const TetMesh* finer : std::initializer_list<const TetMesh*>{&linear, &second, &triangles}) {
    TetMesh mesh = domed(3);
    CurveOptions options;
    options.surface = finer;
    curve(mesh, options);
    EXPECT_TRUE(measure_curved(mesh).all_valid());
    EXPECT_LT(3 * error_of_dome(mesh), error_of_dome(without));
    // Flat sides stay so.
    for (const CurvedEdge& e : mesh.curved_edges) EXPECT_GT(e.middle[2], 0.9);
  }
}

/// The message with which a finer surface is refused; empty if it is not.
std::string refusal_of(TetMesh mesh, const TetMesh& finer) {
  CurveOptions options;
  options.surface = &finer;
  try {
    curve(mesh, options);
  } catch (const MeshError& error) {
    EXPECT_FALSE(mesh.second_order);
    return error.what();
  }
  return "";
}

TEST(Curve, AFinerMeshOfAnotherPartIsRefused) {
  TetMesh mesh = domed(3);
  TetMesh finer = domed(8);
  for (Point3& p : finer.points) p[0] += 0.25;
  // The side x = 0 is 0.25 away.
  const std::string text = refusal_of(mesh, finer);
  EXPECT_NE(text.find("the largest distance is 0.25"), std::string::npos) << text;
  EXPECT_NE(text.find("near 0 "), std::string::npos) << text;
  constexpr double kUnit = 1e-6;
  const std::string in_small_unit = refusal_of(test::scaled(mesh, kUnit), test::scaled(finer, kUnit));
  EXPECT_NE(in_small_unit.find("the largest distance is 2.5"), std::string::npos) << in_small_unit;
  EXPECT_NE(in_small_unit.find("e-07, of vertex"), std::string::npos) << in_small_unit;
  CurveOptions options;
  const TetMesh empty;
  options.surface = &empty;
  EXPECT_THROW(curve(mesh, options), MeshError);
}

TEST(Curve, TooCurvedEdgesAreStraightened) {
  // Elements with two triangles on a smooth sphere cannot have a positive determinant at their common edge.
  TetMesh ball = test::ball(2, 0);
  const CurveReport report = curve(ball);
  EXPECT_TRUE(measure_curved(ball).all_valid());
  EXPECT_GT(report.not_valid_before, 0);
  EXPECT_GT(report.min_scaled_jacobian, 0);
  EXPECT_FALSE(report.straightened.empty());
  for (const StraightenedEdge& e : report.straightened) {
    EXPECT_LT(e.kept, 1);
    EXPECT_GE(e.kept, 0);
  }
}

TEST(Curve, TheCallingThreadAloneIsAskedToStop) {
  TetMesh ball = test::ball(3, 0);
  CurveOptions options;
  options.threads = 3;
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<int> asked = 0, by_others = 0;
  options.stop = [&] {
    if (std::this_thread::get_id() != caller) ++by_others;
    return ++asked > 1;
  };
  curve(ball, options);
  EXPECT_LE(asked, 2);  // not again after it has requested a stop
  EXPECT_EQ(by_others, 0);
  EXPECT_TRUE(measure_curved(ball).all_valid());
}

TEST(Curve, IsRefused) {
  TetMesh mesh = domed(2);
  CurveOptions options;
  options.feature_angle = 0;
  EXPECT_THROW(curve(mesh, options), OptionError);
  curve(mesh);
  EXPECT_FALSE(mesh.curved_edges.empty());
  EXPECT_THROW(curve(mesh), MeshError);
  TetMesh inverted = test::ball(2, 0);
  std::swap(inverted.tets[0][0], inverted.tets[0][1]);
  EXPECT_THROW(curve(inverted), MeshError);
}

/// The least time of three calls of find_surface_middles() for a cone of triangles around one vertex, in seconds.
double seconds_of_cone(int n) {
  std::vector<Point3> points{{0, 0, 1}};
  std::vector<SheetTriangle> triangles;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    points.push_back({std::cos(angle), std::sin(angle), 0});
    triangles.push_back({{0, 1 + i, 1 + (i + 1) % n}, kOneSheet});
  }
  double least = kInfinity;
  for (int i = 0; i < 3; ++i) {
    const auto start = std::chrono::steady_clock::now();
    EXPECT_FALSE(find_surface_middles(points, triangles, {}, 180).empty());
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return least;
}

TEST(SurfaceMiddles, TimeIsLinearInTheTrianglesAroundAVertex) {
  // There are 32 times as many triangles, and caches hold the smaller cone.
  EXPECT_LT(seconds_of_cone(64'000), 200 * seconds_of_cone(2'000));
}

/// Squared distances overflow, so that no sheet of the finer surface is the nearest one.
TEST(Curve, HugeUnitsLeaveTheSurfaceStraight) {
  TetMesh m = test::scaled(test::ball(2, 0), 1e170);
  const TetMesh finer = test::scaled(test::ball(4, 0), 1e170);
  CurveOptions options;
  options.surface = &finer;
  curve(m, options);
  EXPECT_TRUE(quality(m).curved.all_valid());
}

}  // namespace
}  // namespace tetune

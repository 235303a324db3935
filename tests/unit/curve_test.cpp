// SPDX-License-Identifier: Apache-2.0
#include "tetune/curve.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "curved.hpp"
#include "curved/surface_middles.hpp"
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
    for (int i = 0; i <= n; ++i) points.push_back(place((i + shift(random)) / n, (j + shift(random)) / n));
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

/// The mean distance from the surface of mid-side nodes inside a sheet.
template <class Place, class Distance>
double error(int n, const Place& place, const Distance& distance) {
  std::vector<Point3> points;
  const std::vector<SheetTriangle> sheet = make_sheet(n, place, points);
  double sum = 0;
  int inner = 0;
  for (const CurvedEdge& e : find_surface_middles(points, sheet, {}, 45)) {
    const auto on_border = [n](Index v) {
      return v < n + 1 || v >= n * (n + 1) || v % (n + 1) == 0 || v % (n + 1) == n;
    };
    if (on_border(e.vertices[0]) || on_border(e.vertices[1])) continue;
    sum += distance(e.middle);
    ++inner;
  }
  EXPECT_GT(inner, n * n);
  return sum / inner;
}

TEST(Curve, ErrorFallsWithThirdOrder) {
  const auto on_sphere = [](double u, double v) -> Point3 {
    return {std::cos(u) * std::cos(v), std::sin(u) * std::cos(v), std::sin(v)};
  };
  const auto on_torus = [](double u, double v) -> Point3 {
    const double r = 1 + kTube * std::cos(2 * v);
    return {r * std::cos(u), r * std::sin(u), kTube * std::sin(2 * v)};
  };
  const double sphere = error(10, on_sphere, distance_to_sphere);
  const double torus = error(10, on_torus, distance_to_torus);
  EXPECT_GT(sphere, 0);
  EXPECT_GE(std::log2(sphere / error(20, on_sphere, distance_to_sphere)), 3);
  EXPECT_GE(std::log2(torus / error(20, on_torus, distance_to_torus)), 3);
  std::printf("errors %g and %g, with half the edges %g and %g\n", sphere, torus,
              error(20, on_sphere, distance_to_sphere), error(20, on_torus, distance_to_torus));
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

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
// Places in a mesh: points are found wherever they are, and data are evaluated there.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "mesh/transfer/point_locator.hpp"
#include "support/flat_tets.hpp"
#include "support/meshes.hpp"
#include "support/work.hpp"
#include "tetune/tetune.hpp"

namespace tetune {
namespace {

PointLocator locator(const TetMesh& mesh) {
  test::CpuMesh work = test::to_work(mesh);
  build_adjacency(backend::Cpu(1), work);
  return PointLocator(HostMesh(work));
}

Vec3 position(const TetMesh& mesh, const TetPoint& at) {
  Vec3 x{0, 0, 0};
  for (int k = 0; k < 4; ++k) x = x + at.weights[to_size_t(k)] * vec(span_of(mesh.points)[at.vertices[k]]);
  return x;
}

TEST(PointLocator, FindsPointsFromAnyStart) {
  const TetMesh mesh = test::scrambled(test::cube(6, 0.2, 3), 5, 2);
  const PointLocator locate = locator(mesh);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p{unit(random), unit(random), unit(random)};
    const auto start = static_cast<Index>(unit(random) * static_cast<double>(mesh.points.size()));
    const TetPoint at = locate.locate(p, start);
    EXPECT_LT(norm(position(mesh, at) - p), 1e-12);
    double sum = 0;
    for (const double w : at.weights) {
      EXPECT_GE(w, 0);
      sum += w;
    }
    EXPECT_NEAR(sum, 1, 1e-15);
  }
}

TEST(PointLocator, TakesTheClosestPointForOneOutside) {
  const TetMesh mesh = test::cube(4);
  const PointLocator locate = locator(mesh);
  const auto near = [&](const Point3& p) {
    Index best = 0;
    for (Index v = 0; v < std::ssize(mesh.points); ++v) {
      if (norm(vec(span_of(mesh.points)[v]) - vec(p)) < norm(vec(span_of(mesh.points)[best]) - vec(p))) best = v;
    }
    return best;
  };
  for (const Point3& p : {Point3{0.55, 0.6, 1.1}, Point3{0.3, -0.05, 0.2}, Point3{1.01, 0.2, 0.7}}) {
    const Vec3 q = position(mesh, locate.locate(vec(p), near(p)));
    const Vec3 clamped{std::clamp(p[0], 0.0, 1.0), std::clamp(p[1], 0.0, 1.0), std::clamp(p[2], 0.0, 1.0)};
    EXPECT_LT(norm(q - clamped), 0.1);
  }
}

/// Tetrahedra around one edge.
TetMesh sectors(Index count) {
  TetMesh mesh;
  mesh.points = {{0, 0, 1}, {0, 0, -1}};
  for (Index i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    mesh.points.push_back({std::cos(angle), std::sin(angle), 0});
    mesh.tets.push_back({0, 1, 2 + (i + 1) % count, 2 + i});
  }
  mesh.point_tags.resize(mesh.points.size());
  mesh.tet_tags.resize(mesh.tets.size());
  return mesh;
}

/// Neither the walk nor the search around the start gets to the other side of an edge of 9000 tetrahedra.
TEST(PointLocator, FindsPointsAcrossAVertexOfManyTetrahedra) {
  const TetMesh mesh = sectors(9000);
  const PointLocator locate = locator(mesh);
  for (Index v = 2; v < std::ssize(mesh.points); v += 450) {
    const Vec3 outer = vec(span_of(mesh.points)[v]);
    for (const Vec3& p : {0.5 * outer, 0.99 * outer}) {
      EXPECT_LT(norm(position(mesh, locate.locate(p, 0)) - p), 1e-9);
    }
    EXPECT_LT(norm(position(mesh, locate.locate(1.01 * outer, 0)) - outer), 0.02)
        << "for a point outside the closest one";
  }
}

/// In the planes of tetrahedra that are flat to rounding, the weights in these are noise, or no numbers.
TEST(PointLocator, TakesNoTetrahedronThatIsFlatToRounding) {
  const TetMesh mesh = test::with_flat_tets(8);
  ASSERT_TRUE(validate(mesh).ok()) << validate(mesh).message(false);
  const PointLocator locate = locator(mesh);
  int flat = 0;
  for (const auto& [a, b, c, d] : mesh.tets) {
    const auto at = [&](Index v) { return vec(span_of(mesh.points)[v]); };
    const double volume = dot(cross(at(b) - at(a), at(c) - at(a)), at(d) - at(a));
    if (volume > 1e-12) continue;
    if (volume <= 0) ++flat;
    const Vec3 middle = 0.25 * (at(a) + at(b) + at(c) + at(d));
    for (const Vec3& p : {middle, 0.5 * (middle + at(a)), 0.1 * middle + 0.9 * at(b), middle + 0.07 * at(1)}) {
      for (const Index start : {a, c}) {
        const TetPoint found = locate.locate(p, start);
        EXPECT_LT(norm(position(mesh, found) - p), 1e-12);
        for (const double w : found.weights) EXPECT_TRUE(w >= 0 && w <= 1) << w;
      }
    }
  }
  EXPECT_GT(flat, 0);
}

TEST(Interpolation, OfEachType) {
  const std::vector<MeshPlace> places{{{0, 1, 2, 3}, {0.25, 0.25, 0.5, 0}}, {{3, 3, 3, 3}, {1, 0, 0, 0}}};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto result = interpolate_point_data({{"d", 1, std::vector<double>{1, 2, 4, nan}},
                                              {"f", 2, std::vector<float>{0, 1, 4, 1, 2, 1, 7, 1}},
                                              {"i", 1, std::vector<std::int32_t>{5, 6, 7, 8}},
                                              {"n", 1, std::vector<double>{nan, 2, 4, 6}}},
                                             places);
  EXPECT_EQ(std::get<std::vector<double>>(result[0].values)[0], 2.75);
  EXPECT_TRUE(std::isnan(std::get<std::vector<double>>(result[0].values)[1]));
  EXPECT_EQ(std::get<std::vector<float>>(result[1].values), (std::vector<float>{2, 1, 7, 1}));
  EXPECT_EQ(std::get<std::vector<std::int32_t>>(result[2].values), (std::vector<std::int32_t>{7, 8}));
  EXPECT_EQ(std::get<std::vector<double>>(result[3].values)[0], 4) << "of the nearest vertex";
  EXPECT_THROW(interpolate_point_data({{"d", 1, std::vector<double>{1, 2, 3}}}, places), MeshError);
  EXPECT_THROW(interpolate_point_data({{"d", 0, std::vector<double>{1, 2, 3, 4}}}, places), MeshError);
  EXPECT_THROW(interpolate_point_data({}, {MeshPlace{}}), MeshError);
}

/// Three linear fields, one that is a step, and ids.
TetMesh with_fields(TetMesh mesh) {
  std::vector<double> linear;
  std::vector<double> step;
  std::vector<std::int64_t> ids;
  for (const Point3& p : mesh.points) {
    for (const double x : {1 + 2 * p[0] - p[1], p[2], 3.0}) linear.push_back(x);
    step.push_back(p[0] < 0.4 ? -1 : 1);
    ids.push_back(std::ssize(ids));
  }
  mesh.point_data = {{"linear", 3, linear}, {"step", 1, step}, {"id", 1, ids}};
  return mesh;
}

const std::vector<double>& doubles(const TetMesh& mesh, std::size_t i) {
  return std::get<std::vector<double>>(mesh.point_data[i].values);
}

/// `origin`: where each vertex of the result was in the input.
template <class Origin>
void expect_fields(const TetMesh& before, const TetMesh& after, const Origin& origin) {
  ASSERT_EQ(doubles(after, 0).size(), 3 * after.points.size());
  const auto& ids = std::get<std::vector<std::int64_t>>(after.point_data[2].values);
  for (std::size_t v = 0; v < after.points.size(); ++v) {
    const Point3 p = origin(after.points[v]);
    EXPECT_NEAR(doubles(after, 0)[3 * v], 1 + 2 * p[0] - p[1], 1e-12);
    EXPECT_NEAR(doubles(after, 0)[3 * v + 1], p[2], 1e-12);
    EXPECT_EQ(doubles(after, 0)[3 * v + 2], 3) << "a constant stays to the last bit";
    EXPECT_LE(std::fabs(doubles(after, 1)[v]), 1);
    ASSERT_LT(ids[v], std::ssize(before.points));
    const Vec3 d = vec(before.points[static_cast<std::size_t>(ids[v])]) - vec(p);
    EXPECT_LT(norm(d), 0.6) << "of a vertex of the same tetrahedron";
  }
}

TEST(Interpolation, LinearFieldsAreExactAfterOptimization) {
  const TetMesh before = with_fields(test::scrambled(test::cube(7, 0.2, 5), 5, 1));
  for (const Effort effort : {Effort::standard, Effort::best}) {
    Options options;
    options.effort = effort;
    options.data = DataTransfer::interpolate;
    TetMesh after = before;
    const Report r = optimize(after, options);
    EXPECT_EQ(r.vertices_inserted > 0, effort == Effort::best);
    EXPECT_EQ(r.places.size(), after.points.size());
    expect_fields(before, after, [](const Point3& p) { return p; });
    options.threads = 1;
    TetMesh again = before;
    optimize(again, options);
    EXPECT_EQ(doubles(again, 0), doubles(after, 0));
    // The mesh itself does not depend on its data.
    options.data = DataTransfer::carry;
    TetMesh carried = before;
    EXPECT_TRUE(optimize(carried, options).places.empty());
    EXPECT_EQ(carried.points, after.points);
  }
}

TEST(Interpolation, LinearFieldsAreExactBesideTetrahedraThatAreFlatToRounding) {
  const TetMesh before = with_fields(test::with_flat_tets(8));
  Options options;
  options.data = DataTransfer::interpolate;
  TetMesh after = before;
  const Report report = optimize(after, options);
  expect_fields(before, after, [](const Point3& p) { return p; });
  for (const MeshPlace& place : report.places) {
    for (const double w : place.weights) EXPECT_TRUE(w >= 0 && w <= 1) << w;
  }
}

/// Untangling counts as motion: vertices that were inside out keep their values.
TEST(Interpolation, AfterUntangling) {
  const TetMesh before = with_fields(test::tangled(6, 0.6, 3));
  ASSERT_FALSE(validate(before).ok());
  Options options;
  options.untangle = true;
  options.data = DataTransfer::interpolate;
  TetMesh after = before;
  optimize(after, options);
  for (std::size_t v = 0; v < after.points.size(); ++v) {
    EXPECT_LE(std::fabs(doubles(after, 1)[v]), 1);
    EXPECT_EQ(doubles(after, 0)[3 * v + 2], 3);
  }
}

/// A linear motion takes linear fields along: here all vertices are prescribed but those that are inserted, or none of
/// the inner ones, whose motion is close to linear.
TEST(Interpolation, AMotionTakesFieldsAlong) {
  const TetMesh before = with_fields(test::scrambled(test::cube(6, 0.2, 5), 5, 1));
  const auto shift = [](Point3 p) {
    p[1] += 2;
    return p;
  };
  VertexTargets targets = surface_targets(before, before.points);
  for (Point3& p : targets) p = shift(p);
  Options options;
  options.data = DataTransfer::interpolate;
  TetMesh after = before;
  ASSERT_TRUE(move(after, targets, options).reached());
  // The prediction of a translation is exact up to the solver's tolerance of 1e-6.
  const auto& linear = doubles(after, 0);
  double error = 0;
  for (std::size_t v = 0; v < after.points.size(); ++v) {
    const Point3& p = after.points[v];
    error = std::max(error, std::fabs(linear[3 * v] - (1 + 2 * p[0] - (p[1] - 2))));
  }
  EXPECT_LT(error, 1e-3);
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
// Conservative transfer: intersections of tetrahedra, totals, bounds and linear fields.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <thread>
#include <utility>

#include "mesh/transfer/tet_overlap.hpp"
#include "support/curved.hpp"
#include "support/flat_tets.hpp"
#include "support/meshes.hpp"
#include "tetune/tetune.hpp"

namespace tetune {
namespace {

std::array<double, 4> coordinates(const Vec3& p, const TetPoints& x) {
  std::array<double, 4> result{};
  for (std::size_t k = 0; k < 4; ++k) {
    TetPoints y = x;
    y[k] = p;
    result[k] = six_volume(y) / six_volume(x);
  }
  return result;
}

bool is_inside(const std::array<double, 4>& w) {
  return std::all_of(w.begin(), w.end(), [](double x) { return x >= 0; });
}

/// Against sums over random points of the first tetrahedron.
TEST(TetOverlap, AgreesWithSampling) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto random_tet = [&] {
    TetPoints x{};
    for (Vec3& p : x) p = {unit(random), unit(random), unit(random)};
    return x;
  };
  constexpr int kSamples = 4000;
  for (int i = 0; i < 60; ++i) {
    const TetPoints a = random_tet();
    const TetPoints b = random_tet();
    const TetOverlap common = overlap(TetFrame(a), TetFrame(b), Moments::computed);
    TetOverlap sampled;
    for (int s = 0; s < kSamples; ++s) {
      std::array<double, 4> w{};
      double sum = 0;
      for (double& x : w) sum += x = -std::log(1 - unit(random));
      Vec3 p{0, 0, 0};
      for (std::size_t k = 0; k < 4; ++k) p = p + (w[k] /= sum) * a[k];
      const auto in_b = coordinates(p, b);
      if (!is_inside(in_b)) continue;
      sampled.part += 1.0 / kSamples;
      for (std::size_t k = 0; k < 4; ++k) {
        for (std::size_t l = 0; l < 4; ++l) sampled.moments[k][l] += w[k] * in_b[l] / kSamples;
      }
    }
    EXPECT_NEAR(common.part, sampled.part, 0.04);
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      for (std::size_t l = 0; l < 4; ++l) {
        sum += common.moments[k][l];
        EXPECT_NEAR(common.moments[k][l], sampled.moments[k][l], 0.02);
      }
    }
    EXPECT_NEAR(sum, common.part, 1e-12);
    const double volumes = std::fabs(six_volume(b) / six_volume(a));
    EXPECT_NEAR(overlap(TetFrame(b), TetFrame(a), Moments::omitted).part * volumes, common.part, 1e-12)
        << "from either side";
    EXPECT_NEAR(overlap(TetFrame(a), TetFrame(a), Moments::omitted).part, 1, 1e-12);
  }
}

const std::vector<double>& doubles(const DataArray& array) { return std::get<std::vector<double>>(array.values); }

double volume(const TetMesh& mesh, std::size_t t) {
  const auto at = [&](std::size_t k) { return vec(span_of(mesh.points)[mesh.tets[t][k]]); };
  return six_volume({at(0), at(1), at(2), at(3)}) / 6;
}

/// Integrals of the first data of vertices and of tetrahedra, per component: the former as linear fields.
std::vector<double> totals(const TetMesh& mesh) {
  const std::size_t n = 3;
  std::vector<double> sums(2 * n, 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t c = 0; c < n; ++c) {
      for (const Index v : mesh.tets[t]) {
        sums[c] += volume(mesh, t) / 4 * doubles(mesh.point_data[0])[to_size_t(v) * n + c];
      }
      sums[n + c] += volume(mesh, t) * doubles(mesh.tet_data[0])[t * n + c];
    }
  }
  return sums;
}

/// Data that are linear, a step from -1 to 1, and random in [0, 1]; ids; a field with a NaN; single precision.
TetMesh with_data(TetMesh mesh) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<double> fields;
  std::vector<double> hole;
  std::vector<float> single;
  for (const Point3& p : mesh.points) {
    for (const double x : {1 + 2 * p[0] - p[1] + 0.5 * p[2], p[0] < 0.45 ? -1.0 : 1.0, unit(random)}) {
      fields.push_back(x);
    }
    single.push_back(static_cast<float>(p[0]));
    hole.push_back(p[0]);
  }
  hole[0] = std::numeric_limits<double>::quiet_NaN();
  mesh.point_data = {{"fields", 3, fields}, {"single", 1, single}, {"hole", 1, hole}};
  std::vector<double> cells;
  std::vector<std::int32_t> ids;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const Point3& p = span_of(mesh.points)[mesh.tets[t][0]];
    for (const double x : {7.0, p[1] < 0.5 ? -1.0 : 1.0, unit(random)}) cells.push_back(x);
    ids.push_back(static_cast<std::int32_t>(t));
  }
  mesh.tet_data = {{"cells", 3, cells}, {"id", 1, ids}};
  return mesh;
}

void expect_within(const DataArray& array, std::size_t component, double low, double high) {
  const auto& values = doubles(array);
  for (std::size_t i = component; i < values.size(); i += 3) {
    EXPECT_GE(values[i], low);
    EXPECT_LE(values[i], high);
  }
}

void expect_conserved(const TetMesh& before, const TetMesh& after) {
  const std::vector<double> old_totals = totals(before);
  const std::vector<double> new_totals = totals(after);
  for (std::size_t i = 0; i < old_totals.size(); ++i) EXPECT_NEAR(new_totals[i], old_totals[i], 1e-12);
  for (const auto* array : {&after.point_data[0], &after.tet_data[0]}) {
    expect_within(*array, 1, -1, 1);
    expect_within(*array, 2, 0, 1);
  }
  expect_within(after.tet_data[0], 0, 7, 7);
}

TEST(Conserve, LinearFieldsTotalsAndBounds) {
  const TetMesh before = with_data(test::scrambled(test::cube(6, 0.2, 5), 5, 1));
  for (const Effort effort : {Effort::standard, Effort::best}) {
    Options options;
    options.effort = effort;
    options.data = DataTransfer::conserve;
    options.threads = 2;
    TetMesh after = before;
    const Report report = optimize(after, options);
    EXPECT_LT(report.uncovered, 1e-12);
    ASSERT_NE(after.tets, before.tets);
    expect_conserved(before, after);
    double largest_change = 0;
    for (std::size_t v = 0; v < after.points.size(); ++v) {
      const Point3& p = after.points[v];
      EXPECT_NEAR(doubles(after.point_data[0])[3 * v], 1 + 2 * p[0] - p[1] + 0.5 * p[2], 1e-12);
      EXPECT_NEAR(std::get<std::vector<float>>(after.point_data[1].values)[v], p[0], 1e-6);
      EXPECT_FALSE(std::isinf(doubles(after.point_data[2])[v]));
      largest_change = std::max(largest_change, std::fabs(doubles(after.point_data[0])[3 * v + 1]));
    }
    EXPECT_GT(largest_change, 0.99) << "limited, and not merely lumped";
    const auto& ids = std::get<std::vector<std::int32_t>>(after.tet_data[1].values);
    for (const std::int32_t id : ids) EXPECT_TRUE(id >= 0 && id < std::ssize(before.tets));
    options.threads = 1;
    TetMesh again = before;
    optimize(again, options);
    EXPECT_EQ(again.points, after.points);
    EXPECT_EQ(doubles(again.point_data[0]), doubles(after.point_data[0]));
    EXPECT_EQ(doubles(again.tet_data[0]), doubles(after.tet_data[0]));
  }
}

TEST(Conserve, BesideTetrahedraThatAreFlatToRounding) {
  const TetMesh before = with_data(test::with_flat_tets(8));
  Options options;
  options.data = DataTransfer::conserve;
  TetMesh after = before;
  const Report report = optimize(after, options);
  EXPECT_LT(report.uncovered, 1e-12);
  expect_conserved(before, after);
  for (std::size_t v = 0; v < after.points.size(); ++v) {
    const Point3& p = after.points[v];
    EXPECT_NEAR(doubles(after.point_data[0])[3 * v], 1 + 2 * p[0] - p[1] + 0.5 * p[2], 1e-12);
  }
}

/// Of a mesh that changes in part, the rest keeps its bits, and the totals of the whole mesh are kept.
TEST(Conserve, InALiveMesh) {
  const TetMesh before = with_data(test::cube(8, 0.2, 5));
  Options options;
  options.data = DataTransfer::conserve;
  LiveMesh live(before, options, 1);
  const auto center =
      std::min_element(before.points.begin(), before.points.end(), [](const Point3& a, const Point3& b) {
        const auto d = [](const Point3& p) { return norm(vec(p) - Vec3{0.5, 0.5, 0.5}); };
        return d(a) < d(b);
      });
  const auto v = to_index(center - before.points.begin());
  const Point3 to{(*center)[0] + 1e-3, (*center)[1], (*center)[2]};
  live.set_points(std::array{v}, std::array<Point3, 1>{to});
  const TetMesh disturbed = live.mesh();
  live.optimize();
  expect_conserved(disturbed, live.mesh());
  std::size_t same = 0;
  for (std::size_t i = 0; i < before.points.size(); ++i) {
    if (doubles(before.point_data[0])[3 * i + 2] == doubles(live.mesh().point_data[0])[3 * i + 2]) ++same;
  }
  EXPECT_GT(same, before.points.size() / 2);
  EXPECT_LT(same, before.points.size());
}

/// A blob in a block that turns in small steps: its integrals stay, and it does not leave its range.
TEST(Conserve, ARotatingBlob) {
  TetMesh mesh = with_data(test::scrambled(test::cube(6, 0.2, 5), 5, 1));
  auto& fields = std::get<std::vector<double>>(mesh.point_data[0].values);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const Vec3 d = vec(mesh.points[v]) - Vec3{0.6, 0.5, 0.5};
    fields[3 * v + 2] = std::exp(-20 * dot(d, d));
  }
  const std::vector<double> first = totals(mesh);
  Options options;
  options.data = DataTransfer::conserve;
  constexpr int kSteps = 4;
  for (int step = 0; step < kSteps; ++step) {
    const double c = std::cos(0.1);
    const double s = std::sin(0.1);
    VertexTargets targets = mesh.points;
    for (Point3& p : targets) {
      const double x = p[0] - 0.5;
      const double y = p[1] - 0.5;
      p = {0.5 + c * x - s * y, 0.5 + s * x + c * y, p[2]};
    }
    ASSERT_TRUE(move(mesh, targets, options).reached());
  }
  const std::vector<double> last = totals(mesh);
  for (const std::size_t i : {std::size_t{2}, std::size_t{5}}) EXPECT_NEAR(last[i], first[i], 1e-12);
  expect_within(mesh.point_data[0], 2, 0, 1);
}

/// Where the surface moves, data of what is not covered go to what is beside it.
TEST(Conserve, OnACurvedSurface) {
  const TetMesh before = with_data(test::ball(5));
  Options options;
  options.boundary = Boundary::slide;
  options.data = DataTransfer::conserve;
  TetMesh after = before;
  const Report report = optimize(after, options);
  EXPECT_GE(report.uncovered, 0);
  EXPECT_LT(report.uncovered, 0.1);
  expect_within(after.point_data[0], 2, 0, 1);
  expect_within(after.tet_data[0], 0, 7, 7);
}

TEST(Conserve, RefusesInvertedElementsAndShortArrays) {
  Options options;
  options.data = DataTransfer::conserve;
  options.untangle = true;
  TetMesh tangled = test::tangled(6, 0.6, 3);
  EXPECT_THROW(optimize(tangled, options), OptionError);
  options.untangle = false;
  TetMesh mesh = test::cube(3, 0.2, 5);
  mesh.tet_data = {{"short", 1, std::vector<double>{1, 2}}};
  EXPECT_THROW(optimize(mesh, options), MeshError);
}

TEST(Conserve, RefusesIdsOutOfRange) {
  TetMesh mesh = test::one_tet();
  mesh.point_data = {{"x", 1, std::vector<double>(4)}};
  std::vector<MeshPlace> places(4);
  for (Index v = 0; v < 4; ++v) places[to_size_t(v)] = {{v, v, v, v}, {1, 0, 0, 0}};
  EXPECT_EQ(conserve_data(mesh, mesh.tets, {0}, places).point_data.size(), 1U);
  EXPECT_THROW(conserve_data(mesh, mesh.tets, {0}, {}), MeshError);
  EXPECT_THROW(conserve_data(mesh, mesh.tets, {1}, places), MeshError);
  places[2].vertices[3] = 4;
  EXPECT_THROW(conserve_data(mesh, mesh.tets, {0}, places), MeshError);
}

/// Tetrahedra from a point of a cube to the triangles of its surface, with a field. Their boxes all meet: transfer
/// takes a time that is quadratic in their number.
TetMesh star(int cells) {
  TetMesh mesh = test::cube(cells);
  const std::vector<std::array<Index, 4>> tets = std::exchange(mesh.tets, {});
  std::map<std::array<Index, 3>, std::pair<std::array<Index, 3>, int>> faces;
  for (const auto& t : tets) {
    for (const auto& face : {std::array{t[0], t[1], t[2]}, std::array{t[0], t[3], t[1]}, std::array{t[1], t[3], t[2]},
                             std::array{t[0], t[2], t[3]}}) {
      auto key = face;
      std::sort(key.begin(), key.end());
      auto& [oriented, count] = faces[key];
      oriented = face;
      ++count;
    }
  }
  const Index center = static_cast<Index>(mesh.points.size());
  mesh.points.push_back({0.513, 0.521, 0.483});
  for (const auto& [key, face] : faces) {
    if (face.second == 1) mesh.tets.push_back({face.first[0], face.first[1], face.first[2], center});
  }
  mesh.point_tags.resize(mesh.points.size());
  mesh.tet_tags.assign(mesh.tets.size(), 0);
  std::vector<double> field;
  for (const Point3& p : mesh.points) field.push_back(p[0] * p[1]);
  mesh.point_data = {{"field", 1, field}};
  return mesh;
}

TEST(Conserve, EndsAfterAStop) {
  const TetMesh before = star(30);
  ASSERT_TRUE(validate(before).ok());
  for (const bool in_part : {false, true}) {
    Options options;
    options.data = DataTransfer::conserve;
    options.threads = 1;
    if (in_part) {
      options.only_below = {{Measure::min_dihedral, 30}};
      options.rings = 100;
    }
    Context context;
    context.progress = [](const Progress& p) { return p.iteration == 0; };
    TetMesh after = before;
    const Report report = optimize(after, options, context);
    EXPECT_EQ(report.stop, StopReason::cancelled);
    EXPECT_TRUE(report.transfer_stopped);
    ASSERT_NE(after.points, before.points);
    EXPECT_TRUE(validate(after).ok());
    ASSERT_EQ(std::count_if(report.warnings.begin(), report.warnings.end(),
                            [](const std::string& w) { return w.find("data are those of") != std::string::npos; }),
              1);
    const auto expected = interpolate_point_data(before.point_data, report.places);
    EXPECT_EQ(doubles(after.point_data[0]), doubles(expected[0]));
  }
}

/// A stop is no reason to give up what takes a moment.
TEST(Conserve, IsFinishedAfterAStopIfItTakesLittle) {
  TetMesh before = test::scrambled(test::cube(6, 0.2, 5), 5, 1);
  std::vector<double> field;
  for (const Point3& p : before.points) field.push_back(p[0] * p[1]);
  before.point_data = {{"field", 1, field}};
  Options options;
  options.data = DataTransfer::conserve;
  bool was_asked = false;
  Context context;
  context.progress = [&](const Progress& p) {
    if (p.iteration == 0) return true;
    if (!std::exchange(was_asked, true)) std::this_thread::sleep_for(std::chrono::seconds(3));
    return false;
  };
  TetMesh after = before;
  const Report report = optimize(after, options, context);
  EXPECT_EQ(report.stop, StopReason::cancelled);
  EXPECT_TRUE(report.warnings.empty());
  EXPECT_NE(doubles(after.point_data[0]), doubles(interpolate_point_data(before.point_data, report.places)[0]));
}

}  // namespace
}  // namespace tetune

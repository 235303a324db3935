// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>

#include "energy/quality_floor.hpp"
#include "support/meshes.hpp"
#include "tetune/error.hpp"
#include "tetune/quality.hpp"

namespace tetune {
namespace {

TEST(Quality, OfTheRegularTetrahedron) {
  TetMesh m = test::one_tet();
  m.points = {{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}};
  const Quality q = quality(m);
  const double angle = std::acos(1.0 / 3) * 180 / std::numbers::pi;
  EXPECT_NEAR(q.dihedral_min, angle, 1e-10);
  EXPECT_NEAR(q.dihedral_max, angle, 1e-10);
  EXPECT_NEAR(q.dihedral_5, angle, 0.01);
  EXPECT_NEAR(q.mean_ratio, 1, 1e-12);
  EXPECT_NEAR(q.eta_sum, 4.5 * std::sqrt(2.0) * std::sqrt(8.0), 1e-12);
  EXPECT_NEAR(q.volume, 8.0 / 3, 1e-12);
  EXPECT_EQ(q.histogram[7], 1);
}

TEST(Quality, OfTheCornerTetrahedron) {
  const Quality q = quality(test::one_tet());
  EXPECT_NEAR(q.dihedral_min, std::acos(1 / std::sqrt(3.0)) * 180 / std::numbers::pi, 1e-10);
  EXPECT_NEAR(q.dihedral_max, 90, 1e-10);
  EXPECT_NEAR(q.dihedral_mean, (3 * 90 + 3 * q.dihedral_min) / 6, 1e-10);
  EXPECT_NEAR(q.eta_max, (3 * 0.25 + 0.75) * 6, 1e-12);
  EXPECT_NEAR(q.mean_ratio_min, 12 * std::cbrt(9.0 / 36) / 9, 1e-12);
  EXPECT_EQ(q.worst_tet, 0);
}

TEST(Quality, IsTheSameForAnyNumberOfThreads) {
  const TetMesh m = test::cube(7, 0.2);
  const Quality one = quality(m, 1);
  for (const int threads : {2, 3}) {
    const Quality q = quality(m, threads);
    EXPECT_EQ(q.eta_sum, one.eta_sum);
    EXPECT_EQ(q.mean_ratio, one.mean_ratio);
    EXPECT_EQ(q.dihedral_5, one.dihedral_5);
    EXPECT_EQ(q.worst_tet, one.worst_tet);
  }
}

TEST(Quality, TheWorstAreTheFirstOfAll) {
  const TetMesh m = test::cube(7, 0.2);
  const std::vector<WorstTet> all = measure_all(m, 2, std::numeric_limits<int>::max()).worst;
  ASSERT_EQ(all.size(), m.tets.size());
  const auto is_ordered = [](const WorstTet& a, const WorstTet& b) {
    return a.dihedral < b.dihedral || (a.dihedral == b.dihedral && a.tet < b.tet);
  };
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end(), is_ordered));
  for (const int count : {0, 1, 100}) {
    const std::vector<WorstTet> worst = measure_all(m, 1, count).worst;
    ASSERT_EQ(std::ssize(worst), count);
    for (std::size_t i = 0; i < worst.size(); ++i) EXPECT_EQ(worst[i].tet, all[i].tet);
  }
}

TEST(Quality, DoesNotDependOnTheUnit) {
  const TetMesh m = test::cube(3, 0.2);
  const Quality one = quality(m);
  for (const double unit : {0x1p-400, 0x1p-60, 0x1p200, 0x1p400}) {
    const Quality q = quality(test::scaled(m, unit));
    EXPECT_EQ(q.dihedral_min, one.dihedral_min);
    EXPECT_EQ(q.mean_ratio, one.mean_ratio);
    EXPECT_EQ(q.eta_sum, one.eta_sum * unit);
  }
}

TEST(Quality, RefusesIndicesOutOfRange) {
  TetMesh m = test::one_tet();
  m.tets[0][0] = 9;
  EXPECT_THROW(quality(m), MeshError);
  EXPECT_EQ(quality(TetMesh{}).tets, 0);
}

/// Of the graph z = 4 s x (1 - x - y) over the triangle x, y, 1 - x - y >= 0.
double area_of_bulge(double s) {
  constexpr int kSteps = 400;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      // The square as a triangle: y = (1 - x) t.
      const double x = (i + 0.5) / kSteps;
      const double y = (1 - x) * (j + 0.5) / kSteps;
      const double dx = 4 * s * (1 - 2 * x - y);
      const double dy = -4 * s * x;
      sum += (1 - x) * std::sqrt(1 + dx * dx + dy * dy);
    }
  }
  return sum / kSteps / kSteps;
}

TEST(Compare, VolumesAndAreasAreThoseOfCurvedElements) {
  constexpr double kShift = 0.1;
  TetMesh before = test::one_tet();
  before.triangles = {{0, 1, 3}, {0, 2, 1}};
  before.triangle_tags = {5, 6};
  TetMesh after = before;
  after.second_order = true;
  after.curved_edges = {{{0, 1}, {0.5, 0, -kShift}}};
  const Comparison c = compare(before, after);
  EXPECT_NEAR(c.volume_change, kShift, 1e-15);
  EXPECT_EQ(c.region_volume_change, c.volume_change);
  ASSERT_EQ(c.patches.size(), 2U);
  EXPECT_NEAR(c.patches[0].area_change, 4 * kShift / 3, 1e-15);  // a parabola on its flat side
  const double bulge = area_of_bulge(kShift);
  EXPECT_NEAR(c.patches[1].area_change, bulge / 0.5 - 1, 3e-6);
  EXPECT_EQ(c.patch_area_change, c.patches[0].area_change);
  const double area = 1.5 + std::sqrt(3.0) / 2;
  EXPECT_NEAR(c.area_change, (2 * kShift / 3 + bulge - 0.5) / area, 3e-6);
  const Comparison back = compare(after, before);
  EXPECT_NEAR(back.patches[1].area_before, bulge, 3e-6);
  EXPECT_NEAR(back.volume_change, 1 / (1 + kShift) - 1, 1e-15);
}

/// With exact zeros no triangle was searched for, which takes quadratic time where many share a vertex.
TEST(Compare, CommonTrianglesHaveNoDistance) {
  TetMesh mesh = test::cube(6);
  for (Point3& p : mesh.points) p = {0.3 * p[0] - 0.7 * p[1], 0.7 * p[0] + 0.3 * p[1] + 0.1 * p[2], 0.9 * p[2]};
  const Comparison same = compare(mesh, mesh);
  EXPECT_EQ(same.new_to_old, 0);
  EXPECT_EQ(same.old_to_new, 0);
  EXPECT_EQ(same.vertices_to_old, 0);
  const Comparison renumbered = compare(mesh, test::scrambled(mesh, 5, 2));
  EXPECT_EQ(renumbered.new_to_old, 0);
}

TEST(Compare, TheNumberOfSamplesHasNoUpperLimit) {
  const TetMesh before = test::cube(3);
  TetMesh after = before;
  for (Point3& p : after.points) p[0] *= 1.5;
  const Comparison all = compare(before, after);
  const Comparison limited = compare(before, after, 1, std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(limited.sample_stride, 1);
  EXPECT_EQ(limited.new_to_old, all.new_to_old);
}

TEST(Compare, FindsChanges) {
  const TetMesh before = test::cube(4);
  TetMesh after = before;
  Comparison c = compare(before, after);
  EXPECT_EQ(c.volume_change, 0);
  EXPECT_EQ(c.new_to_old, 0);
  EXPECT_TRUE(c.tet_tags_kept && c.vertex_tags_kept);

  after.points[124][0] += 0.1;  // a corner of the cube, outwards along x
  c = compare(before, after);
  EXPECT_GT(c.volume_change, 1e-4);
  const double mean_edge = (0.25 * 2 + 0.25 * std::sqrt(2.0)) / 3;
  EXPECT_NEAR(c.new_to_old, 0.1 / mean_edge, 0.01);
  EXPECT_GT(c.old_to_new, 0);

  for (const double unit : {0x1p-400, 0x1p400}) {
    const auto in_unit = [unit](TetMesh m) {
      for (Point3& p : m.points) p = {unit * p[0], unit * p[1], unit * p[2]};
      return m;
    };
    const Comparison scaled = compare(in_unit(before), in_unit(after));
    EXPECT_EQ(scaled.volume_change, c.volume_change);
    EXPECT_EQ(scaled.area_change, c.area_change);
    EXPECT_EQ(scaled.mean_edge, unit * c.mean_edge);
    EXPECT_EQ(scaled.new_to_old, c.new_to_old);
    EXPECT_EQ(scaled.old_to_new, c.old_to_new);
  }

  const Comparison sampled = compare(before, after, 0, 20);
  EXPECT_GT(sampled.sample_stride, 10);
  EXPECT_LE(sampled.new_to_old, c.new_to_old);
  EXPECT_LE(sampled.old_to_new, c.old_to_new);
  const Comparison all = compare(before, after, 0, 1000000);
  EXPECT_EQ(all.sample_stride, 1);
  EXPECT_EQ(all.new_to_old, c.new_to_old);

  after.tet_tags[0] = 4;
  after.point_tags[3] = 2;
  TetMesh corner = before;
  corner.corners = {124};
  c = compare(corner, after);
  EXPECT_FALSE(c.tet_tags_kept);
  EXPECT_FALSE(c.vertex_tags_kept);
  EXPECT_EQ(c.corners_moved, 1);
  EXPECT_EQ(c.required_moved, 0);
}

TEST(QualityFloor, TolerancesDoNotAccumulate) {
  QualityFloor floor{3, 1.5};
  floor.add_tolerance();
  const double relaxed = floor.max_cot;
  EXPECT_GT(relaxed, 1.5);
  EXPECT_NEAR(relaxed, 1.5, 2e-12);
  for (int round = 0; round < 5; ++round) floor.limit_cost((1 + QualityFloor::kTolerance) * floor.max_cot, 0);
  EXPECT_EQ(floor.max_cot, relaxed);
  floor.limit_cost(1.25, 0);
  EXPECT_EQ(floor.max_cot, 1.25);
  EXPECT_EQ(floor.safe_shape, QualityFloor::min_shape(1.25));
  EXPECT_EQ(floor.min_cot, -kInfeasible);
}

TEST(QualityFloor, BoundsTheMeanRatio) {
  // Regular tetrahedra stretched by random factors: plates and needles.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> exponent(-3, 3);
  for (int i = 0; i < 2000; ++i) {
    TetMesh m = test::one_tet();
    m.points = {{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}};
    for (const std::size_t axis : {0U, 1U, 2U}) {
      const double factor = std::exp(exponent(random));
      for (Point3& p : m.points) p[axis] *= factor;
    }
    const Quality q = quality(m);
    EXPECT_GE(std::pow(q.shape_sum, 4.0 / 3) * q.mean_ratio, 1 - 1e-12);
    Vec3 p[4];
    for (int k = 0; k < 4; ++k) p[k] = vec(m.points[static_cast<std::size_t>(m.tets[0][static_cast<std::size_t>(k)])]);
    const double w = dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]);
    EXPECT_NEAR(edge_term(p, w) * std::pow(q.mean_ratio, 3) / 432, 1, 1e-12);
    EXPECT_LE(QualityFloor::min_shape_of_mean_ratio(edge_term(p, w)), q.shape_sum);

    QualityFloor floor{kInfeasible, kInfeasible};
    floor.max_edge_term = edge_term(p, w);
    floor.add_tolerance();
    EXPECT_TRUE(floor.allows(q.shape_sum, p, w));
    floor.max_edge_term *= 1 - 1e-9;
    EXPECT_EQ(floor.allows(q.shape_sum, p, w), q.shape_sum <= floor.safe_shape);
    floor.relax_mean_ratio(0.5);
    EXPECT_TRUE(floor.allows(q.shape_sum, p, w));
  }
}

TEST(QualityFloor, AWeightLimitsLargeAnglesToo) {
  QualityFloor floor{3, 1.5};
  floor.limit_cost(1.8, 1.5);
  EXPECT_EQ(floor.max_cot, 1.5);
  EXPECT_DOUBLE_EQ(floor.min_cot, -1.2);
  EXPECT_TRUE(floor.allows(DihedralCots{1.5, -1.2}));
  EXPECT_FALSE(floor.allows(DihedralCots{1.5, -1.21}));
  EXPECT_EQ(DihedralCots({1.5, -1.2}).cost(0), 1.5);
  EXPECT_DOUBLE_EQ(DihedralCots({1.5, -1.2}).cost(2), 2.4);
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <numeric>
#include <random>

#include "mesh/tet_mesh_view.hpp"
#include "support/meshes.hpp"
#include "tetune/error.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// The measures of one tetrahedron.
Measures measures_of(const std::array<Point3, 4>& points) {
  TetMesh m = test::one_tet();
  m.points.assign(points.begin(), points.end());
  return measure_each(m, 1).at(0);
}

double value(const Measures& m, Measure measure) { return m[static_cast<std::size_t>(measure)]; }

constexpr std::array<Point3, 4> kRegular{{{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}}};
constexpr std::array<Point3, 4> kCornerOfCube{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/// Two edges of length 2 that cross at a right angle, `height` apart.
std::array<Point3, 4> sliver(double height) { return {{{-1, 0, 0}, {1, 0, 0}, {0, 1, height}, {0, -1, height}}}; }

void expect_measures(const Measures& m, const Measures& expected, double relative) {
  for (std::size_t k = 0; k < kMeasures; ++k) {
    EXPECT_NEAR(m[k], expected[k], relative * std::fabs(expected[k])) << to_string(static_cast<Measure>(k));
  }
}

/// Random tetrahedra of positive volume, flattened along one axis by up to 10^-6.
std::vector<std::array<Point3, 4>> random_tets(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<std::array<Point3, 4>> tets;
  while (static_cast<int>(tets.size()) < count) {
    std::array<Point3, 4> p;
    const double flat = std::pow(10.0, -3 - 3 * uniform(random));
    for (Point3& x : p) x = {uniform(random), uniform(random), flat * uniform(random)};
    const Vec3 q[4] = {vec(p[0]), vec(p[1]), vec(p[2]), vec(p[3])};
    if (dot(cross(q[1] - q[0], q[2] - q[0]), q[3] - q[0]) < 0) std::swap(p[2], p[3]);
    tets.push_back(p);
  }
  return tets;
}

TEST(Measures, OfTheRegularTetrahedronAreOne) {
  const double angle = std::acos(1.0 / 3) * 180 / std::numbers::pi;
  expect_measures(measures_of(kRegular), {angle, angle, 1, 1, 1, 1, 1, 1, 1}, 1e-14);
}

TEST(Measures, OfTheCornerTetrahedron) {
  // Three edges of 1 and three of sqrt(2), V = 1/6, areas 1/2 and sqrt(3)/2, r = 1 / (3 + sqrt(3)), R = sqrt(3)/2.
  const double r = 1 / (3 + std::sqrt(3.0));
  const double big_r = std::sqrt(3.0) / 2;
  const double eta = (3 * 0.25 + 0.75) * 6;
  expect_measures(measures_of(kCornerOfCube),
                  {std::acos(1 / std::sqrt(3.0)) * 180 / std::numbers::pi, 90, 12 * std::cbrt(0.25) / 9,
                   3 / std::sqrt(9 * 1.5), 3 * r / big_r, std::sqrt(0.5), big_r / (3 * r),
                   std::sqrt(2.0) / (2 * std::sqrt(6.0) * r), 4.5 * std::sqrt(2.0) * std::cbrt(std::sqrt(2.0)) / eta},
                  1e-14);
}

TEST(Measures, OfASliver) {
  for (const double h : {0.5, 1e-3, 1e-6}) {
    // V = 2 h / 3; all areas sqrt(1 + h^2); edges 2, 2 and four of sqrt(2 + h^2); the circumcenter is at h / 2.
    const double v = 2 * h / 3;
    const double a = std::sqrt(1 + h * h);
    const double l2 = 8 + 4 * (2 + h * h);
    const double r = 3 * v / (4 * a);
    const double big_r = std::sqrt(1 + h * h / 4);
    // At an edge of 2: tan(half the angle) = 1 / h. At the others: sin = 3 l V / (2 A^2).
    const double wide = 2 * std::atan(1 / h) * 180 / std::numbers::pi;
    const double narrow = std::asin(3 * std::sqrt(2 + h * h) * v / (2 * a * a)) * 180 / std::numbers::pi;
    const double product = 2 * (2 + h * h);
    expect_measures(measures_of(sliver(h)),
                    {narrow, wide, 12 * std::cbrt(9 * v * v) / l2, 18 * v / (std::sqrt(l2) * 2 * a), 3 * r / big_r,
                     std::sqrt(2.0) * 6 * v / product, big_r / (3 * r), 2 / (2 * std::sqrt(6.0) * r),
                     4.5 * std::sqrt(2.0) * std::cbrt(6 * std::sqrt(2.0) * v) * v / (4 * a * a)},
                    1e-9);
  }
}

TEST(Measures, AgreeWithOtherPrograms) {
  struct Case {
    std::array<Point3, 4> points;
    Measures expected;
  };
  // scaled_jacobian, radius_ratio, aspect_ratio: VTK 9.7.2 (Verdict) through pyvista 0.49.1's cell_quality();
  // mean_ratio, sicn, gamma: Gmsh 4.15.2's getElementQualities() "eta", "minSICN", "gamma". q_h is Gmsh's
  // minSICN^2 / eta. Angles: numpy, by_numpy() in bench/peers/check_measures.py.
  const std::vector<Case> cases = {
      {{{{0, 0, 0}, {2, 0, 0}, {0.5, 1.5, 0}, {0.25, 0.5, 1.25}}},
       {54.735610317245346, 86.38111677001676, 0.8955389441335068, 0.8993566280372793, 0.8793298781158787,
        0.5661385170722979, 1.1372296391687258, 1.312486778959554, 0.9031905867334377}},
      {{{{-1, 0, 0}, {1, 0.1, 0}, {0.2, 1, 0.05}, {0.1, -1, 0.02}}},
       {2.510774698832747, 175.86402291847097, 0.1280866582416397, 0.05315921745873228, 0.05136032205286498,
        0.043494037355073165, 19.470282896018226, 22.81459296603935, 0.02206242585776287}},
      {{{{0, 0, 0}, {0.01, 0, 0}, {0, 0.02, 0}, {0.3, 0.1, 5}}},
       {26.515867949195357, 93.48050194700558, 0.0010040344925216272, 0.0043660239384984215, 0.004555816088611354,
        1.1248292755210908e-05, 219.49964189726435, 268.34579889586877, 0.018985567899830556}},
      {{{{0, 0, 0}, {1, 0, 0}, {0.4, 0.9, 0}, {0.5, 0.3, 0.01}}},
       {1.7094864536244376, 176.96399808688372, 0.07805687103782191, 0.025359150051733392, 0.0008566453409923321,
        0.01963899080140173, 1167.3442347116563, 44.17181001169841, 0.008238691646180983}},
  };
  for (const Case& c : cases) {
    expect_measures(measures_of(c.points), c.expected, 1e-10);
  }
}

TEST(Measures, DoNotDependOnUnitPositionOrOrder) {
  const double s = std::sqrt(0.5);
  for (const std::array<Point3, 4>& p : random_tets(200)) {
    const Measures m = measures_of(p);
    std::array<Point3, 4> q;
    for (std::size_t k = 0; k < 4; ++k) {  // rotated by 45 degrees about z, coordinates permuted, scaled by 1000
      q[k] = {1000 * p[k][2], 1000 * s * (p[k][0] - p[k][1]), 1000 * s * (p[k][0] + p[k][1])};
    }
    expect_measures(measures_of(q), m, 1e-7);
    expect_measures(measures_of({p[1], p[2], p[0], p[3]}), m, 1e-7);
    for (Point3& x : q = p) {
      for (double& c : x) c *= 0x1p-300;
    }
    EXPECT_EQ(measures_of(q), m);
  }
}

TEST(Measures, TheInverseConditionNumberIsTheMeanOfTwoOthers) {
  for (const std::array<Point3, 4>& p : random_tets(500)) {
    const Measures m = measures_of(p);
    EXPECT_NEAR(value(m, Measure::sicn), std::sqrt(value(m, Measure::mean_ratio) * value(m, Measure::harmonic)),
                1e-12 * value(m, Measure::sicn));
  }
}

TEST(Measures, OfFlatAndInvertedTetrahedraAreTheWorst) {
  const Measures flat = measures_of(sliver(0));
  const Measures expected{0, 180, 0, 0, 0, 0, kFlatRatio, kFlatRatio, 0};
  EXPECT_EQ(flat, expected);
  EXPECT_EQ(value(measures_of({}), Measure::gamma), 0);  // all four vertices coincide
  const Measures inverted = measures_of({kRegular[1], kRegular[0], kRegular[2], kRegular[3]});
  EXPECT_NEAR(value(inverted, Measure::sicn), -1, 1e-14);
  EXPECT_NEAR(value(inverted, Measure::scaled_jacobian), -1, 1e-14);
  EXPECT_EQ(value(inverted, Measure::mean_ratio), 0);
  EXPECT_EQ(value(inverted, Measure::radius_ratio), kFlatRatio);
  // In the unit of a mesh so large, the circumradius underflows.
  TetMesh tiny = test::one_tet();
  const std::array<Point3, 4> thin = sliver(0.003);
  tiny.points.assign(thin.begin(), thin.end());
  for (Point3& p : tiny.points) p = {1e-45 * p[0], 1e-45 * p[1], 1e-45 * p[2]};
  tiny.points.push_back({1, 0, 0});
  tiny.point_tags.push_back(0);
  ASSERT_TRUE(validate(tiny).ok());
  EXPECT_EQ(value(measure_each(tiny, 1).at(0), Measure::radius_ratio), kFlatRatio);
}

/// docs/method.md, "Quality floor": a bound on the dihedral angles of a tetrahedron of given shape energy.
TEST(Measures, TheShapeEnergyBoundsEveryAngle) {
  std::vector<std::array<Point3, 4>> tets = random_tets(20000);
  tets.push_back(kRegular);
  tets.push_back(kCornerOfCube);
  for (const double h : {1.0, 0.1, 1e-3, 1e-5}) tets.push_back(sliver(h));
  double min_ratio = 10;
  for (const std::array<Point3, 4>& p : tets) {
    const double shape = std::pow(value(measures_of(p), Measure::harmonic), -1.5);
    const Vec3 q[4] = {vec(p[0]), vec(p[1]), vec(p[2]), vec(p[3])};
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) {
        // The dihedral angle at the edge (i, j), from the normals of its two faces.
        const int k = i == 0 ? (j == 1 ? 2 : 1) : 0;
        const int l = 6 - i - j - k;
        const Vec3 e = q[j] - q[i];
        const Vec3 u = cross(e, q[k] - q[i]);
        const Vec3 v = cross(e, q[l] - q[i]);
        const double angle = std::atan2(norm(cross(u, v)), dot(u, v));
        const double ratio = shape * std::sin(angle) / ((3 - std::cos(angle)) / (2 * std::sqrt(2.0)));
        EXPECT_GE(ratio, 1 - 1e-7);
        EXPECT_GE(shape * std::sin(angle), std::sqrt(0.5) * (1 - 1e-7));
        min_ratio = std::min(min_ratio, ratio);
      }
    }
  }
  EXPECT_LT(min_ratio, 1 + 1e-12);  // equality for the regular tetrahedron
  // Equality holds at each angle t for the tetrahedron of the proof: an edge of length 1, both triangles at it of
  // height h, the midpoint of the opposite edge above its own.
  for (const double t : {0.001, 0.1, 0.7, 1.5, 2.5}) {
    const double h = std::sqrt((3 - std::cos(t)) / (4 * std::sin(t) * std::sin(t)));
    const std::array<Point3, 4> p{{{0, 0, -0.5}, {0, 0, 0.5}, {h, 0, 0}, {h * std::cos(t), h * std::sin(t), 0}}};
    const double shape = std::pow(value(measures_of(p), Measure::harmonic), -1.5);
    EXPECT_NEAR(shape * std::sin(t) / ((3 - std::cos(t)) / (2 * std::sqrt(2.0))), 1, 1e-9) << t;
  }
}

TEST(MeasureAll, SummarizesMeasureEach) {
  const TetMesh m = test::cube(7, 0.25);
  const std::vector<Measures> each = measure_each(m);
  const Quality q = measure_all(m, 2, 25);
  const std::size_t n = each.size();
  for (std::size_t k = 0; k < kMeasures; ++k) {
    const bool low = larger_is_better(static_cast<Measure>(k));
    std::vector<double> values;
    double sum = 0;
    for (const Measures& e : each) {
      values.push_back(e[k]);
      sum += e[k];
    }
    std::sort(values.begin(), values.end());
    EXPECT_EQ(q.measures[k].min, values.front());
    EXPECT_EQ(q.measures[k].max, values.back());
    EXPECT_NEAR(q.measures[k].mean, sum / static_cast<double>(n), 1e-12 * std::fabs(sum / static_cast<double>(n)));
    if (!low) std::reverse(values.begin(), values.end());
    EXPECT_NEAR(q.measures[k].p1, values[n / 100], 1e-7 * std::fabs(values[n / 100]));
    EXPECT_NEAR(q.measures[k].p5, values[n / 20], 1e-7 * std::fabs(values[n / 20]));
  }
  EXPECT_EQ(q.of(Measure::min_dihedral).min, q.dihedral_min);
  EXPECT_EQ(q.of(Measure::max_dihedral).max, q.dihedral_max);
  EXPECT_EQ(q.of(Measure::mean_ratio).min, q.mean_ratio_min);
  EXPECT_EQ(q.of(Measure::mean_ratio).mean, q.mean_ratio);

  std::vector<Index> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&each](Index a, Index b) {
    return each[static_cast<std::size_t>(a)][0] < each[static_cast<std::size_t>(b)][0];
  });
  ASSERT_EQ(q.worst.size(), 25U);
  EXPECT_EQ(q.worst[0].tet, q.worst_tet);
  for (std::size_t i = 0; i < q.worst.size(); ++i) {
    const auto t = static_cast<std::size_t>(order[i]);
    EXPECT_EQ(q.worst[i].tet, order[i]);
    EXPECT_EQ(q.worst[i].dihedral, each[t][0]);
    EXPECT_EQ(q.worst[i].harmonic, value(each[t], Measure::harmonic));
    EXPECT_EQ(q.worst[i].centroid, TetMeshView(m).centroid(order[i]));
  }
}

TEST(MeasureAll, AgreesWithQualityForAnyNumberOfThreads) {
  const TetMesh m = test::cube(6, 0.2);
  const Quality plain = quality(m, 1);
  EXPECT_TRUE(plain.worst.empty());
  const Quality one = measure_all(m, 1);
  EXPECT_EQ(one.worst.size(), 10U);
  EXPECT_EQ(one.eta_sum, plain.eta_sum);
  EXPECT_EQ(one.shape_sum, plain.shape_sum);
  EXPECT_EQ(one.dihedral_mean, plain.dihedral_mean);
  for (const int threads : {2, 3}) {
    const Quality q = measure_all(m, threads);
    for (std::size_t k = 0; k < kMeasures; ++k) {
      EXPECT_EQ(q.measures[k].min, one.measures[k].min);
      EXPECT_EQ(q.measures[k].p1, one.measures[k].p1);
      EXPECT_EQ(q.measures[k].p5, one.measures[k].p5);
      EXPECT_EQ(q.measures[k].mean, one.measures[k].mean);
      EXPECT_EQ(q.measures[k].max, one.measures[k].max);
    }
    for (std::size_t i = 0; i < q.worst.size(); ++i) EXPECT_EQ(q.worst[i].tet, one.worst[i].tet);
  }
}

TEST(MeasureAll, OfOneAndOfNoTetrahedron) {
  const Quality one = measure_all(test::one_tet());
  EXPECT_EQ(one.worst.size(), 1U);
  EXPECT_EQ(one.of(Measure::aspect_ratio).min, one.of(Measure::aspect_ratio).p1);
  EXPECT_TRUE(measure_all(test::one_tet(), 0, 0).worst.empty());
  EXPECT_EQ(measure_all(TetMesh{}).of(Measure::gamma).mean, 0);
  TetMesh wild = test::one_tet();
  wild.tets[0][0] = 9;
  EXPECT_THROW(measure_all(wild), MeshError);
  EXPECT_THROW(measure_each(wild), MeshError);
}

TEST(WriteMeasures, AsAMeditSolution) {
  const std::string folder = testing::TempDir() + "tetune_measures";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directory(folder);
  const TetMesh m = test::cube(3, 0.2);
  write_measures(folder + "/m.sol", m);
  std::vector<std::string> words;
  {
    std::ifstream file(folder + "/m.sol");
    std::string word;
    while (file >> word) words.push_back(word);
  }
  const std::vector<std::string> head = {"MeshVersionFormatted", "2", "Dimension", "3", "SolAtTetrahedra", "162", "9"};
  ASSERT_EQ(words.size(), head.size() + kMeasures + 162 * kMeasures + 1);
  EXPECT_TRUE(std::equal(head.begin(), head.end(), words.begin()));
  EXPECT_EQ(words.back(), "End");
  std::size_t at_word = head.size();
  for (std::size_t k = 0; k < kMeasures; ++k) EXPECT_EQ(words[at_word++], "1");
  for (const Measures& e : measure_each(m)) {
    for (const double value : e) EXPECT_EQ(std::stod(words[at_word++]), value);
  }
  EXPECT_THROW(write_measures(folder + "/m.mesh", m), FileError);
  EXPECT_THROW(write_measures(folder + "/absent/m.sol", m), FileError);
  TetMesh wild = test::one_tet();
  wild.tets[0][0] = 9;
  EXPECT_THROW(write_measures(folder + "/wild.sol", wild), MeshError);
  const std::filesystem::directory_iterator entries(folder);
  EXPECT_EQ(std::distance(begin(entries), end(entries)), 1);  // no partially written file
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace tetune

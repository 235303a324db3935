// SPDX-License-Identifier: Apache-2.0
// Acceptance criteria: measures against closed formulas, and verdicts.
#include "tetune/criteria.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <utility>

#include "driver/report/targets.hpp"
#include "math/orient.hpp"
#include "quality/check_measures.hpp"
#include "support/meshes.hpp"
#include "tetune/error.hpp"
#include "tetune/quality.hpp"

namespace tetune {
namespace {

TetMesh regular() {
  TetMesh m;
  m.points = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  m.tets = {{0, 2, 1, 3}};
  return test::with_tags(m);
}

CriterionResult result_of(const TetMesh& mesh, const AcceptanceCriterion& criterion, int threads = 1) {
  return check(mesh, {"test", {criterion}}, threads).results.at(0);
}

/// The worst value of a measure.
double worst(const TetMesh& mesh, CheckMeasure measure) {
  const double best = info_of(measure).best;
  return result_of(mesh, {measure, std::isinf(best) ? 0 : best, {}}).worst;
}

TEST(CheckMeasures, TableIsInOrder) {
  std::set<std::string> names;
  std::size_t k = 0;
  for (const CheckMeasureInfo& measure : check_measures()) {
    EXPECT_EQ(measure.measure, static_cast<CheckMeasure>(k++));
    EXPECT_TRUE(names.insert(measure.name).second);
    EXPECT_EQ(find_check_measure(measure.name), &measure);
    EXPECT_EQ(&info_of(measure.measure), &measure);
  }
  EXPECT_EQ(find_check_measure("beauty"), nullptr);
}

TEST(CheckMeasures, TheFirstOnesAreThoseOfQuality) {
  const TetMesh mesh = test::cube(3, 0.2);
  const Quality quality = measure_all(mesh, 1, 1);
  for (std::size_t k = 0; k < kMeasures; ++k) {
    const MeasureSummary& summary = quality.measures[k];
    const bool larger = larger_is_better(static_cast<Measure>(k));
    EXPECT_EQ(worst(mesh, static_cast<CheckMeasure>(k)), larger ? summary.min : summary.max) << k;
  }
}

TEST(CheckMeasures, RegularTetrahedron) {
  const double edge = 2 * std::sqrt(2.0);
  const double altitude = edge * std::sqrt(2.0 / 3);
  for (const auto& [measure, expected] : {std::pair{CheckMeasure::volume, 8.0 / 3},
                                          {CheckMeasure::jacobian_ratio, 1.0},
                                          {CheckMeasure::min_face_angle, 60.0},
                                          {CheckMeasure::max_face_angle, 60.0},
                                          {CheckMeasure::equiangle_skew, 0.0},
                                          {CheckMeasure::volume_skew, 0.0},
                                          {CheckMeasure::collapse, 1.0},
                                          {CheckMeasure::edge_ratio, 1.0},
                                          {CheckMeasure::edge_altitude_ratio, std::sqrt(1.5)},
                                          // Of the sections: a triangle of sides 1, sqrt(3)/2, sqrt(3)/2.
                                          {CheckMeasure::triangle_aspect, 1.375 * std::sqrt(2.0 / 3)},
                                          {CheckMeasure::shortest_edge, edge},
                                          {CheckMeasure::min_altitude, altitude},
                                          {CheckMeasure::orthogonal_quality, 1.0},
                                          {CheckMeasure::face_skewness, 0.0}}) {
    EXPECT_NEAR(worst(regular(), measure), expected, 1e-14 * std::max(1.0, expected) + 1e-14) << info_of(measure).name;
  }
}

TEST(CheckMeasures, VolumesBeyondTheRangeOfDoublesAreItsEnds) {
  const TetMesh cube = test::cube(2, 0.2);
  for (const auto& [scale, expected] : {std::pair{1e-149, std::numeric_limits<double>::min()},
                                        {1e-101, worst(cube, CheckMeasure::volume) * 1e-101 * 1e-101 * 1e-101},
                                        {1e149, std::numeric_limits<double>::max()}}) {
    TetMesh mesh = test::scaled(cube, scale);
    EXPECT_NEAR(worst(mesh, CheckMeasure::volume) / expected, 1, 1e-12) << scale;
    for (const AcceptanceCriteria& preset : preset_criteria()) {
      if (preset.name == "calculix" && scale < 1) continue;  // its limit is no sign
      const CriterionResult volumes = check(mesh, preset).results.at(0);
      EXPECT_EQ(volumes.verdict, Verdict::pass) << preset.name << " " << scale;
    }
    std::swap(mesh.tets[3][2], mesh.tets[3][3]);
    EXPECT_LT(worst(mesh, CheckMeasure::volume), 0) << scale;
    EXPECT_EQ(check(mesh, *find_preset("abaqus")).results.at(0).failed, 1) << scale;
  }
}

/// Three points on a line to rounding, whose volume with a fourth one has a sign that floating-point arithmetic misses.
TEST(CheckMeasures, VolumesHaveTheExactSign) {
  TetMesh mesh = test::one_tet();
  for (int i = 0; i < 16; ++i) {
    for (int k = 0; k < 16; ++k) {
      mesh.points = {{0.5 + i * 0x1p-53, 0.5 + k * 0x1p-53, 0}, {12, 12, 0}, {24, 24, 0}, {0, 0, 1}};
      mesh.tets = {{0, 1, 2, 3}};
      const int sign = orient_sign(mesh.points[0], mesh.points[1], mesh.points[2], mesh.points[3]);
      const double volume = worst(mesh, CheckMeasure::volume);
      EXPECT_EQ((volume > 0) - (volume < 0), sign) << i << " " << k;
    }
  }
}

/// A sliver: its faces are well shaped, and the angles between them are not.
TEST(CheckMeasures, EquiangleSkewCountsDihedralAngles) {
  TetMesh mesh = test::one_tet();
  const double z = 0.01;
  mesh.points = {{-1, 0, z}, {1, 0, z}, {0, -1, -z}, {0, 1, -z}};
  mesh.tets = {{0, 1, 2, 3}};
  ASSERT_LT(0, worst(mesh, CheckMeasure::volume));
  const double smallest = quality(mesh).dihedral_min;
  const double largest = quality(mesh).dihedral_max;
  EXPECT_NEAR(worst(mesh, CheckMeasure::max_face_angle), 90, 0.02);
  const double regular = kRegularDihedral;
  EXPECT_NEAR(worst(mesh, CheckMeasure::equiangle_skew),
              std::max((largest - regular) / (180 - regular), (regular - smallest) / regular), 1e-12);
}

TEST(CheckMeasures, CornerOfACube) {
  for (const double scale : {1.0, 1e-90, 1e90}) {
    const TetMesh mesh = test::scaled(test::one_tet(), scale);
    for (const auto& [measure, expected] : {std::pair{CheckMeasure::min_face_angle, 45.0},
                                            {CheckMeasure::max_face_angle, 90.0},
                                            {CheckMeasure::equiangle_skew, 0.25},
                                            {CheckMeasure::volume_skew, 0.5},
                                            {CheckMeasure::collapse, 0.5},
                                            {CheckMeasure::edge_ratio, std::sqrt(2.0)},
                                            {CheckMeasure::edge_altitude_ratio, std::sqrt(6.0)},
                                            {CheckMeasure::orthogonal_quality, 0.5}}) {
      EXPECT_NEAR(worst(mesh, measure), expected, 1e-13 * expected) << info_of(measure).name;
    }
    EXPECT_NEAR(worst(mesh, CheckMeasure::shortest_edge), scale, 1e-14 * scale);
    EXPECT_NEAR(worst(mesh, CheckMeasure::min_altitude), scale / std::sqrt(3.0), 1e-14 * scale);
    EXPECT_NEAR(worst(mesh, CheckMeasure::volume) / scale / scale / scale, 1.0 / 6, 1e-14);
  }
}

/// Two tetrahedra at the triangle of test::two_tets(), the upper one with its apex above a corner.
TetMesh leaning() {
  TetMesh mesh = test::two_tets(1);
  mesh.points[0] = {1, 0, 1};
  return mesh;
}

TEST(CheckMeasures, AnglesHaveTheSameBitsEverywhere) {
  // C libraries differ in the last bits: one has ...46p+7, ...6fp+5 and ...ecp+5.
  EXPECT_EQ(angle_between({-1, 5, 2}, {5, -5, -4}), 0x1.294bbfa6e5045p+7);
  EXPECT_EQ(angle_between({0, 4, -1}, {-2, 2, 0}), 0x1.757d38b86856ep+5);
  EXPECT_EQ(angle_between({-3, -1, 4}, {-3, -5, 0}), 0x1.ef45f1ff145eep+5);
  EXPECT_EQ(angle_between({1, 0, 0}, {0, 1, 0}), 90);
}

TEST(CheckMeasures, Faces) {
  // Between the centroids (1/4, 0, 1/4) and (0, 0, -1/4), through the face at (1/8, 0, 0); the face has its corners at
  // a distance of 1 from its centroid, the origin, in this direction.
  EXPECT_NEAR(worst(leaning(), CheckMeasure::non_orthogonality), std::atan(0.5) * 180 / std::acos(-1.0), 1e-12);
  const CriterionResult faces = result_of(leaning(), {CheckMeasure::non_orthogonality, 30.0, {}});
  EXPECT_EQ(faces.count, 1);
  EXPECT_EQ(faces.verdict, Verdict::pass);
  EXPECT_EQ(result_of(leaning(), {CheckMeasure::face_skewness, 30.0, {}}).count, 7);
  EXPECT_NEAR(worst(test::two_tets(std::sqrt(2.0)), CheckMeasure::face_skewness), 0, 1e-14);
  EXPECT_NEAR(worst(test::two_tets(std::sqrt(2.0)), CheckMeasure::non_orthogonality), 0, 1e-6);
  EXPECT_NEAR(worst(test::two_tets(std::sqrt(2.0)), CheckMeasure::orthogonal_quality), 1, 1e-14);
}

TEST(CheckMeasures, SkewnessOfOneFace) {
  const double s = std::sqrt(3.0) / 2;
  const Vec3 corners[3] = {{1, 0, 0}, {-0.5, s, 0}, {-0.5, -s, 0}};
  const Vec3 own{0.25, 0, 0.25};
  const Vec3 neighbor{0, 0, -0.25};
  // The centroids of leaning(): see above.
  EXPECT_NEAR(face_skewness(corners, {0, 0, -2}, own, &neighbor), 0.125, 1e-15);
  // On the boundary the line is the normal through the centroid (1/4, 0, 1/4).
  EXPECT_NEAR(face_skewness(corners, {0, 0, -2}, own, nullptr), 0.25, 1e-15);
  // Far from a small face, 0.2 of the line is its size.
  const Vec3 far_above{3, 0, 20};
  const Vec3 far_below{0, 0, -20};
  EXPECT_NEAR(face_skewness(corners, {0, 0, -2}, far_above, &far_below), 1.5 / (0.2 * std::sqrt(1609.0)), 1e-14);
}

TEST(CheckMeasures, InvertedAndFlat) {
  TetMesh mesh = test::one_tet();
  std::swap(mesh.tets[0][2], mesh.tets[0][3]);
  EXPECT_NEAR(worst(mesh, CheckMeasure::volume), -1.0 / 6, 1e-15);
  EXPECT_EQ(worst(mesh, CheckMeasure::volume_skew), 1);
  EXPECT_LT(worst(mesh, CheckMeasure::collapse), 0);
  EXPECT_EQ(worst(mesh, CheckMeasure::edge_altitude_ratio), kFlatRatio);
  mesh.points[3] = {0.25, 0.25, 0};
  EXPECT_EQ(worst(mesh, CheckMeasure::volume_skew), 1);
  for (const AcceptanceCriteria& preset : preset_criteria()) {
    EXPECT_EQ(check(mesh, preset).verdict, Verdict::fail) << preset.name;
    EXPECT_EQ(check(test::cube(2), preset).verdict, Verdict::pass) << preset.name;
  }
}

TEST(Acceptance, VerdictsByLimitsAndAllowedPart) {
  const TetMesh mesh = test::cube(4, 0.25, 5);
  const std::vector<Measures> measures = measure_each(mesh);
  std::vector<double> ratios;
  for (const Measures& m : measures) ratios.push_back(m[static_cast<std::size_t>(Measure::mean_ratio)]);
  std::sort(ratios.begin(), ratios.end());
  const auto percent = [&](double count) { return 100 * count / static_cast<double>(ratios.size()); };
  const auto judge = [&](double warn, double fail, double allowed) {
    return result_of(mesh, {CheckMeasure::mean_ratio, warn, fail, allowed});
  };
  // ratios[5] itself meets the limit.
  CriterionResult r = judge(ratios[5], ratios[2], 0);
  EXPECT_EQ(r.failed, 2);
  EXPECT_EQ(r.warned, 3);
  EXPECT_EQ(r.count, static_cast<std::int64_t>(ratios.size()));
  EXPECT_EQ(r.verdict, Verdict::fail);
  EXPECT_EQ(r.worst, ratios[0]);
  EXPECT_EQ(measures[static_cast<std::size_t>(r.worst_tet)][static_cast<std::size_t>(Measure::mean_ratio)], ratios[0]);
  EXPECT_EQ(judge(ratios[5], ratios[2], percent(2.5)).verdict, Verdict::warn);
  EXPECT_EQ(judge(ratios[5], ratios[0], 0).verdict, Verdict::warn);
  EXPECT_EQ(judge(ratios[5], ratios[0], percent(5.5)).verdict, Verdict::pass);
  EXPECT_EQ(judge(ratios[0], ratios[0], 0).verdict, Verdict::pass);
}

TEST(Acceptance, TheMeshHasTheWorstVerdict) {
  const TetMesh mesh = test::cube(4, 0.25, 5);
  AcceptanceCriteria criteria{"mine", {{CheckMeasure::mean_ratio, {}, 1e-3}, {CheckMeasure::edge_ratio, 1.0, {}}}};
  EXPECT_EQ(check(mesh, criteria).verdict, Verdict::warn);
  criteria.criteria[1].fail = 1.1;
  const AcceptanceReport report = check(mesh, criteria, 1);
  EXPECT_EQ(report.verdict, Verdict::fail);
  EXPECT_EQ(report.results[0].verdict, Verdict::pass);
  EXPECT_STREQ(to_string(report.verdict), "fail");
  const AcceptanceReport parallel = check(mesh, criteria, 3);
  EXPECT_EQ(parallel.results[1].worst, report.results[1].worst);
  EXPECT_EQ(parallel.results[1].worst_tet, report.results[1].worst_tet);
  EXPECT_EQ(check(TetMesh{}, criteria).verdict, Verdict::fail);
}

TEST(Acceptance, PresetsAreComplete) {
  std::set<std::string> names;
  for (const AcceptanceCriteria& preset : preset_criteria()) {
    EXPECT_EQ(find_preset(preset.name), &preset);
    names.insert(preset.name);
    for (const AcceptanceCriterion& criterion : preset.criteria) {
      EXPECT_NO_THROW(check_criterion(criterion));
      EXPECT_NE(criterion.source, "");
    }
  }
  EXPECT_EQ(names, (std::set<std::string>{"abaqus", "ansys", "calculix", "fluent", "nastran", "openfoam"}));
  EXPECT_EQ(find_preset("Abaqus"), nullptr);
}

bool is_refused(const AcceptanceCriterion& criterion) {
  try {
    check_criterion(criterion);
  } catch (const OptionError&) {
    return true;
  }
  return false;
}

TEST(Acceptance, WrongCriteriaAreRefused) {
  const TetMesh mesh = test::one_tet();
  const auto refusal = [&](const AcceptanceCriterion& criterion) -> std::string {
    try {
      result_of(mesh, criterion);
    } catch (const OptionError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(refusal({CheckMeasure::collapse, {}, {}}),
            "the criterion for collapse has no limit; give warn, fail or both");
  EXPECT_NE(refusal({CheckMeasure::collapse, std::numeric_limits<double>::quiet_NaN(), {}}), "");
  EXPECT_NE(refusal({CheckMeasure::collapse, 0.1, 0.2}), "");
  EXPECT_EQ(refusal({CheckMeasure::collapse, 0.2, 0.1}), "");
  EXPECT_NE(refusal({CheckMeasure::edge_ratio, 5, 4}), "");
  EXPECT_EQ(refusal({CheckMeasure::edge_ratio, 4, 5}), "");
  EXPECT_NE(refusal({CheckMeasure::edge_ratio, 4, 5, 101}), "");
}

TEST(Acceptance, LimitsThatNoElementMeetsAreRefused) {
  for (const CheckMeasureInfo& measure : check_measures()) {
    const double by = std::isinf(measure.best) ? 1e300 : 0.01 * (measure.larger_is_better ? 1 : -1);
    const double limit = std::isinf(measure.best) ? by : measure.best + by;
    for (const AcceptanceCriterion& c :
         {AcceptanceCriterion{measure.measure, limit, {}}, AcceptanceCriterion{measure.measure, {}, limit}}) {
      EXPECT_EQ(!std::isinf(measure.best), is_refused(c)) << measure.name;
    }
    EXPECT_FALSE(is_refused({measure.measure, {}, std::isinf(measure.best) ? 0 : measure.best})) << measure.name;
  }
  EXPECT_FALSE(is_refused({CheckMeasure::min_dihedral, {}, 70.5288}));
  EXPECT_FALSE(is_refused({CheckMeasure::edge_altitude_ratio, {}, 1.22474}));
  try {
    check_criterion({CheckMeasure::scaled_jacobian, 0.9, 1.2});
    ADD_FAILURE() << "accepted";
  } catch (const OptionError& e) {
    EXPECT_STREQ(
        e.what(),
        "the criterion for scaled_jacobian fails by the limit 1.2, which no element meets: the best value is 1");
  }
}

/// Tetrahedra near the regular one are not better than the bounds.
TEST(CheckMeasures, NoTetrahedronExceedsTheBestValue) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    TetMesh mesh = regular();
    const double size = std::pow(10, -(i % 5));
    for (Point3& p : mesh.points) {
      for (double& x : p) x += size * std::uniform_real_distribution<double>(-1, 1)(random);
    }
    for (const CheckMeasureInfo& measure : check_measures()) {
      if (std::isinf(measure.best) || measure.of_faces) continue;
      const double value = worst(mesh, measure.measure);
      const double above = measure.larger_is_better ? value - measure.best : measure.best - value;
      EXPECT_LE(above, 1e-12 * (1 + measure.best)) << measure.name;
    }
  }
}

TEST(Criteria, ValuesThatAreNoNumbersAreTheWorst) {
  for (const bool larger_is_better : {true, false}) {
    std::vector<MissedTet> missed;
    for (Index t = 0; t < 100; ++t) {
      MissedTet m;
      m.tet = t;
      m.value = t % 3 == 0 ? std::nan("") : t % 7;
      missed.push_back(m);
    }
    keep_worst(larger_is_better, missed);
    for (std::size_t i = 0; i < 34; ++i) {
      EXPECT_TRUE(std::isnan(missed[i].value));
      EXPECT_EQ(missed[i].tet, Index(3 * i));
    }
    for (std::size_t i = 35; i < missed.size(); ++i) {
      const MissedTet& a = missed[i - 1];
      const MissedTet& b = missed[i];
      EXPECT_TRUE(a.value == b.value ? a.tet < b.tet : (a.value < b.value) == larger_is_better);
    }
  }
}

}  // namespace
}  // namespace tetune

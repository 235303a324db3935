// SPDX-License-Identifier: Apache-2.0
// Rounds on the elements that fail acceptance criteria, and the constraints of what still fails.
#include "tetune/optimize_towards.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "driver/criteria_losses.hpp"
#include "support/curved.hpp"
#include "support/meshes.hpp"
#include "tetune/curved.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

AcceptanceCriteria one(CheckMeasure measure, double fail) { return {"test", {{measure, {}, fail}}}; }

TetMesh lattice_input() {
  TetMesh mesh = test::scrambled(test::cube(5, 0.3, 3), 2, 3);
  DataArray number{"number", 1, {}};
  std::vector<double> values(mesh.points.size());
  std::iota(values.begin(), values.end(), 0.0);
  number.values = std::move(values);
  mesh.point_data.push_back(number);
  return mesh;
}

/// A layer that the energy makes worse by other measures.
TetMesh thin_layer() {
  TetMesh mesh = test::cube(6, 0.2);
  for (Point3& p : mesh.points) p[2] *= 0.02;
  return mesh;
}

double smallest_scaled_jacobian(const TetMesh& mesh) {
  double least = 1;
  for (const Measures& m : measure_each(mesh)) least = std::min(least, m[std::size_t(Measure::scaled_jacobian)]);
  return least;
}

TEST(OptimizeTowards, RoundsMakeFailingElementsPass) {
  for (const auto& [measure, limit] : {std::pair{CheckMeasure::equiangle_skew, 0.532},
                                       {CheckMeasure::volume_skew, 0.58},
                                       {CheckMeasure::orthogonal_quality, 0.42}}) {
    const AcceptanceCriteria criteria = one(measure, limit);
    TetMesh plain = lattice_input();
    optimize(plain);
    ASSERT_EQ(check(plain, criteria).verdict, Verdict::fail) << info_of(measure).name;
    TetMesh mesh = lattice_input();
    const CriteriaReport report = optimize_towards(mesh, criteria);
    EXPECT_EQ(check(mesh, criteria).verdict, Verdict::pass) << info_of(measure).name;
    EXPECT_EQ(report.after.verdict, Verdict::pass);
    EXPECT_TRUE(report.limits.empty());
    EXPECT_GE(quality(mesh).dihedral_min, quality(plain).dihedral_min);
    EXPECT_TRUE(validate(mesh).ok());
    EXPECT_EQ(report.optimization.tets_after, std::ssize(mesh.tets));
    EXPECT_EQ(report.optimization.tet2original.size(), mesh.tets.size());
    EXPECT_EQ(mesh.point_data.at(0).values, lattice_input().point_data.at(0).values);
  }
}

/// A thin layer of which every tetrahedron meets the limit, and the energy would make some miss it.
TEST(OptimizeTowards, AMeshThatPassesIsNotMadeToFail) {
  TetMesh mesh = thin_layer();
  const TetMesh before = mesh;
  const double least = smallest_scaled_jacobian(mesh);
  const AcceptanceCriteria criteria = one(CheckMeasure::scaled_jacobian, 0.999 * least);
  Options options;
  options.targets = {{Measure::scaled_jacobian, 1.001 * least}};
  options.device = Device::automatic;
  const CriteriaReport report = optimize_towards(mesh, criteria, options);
  EXPECT_NE(report.optimization.unchanged, "");
  EXPECT_EQ(report.undone, report.optimization.unchanged);
  EXPECT_EQ(report.optimization.warnings, std::vector{report.optimization.unchanged});
  EXPECT_EQ(report.after.verdict, Verdict::pass);
  EXPECT_EQ(mesh.points, before.points);
  EXPECT_EQ(mesh.tets, before.tets);
  ASSERT_EQ(report.optimization.targets.size(), 1U);
  EXPECT_EQ(report.optimization.targets[0].missed, 1);
  EXPECT_EQ(report.optimization.tets_after, std::ssize(before.tets));
  EXPECT_EQ(report.optimization.tet2original.size(), before.tets.size());
  // The run was made, on this device.
  EXPECT_FALSE(report.optimization.device_reason.empty());
  EXPECT_GT(report.optimization.colors, 0);
  EXPECT_GT(report.optimization.free_vertices, 0);
  EXPECT_FALSE(report.optimization.phases.empty());
}

/// The report of an input that was put back is about the input.
TEST(OptimizeTowards, AKeptInputIsReportedAsTheResult) {
  TetMesh mesh = thin_layer();
  mesh.point_data.push_back({"field", 1, std::vector<double>(mesh.points.size(), 1.0)});
  const double least = smallest_scaled_jacobian(mesh);
  const AcceptanceCriteria criteria = one(CheckMeasure::scaled_jacobian, 0.999 * least);
  Options options;
  TetMesh carried = mesh;
  const Report of_carried = optimize_towards(carried, criteria, options).optimization;
  ASSERT_NE(of_carried.unchanged, "");
  EXPECT_TRUE(of_carried.moved_fields.empty());
  EXPECT_EQ(of_carried.warnings, std::vector{of_carried.unchanged});
  options.data = DataTransfer::interpolate;
  const Report of_places = optimize_towards(mesh, criteria, options).optimization;
  ASSERT_NE(of_places.unchanged, "");
  ASSERT_EQ(of_places.places.size(), mesh.points.size());
  EXPECT_EQ(of_places.places[7].vertices[0], 7);
}

/// A thin layer whose smallest volume the energy makes smaller, and beside it four tetrahedra around a vertex.
TetMesh layer_and_star(const Point3& apex) {
  TetMesh mesh = test::cube(4, 0.2);
  for (Point3& p : mesh.points) p[2] *= 0.05;
  const Index first = Index(mesh.points.size());
  for (const Point3& p : {Point3{2, 0, 0}, {3, 0, 0}, {2, 1, 0}, {2, 0, 1}, apex}) mesh.points.push_back(p);
  for (const std::array<Index, 4>& t : {std::array{0, 1, 2, 4}, {0, 3, 1, 4}, {0, 2, 3, 4}, {1, 3, 2, 4}}) {
    mesh.tets.push_back({first + t[0], first + t[1], first + t[2], first + t[3]});
  }
  return test::with_tags(std::move(mesh));
}

/// A thin layer that the energy makes miss the limit, and beside it a cube with a flattened tetrahedron, which misses
/// it.
TEST(OptimizeTowards, WhereTheWholeGetsWorseOnlyWhatFailsIsOptimized) {
  TetMesh mesh = thin_layer();
  const double least = smallest_scaled_jacobian(mesh);
  const AcceptanceCriteria criteria = one(CheckMeasure::scaled_jacobian, 0.999 * least);
  const std::vector<Point3> layer = mesh.points;
  TetMesh block = test::cube(4);
  Point3& inner = block.points[2 + 5 * (2 + 5 * 2)];
  inner[2] += 0.999 * 0.25;  // it is near its neighbor
  ASSERT_TRUE(validate(block).ok());
  const Index first = Index(mesh.points.size());
  for (const Point3& p : block.points) mesh.points.push_back({p[0] + 2, p[1], p[2]});
  for (const auto& t : block.tets) mesh.tets.push_back({first + t[0], first + t[1], first + t[2], first + t[3]});
  mesh = test::with_tags(std::move(mesh));
  mesh.point_data.push_back({"field", 1, std::vector<double>(mesh.points.size(), 1.0)});
  const CriteriaReport report = optimize_towards(mesh, criteria);
  EXPECT_EQ(report.before.verdict, Verdict::fail);
  EXPECT_EQ(report.after.verdict, Verdict::pass);
  EXPECT_NE(report.undone, "");
  EXPECT_EQ(report.optimization.unchanged, "");
  EXPECT_EQ(report.optimization.moved_fields, std::vector<std::string>{"field"});
  ASSERT_EQ(report.optimization.warnings.size(), 2U);
  EXPECT_EQ(report.optimization.warnings[1], report.undone);
  EXPECT_EQ(check(mesh, criteria).verdict, Verdict::pass);
  EXPECT_TRUE(validate(mesh).ok());
  EXPECT_TRUE(std::equal(layer.begin(), layer.end(), mesh.points.begin()));
  ASSERT_FALSE(report.rounds.empty());
  EXPECT_TRUE(report.rounds.back().kept);
  EXPECT_EQ(report.optimization.tet2original.size(), mesh.tets.size());
}

TEST(OptimizeTowards, LossesAreVerdictsThenFailingThenWarningElements) {
  using enum Verdict;
  const auto result = [](Verdict verdict, std::int64_t failed, std::int64_t warned) {
    CriterionResult r{{CheckMeasure::edge_ratio, 1, 2}, verdict};
    r.failed = failed;
    r.warned = warned;
    return r;
  };
  const auto report = [](CriterionResult a, CriterionResult b) {
    return AcceptanceReport{"test", std::max(a.verdict, b.verdict), {a, b}};
  };
  const AcceptanceReport before = report(result(warn, 0, 5), result(fail, 3, 7));
  EXPECT_EQ(losses_in(before, before), "");
  EXPECT_EQ(losses_in(before, report(result(warn, 0, 6), result(fail, 2, 9))), "");
  EXPECT_EQ(losses_in(before, report(result(warn, 1, 0), result(fail, 2, 0))), "edge_ratio: 0 -> 1 fail");
  EXPECT_EQ(losses_in(before, report(result(fail, 9, 0), result(fail, 4, 0))),
            "edge_ratio: warn -> fail, 0 -> 9 fail; edge_ratio: 3 -> 4 fail");
  EXPECT_EQ(losses_in(before, report(result(warn, 0, 4), result(fail, 3, 9))), "12 -> 13 warn");
  EXPECT_EQ(losses_in(before, report(result(warn, 1, 99), result(warn, 0, 0))), "");
  EXPECT_EQ(losses_in(report(result(pass, 0, 0), result(warn, 0, 7)), report(result(warn, 0, 2), result(warn, 0, 0))),
            "edge_ratio: pass -> warn, 0 -> 2 warn");
}

TEST(OptimizeTowards, AValueThatIsNotANumberIsTheWorst) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const CheckMeasure measure : {CheckMeasure::edge_ratio, CheckMeasure::gamma}) {
    const auto report = [measure](double worst) {
      CriterionResult r{{measure, 1, 2}, Verdict::fail};
      r.worst = worst;
      return AcceptanceReport{"test", Verdict::fail, {r}};
    };
    const auto worse = [&](double before, double after) {
      return has_worse_value(report(before), report(after), Verdict::fail);
    };
    EXPECT_FALSE(worse(nan, 3));
    EXPECT_FALSE(worse(nan, nan));
    EXPECT_TRUE(worse(3, nan));
    EXPECT_FALSE(worse(3, 3));
    EXPECT_EQ(worse(3, 4), measure == CheckMeasure::edge_ratio);
    EXPECT_EQ(worse(3, 2), measure == CheckMeasure::gamma);
  }
}

/// The smallest volume of a layer, which a single tetrahedron may miss.
AcceptanceCriteria smallest_volume(const TetMesh& layer) {
  AcceptanceCriteria criteria = one(CheckMeasure::volume, 1e-12);
  AcceptanceCriterion& volume = criteria.criteria[0];
  volume.fail = (1 - 1e-9) * check(layer, criteria).results[0].worst;
  volume.allowed_percent = 100 * 1.5 / double(layer.tets.size());
  return criteria;
}

TEST(OptimizeTowards, AnInvertedInputIsNotPutBack) {
  const AcceptanceCriteria criteria = smallest_volume(layer_and_star({2.3, 0.3, 0.3}));
  Options options;
  options.untangle = true;
  TetMesh valid = layer_and_star({2.3, 0.3, 0.3});
  EXPECT_NE(optimize_towards(valid, criteria, options).optimization.unchanged, "");
  TetMesh mesh = layer_and_star({2.3, 0.3, -0.05});
  ASSERT_FALSE(validate(mesh).ok());
  const CriteriaReport report = optimize_towards(mesh, criteria, options);
  EXPECT_EQ(report.before.verdict, Verdict::warn);
  EXPECT_EQ(report.after.verdict, Verdict::fail);
  EXPECT_EQ(report.optimization.unchanged, "");
  EXPECT_TRUE(validate(mesh).ok());
}

TEST(OptimizeTowards, AnInputWithInvertedCurvedElementsIsNotPutBack) {
  TetMesh mesh = layer_and_star({2.3, 0.3, 0.3});
  const AcceptanceCriteria criteria = smallest_volume(mesh);
  const Index apex = Index(mesh.points.size()) - 1;
  mesh.second_order = true;
  mesh.curved_edges = {{{apex - 1, apex}, {2.5, 0.15, 0.65}}};
  ASSERT_GT(measure_curved(mesh).inverted, 0);
  Options options;
  options.untangle = true;
  const CriteriaReport report = optimize_towards(mesh, criteria, options);
  EXPECT_EQ(report.before.verdict, Verdict::pass);
  EXPECT_EQ(report.after.verdict, Verdict::fail);
  EXPECT_EQ(report.optimization.unchanged, "");
  EXPECT_TRUE(measure_curved(mesh).all_valid());
}

TEST(OptimizeTowards, SameBitsForAnyNumberOfThreads) {
  Options options;
  options.effort = Effort::best;
  std::vector<TetMesh> meshes(2, lattice_input());
  for (std::size_t i = 0; i < 2; ++i) {
    options.threads = i == 0 ? 1 : 3;
    const CriteriaReport report = optimize_towards(meshes[i], one(CheckMeasure::edge_ratio, 1.85), options);
    EXPECT_FALSE(report.rounds.empty());
    ASSERT_EQ(report.optimization.tet2original.size(), meshes[i].tets.size());
    const std::vector<Index>& origins = report.optimization.vertex2original;
    EXPECT_TRUE(origins.empty() || origins.size() == meshes[i].points.size());
  }
  EXPECT_EQ(meshes[0].points, meshes[1].points);
  EXPECT_EQ(meshes[0].tets, meshes[1].tets);
}

TEST(OptimizeTowards, NoRoundIsRepeated) {
  TetMesh mesh = lattice_input();
  // All tetrahedra fail, and none will pass.
  const CriteriaReport report = optimize_towards(mesh, one(CheckMeasure::edge_ratio, 1.0));
  ASSERT_FALSE(report.rounds.empty());
  EXPECT_EQ(report.rounds.back().active, std::ssize(mesh.tets));
  EXPECT_FALSE(report.rounds.back().kept);
  EXPECT_EQ(report.rounds.size(), 1U);
}

TEST(OptimizeTowards, NamesWhatHoldsElements) {
  TetMesh mesh = test::one_tet();
  const CriteriaReport report = optimize_towards(mesh, one(CheckMeasure::edge_ratio, 1.2));
  ASSERT_EQ(report.limits.size(), 1U);
  const CriterionLimits& limits = report.limits[0];
  EXPECT_EQ(limits.held_by[static_cast<std::size_t>(LimitingConstraint::fixed_vertices)], 1);
  ASSERT_EQ(limits.worst.size(), 1U);
  EXPECT_EQ(limits.worst[0].tet, 0);
  EXPECT_GT(limits.worst[0].value, 1.2);
  EXPECT_EQ(mesh.points, test::one_tet().points);
  // Its angles of 54.7 degrees are those of the surface.
  const CriteriaReport angles = optimize_towards(mesh, one(CheckMeasure::equiangle_skew, 0.2));
  ASSERT_EQ(angles.limits.size(), 1U);
  ASSERT_EQ(angles.limits[0].worst.size(), 1U);
  EXPECT_EQ(angles.limits[0].worst[0].held_by, LimitingConstraint::surface_angle);
  EXPECT_NEAR(angles.limits[0].worst[0].surface_angle, 54.7356, 1e-3);
}

TEST(OptimizeTowards, VerticesThatSlideDoNotHoldElementsAndRoundsKeepTheSurface) {
  const TetMesh before = test::ball(5, 0.15, 2);
  Options options;
  options.boundary = Boundary::slide;
  options.feature_angle = 180;
  TetMesh plain = before;
  optimize(plain, options);
  TetMesh mesh = before;
  const CriteriaReport report = optimize_towards(mesh, one(CheckMeasure::edge_ratio, 2), options);
  ASSERT_TRUE(std::any_of(report.rounds.begin(), report.rounds.end(), [](const CriteriaRound& r) { return r.kept; }));
  for (const auto& face : test::skin(plain)) {
    for (const Index v : face.v) EXPECT_EQ(mesh.points[std::size_t(v)], plain.points[std::size_t(v)]);
  }
  ASSERT_EQ(report.optimization.fixed_vertices, 0);
  ASSERT_EQ(report.limits.size(), 1U);
  const auto held_by = [&](LimitingConstraint c) { return report.limits[0].held_by[std::size_t(c)]; };
  EXPECT_GT(held_by(LimitingConstraint::boundary), 0);
  EXPECT_EQ(held_by(LimitingConstraint::fixed_vertices), 0);
  EXPECT_EQ(held_by(LimitingConstraint::feature_corner), 0);
}

TEST(OptimizeTowards, MakesNoRoundsWhereOptionsExcludeThem) {
  for (const int k : {0, 1, 2}) {
    Options options;
    if (k == 0) options.only_below = {{Measure::min_dihedral, 20}};
    if (k == 1) options.data = DataTransfer::interpolate;
    if (k == 2) options.termination = Termination::paper;
    TetMesh mesh = lattice_input();
    const CriteriaReport report = optimize_towards(mesh, one(CheckMeasure::edge_ratio, 1.01), options);
    EXPECT_FALSE(report.no_rounds.empty());
    EXPECT_TRUE(report.rounds.empty());
    EXPECT_EQ(report.limits.empty(), k == 0);
    TetMesh plain = lattice_input();
    optimize(plain, options);
    EXPECT_EQ(mesh.points, plain.points);
  }
}

TEST(OptimizeTowards, ARequestedStopEndsTheRounds) {
  Context context;
  context.stop = [] { return true; };
  TetMesh mesh = lattice_input();
  const CriteriaReport report = optimize_towards(mesh, one(CheckMeasure::edge_ratio, 1.01), {}, context);
  EXPECT_EQ(report.optimization.stop, StopReason::cancelled);
  EXPECT_TRUE(report.rounds.empty());
  EXPECT_TRUE(validate(mesh).ok());
}

}  // namespace
}  // namespace tetune

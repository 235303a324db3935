// SPDX-License-Identifier: Apache-2.0
// Options::only_below: the rest of the mesh stays bit for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <ostream>
#include <utility>

#include "backend/span.hpp"
#include "driver/parts/optimize_active.hpp"
#include "mesh/id_maps.hpp"
#include "only_below_fixture.hpp"
#include "support/constrained.hpp"
#include "support/meshes.hpp"
#include "tetune/error.hpp"
#include "tetune/move.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

using namespace test;

struct ThresholdCase {
  Boundary boundary;
  Effort effort;
  std::uint32_t seed;
  friend void PrintTo(const ThresholdCase& c, std::ostream* out) {
    *out << "boundary " << static_cast<int>(c.boundary) << " effort " << static_cast<int>(c.effort) << " seed "
         << c.seed;
  }
};

class OnlyBelow : public testing::TestWithParam<ThresholdCase> {};

TEST_P(OnlyBelow, KeepsTheRestAndDoesNotGetWorse) {
  const ThresholdCase c = GetParam();
  TetMesh before = test::varied(c.seed);
  number_data(before);
  Options options;
  options.boundary = c.boundary;
  options.effort = c.effort;
  options.only_below = {{Measure::mean_ratio, limit_missed_by(before, 0.02)}};
  options.rings = static_cast<int>(c.seed % 3);
  const std::vector<bool> active = active_by_definition(before, options);
  TetMesh after = before;
  options.threads = 1;
  const Report report = optimize(after, options);

  EXPECT_EQ(report.tets_active, std::count(active.begin(), active.end(), true));
  EXPECT_EQ(report.tets_before, static_cast<std::int64_t>(before.tets.size()));
  EXPECT_EQ(report.tets_after, static_cast<std::int64_t>(after.tets.size()));
  const ValidationReport valid = validate(after);
  EXPECT_TRUE(valid.ok()) << valid.message(false);
  EXPECT_GE(quality(after).dihedral_min, quality(before).dihedral_min - 1e-9);
  const double kept_part = options.effort == Effort::best ? 0.25 : 1;
  EXPECT_GE(quality(after).mean_ratio_min, kept_part * quality(before).mean_ratio_min - 1e-9);
  expect_rest_unchanged(before, after, active, report);
  EXPECT_EQ(test::tets_with(before, before.required_tets), test::tets_with(after, after.required_tets));
  if (c.boundary != Boundary::slide) {
    const Comparison change = compare(before, after);
    EXPECT_LT(std::abs(change.area_change), 1e-12);
    EXPECT_LT(change.region_volume_change, 1e-12);
    EXPECT_LT(change.patch_area_change, 1e-12);
  }
  // Otherwise vertices are inserted on the surface too.
  if (c.effort != Effort::best) {
    EXPECT_EQ(test::tagged(before.triangles, before.triangle_tags), test::tagged(after.triangles, after.triangle_tags));
  }
  EXPECT_EQ(test::tagged(before.edges, before.edge_tags), test::tagged(after.edges, after.edge_tags));
  test::expect_present(after);

  TetMesh again = before;
  options.threads = 3;
  optimize(again, options);
  EXPECT_EQ(again.points, after.points);
  EXPECT_EQ(again.tets, after.tets);
}

std::vector<ThresholdCase> threshold_cases() {
  std::vector<ThresholdCase> all;
  std::uint32_t seed = 1;
  for (const Boundary boundary : {Boundary::fixed, Boundary::preserve, Boundary::slide}) {
    for (const Effort effort : {Effort::fast, Effort::standard, Effort::best}) {
      for (int i = 0; i < 3; ++i) all.push_back({boundary, effort, seed++});
    }
  }
  return all;
}
INSTANTIATE_TEST_SUITE_P(Cases, OnlyBelow, testing::ValuesIn(threshold_cases()));

TetMesh with_bad_corner() {
  TetMesh mesh = test::cube(8);
  for (Point3& p : mesh.points) {
    // A vertex inside, near one corner of the cube.
    if (std::abs(p[0] - 0.25) + std::abs(p[1] - 0.25) + std::abs(p[2] - 0.25) < 1e-9) p[0] += 0.11;
  }
  number_data(mesh);
  return mesh;
}

TEST(OnlyBelowLimit, ImprovesWhatIsBad) {
  TetMesh mesh = with_bad_corner();
  const TetMesh before = mesh;
  Options options;
  options.only_below = {{Measure::min_dihedral, 20}};
  const Report report = optimize(mesh, options);
  EXPECT_GT(report.tets_bad, 0);
  EXPECT_LT(report.tets_active, 600);
  EXPECT_LT(quality(before).dihedral_min, 10);
  EXPECT_GT(quality(mesh).dihedral_min, 25);
  expect_rest_unchanged(before, mesh, active_by_definition(before, options), report);
}

/// In a thin layer the energy makes other measures worse.
TEST(OnlyBelowLimit, NoMoreTetrahedraMissItAfterwards) {
  int unchanged = 0;
  for (const Measure measure : {Measure::scaled_jacobian, Measure::radius_ratio, Measure::gamma}) {
    TetMesh mesh = test::cube(6, 0.2);
    for (Point3& p : mesh.points) p[2] *= 0.02;
    const TetMesh before = mesh;
    const Target limit{measure, limit_missed_by(mesh, 0.004, measure)};
    ASSERT_GT(count_missing(mesh, limit), 0);
    Options options;
    options.only_below = {limit};
    options.device = Device::automatic;
    const Report report = optimize(mesh, options);
    EXPECT_LE(count_missing(mesh, limit), count_missing(before, limit));
    EXPECT_EQ(report.tets_bad, count_missing(before, limit));
    if (report.unchanged.empty()) continue;
    ++unchanged;
    EXPECT_EQ(mesh.points, before.points);
    EXPECT_EQ(mesh.tets, before.tets);
    // The report is that of the run that was made.
    EXPECT_GE(report.tets_active, report.tets_bad);
    EXPECT_FALSE(report.device_reason.empty());
    EXPECT_FALSE(report.phases.empty());
    EXPECT_GT(report.colors, 0);
    EXPECT_GT(report.free_vertices, 0);
    EXPECT_EQ(report.free_vertices + report.plane_vertices + report.line_vertices + report.fixed_vertices,
              std::ssize(mesh.points));
    EXPECT_EQ(report.flips() + report.vertices_inserted + report.vertices_removed, 0);
    EXPECT_TRUE(report.sweeps.empty());
    EXPECT_EQ(report.energy_after, report.energy_before);
    EXPECT_EQ(report.tet2original, identity_map(mesh.tets.size()));
    EXPECT_EQ(report.warnings, std::vector{report.unchanged});
  }
  EXPECT_GT(unchanged, 0);
}

TEST(OnlyBelowLimit, ARequestedStopIsReportedAlsoWhereTheMeshIsAsBefore) {
  int unchanged = 0;
  for (int calls = 1; calls < 12; ++calls) {
    TetMesh mesh = test::cube(6, 0.2);
    for (Point3& p : mesh.points) p[2] *= 0.02;
    number_data(mesh);
    Options options;
    options.only_below = {{Measure::scaled_jacobian, limit_missed_by(mesh, 0.005, Measure::scaled_jacobian)}};
    options.data = DataTransfer::interpolate;
    options.targets = options.only_below;
    int called = 0;
    const Report report = optimize(mesh, options, {[&](const Progress&) { return ++called < calls; }, {}});
    const bool is_stopped = called == calls;
    EXPECT_EQ(report.stop == StopReason::cancelled, is_stopped);
    if (report.unchanged.empty() || !is_stopped) continue;
    ++unchanged;
    EXPECT_EQ(report.targets[0].missed, report.tets_bad);
    ASSERT_EQ(report.places.size(), mesh.points.size());
    EXPECT_EQ(report.places[9].vertices[0], 9);
  }
  EXPECT_GT(unchanged, 0);
}

TEST(OnlyBelowLimit, NothingIsDoneWhereNothingIsBad) {
  TetMesh mesh = test::cube(3);
  number_data(mesh);
  const TetMesh before = mesh;
  Options options;
  options.only_below = {{Measure::min_dihedral, 20}};
  options.targets = {{Measure::min_dihedral, 60}};
  options.data = DataTransfer::interpolate;
  const Report report = optimize(mesh, options);
  EXPECT_EQ(report.tets_active, 0);
  EXPECT_EQ(mesh.points, before.points);
  EXPECT_EQ(mesh.tets, before.tets);
  EXPECT_EQ(report.stop, StopReason::converged);
  EXPECT_EQ(report.fixed_vertices, static_cast<std::int64_t>(mesh.points.size()));
  ASSERT_EQ(report.targets.size(), 1U);
  EXPECT_EQ(report.targets[0].missed, report.tets_before);
  EXPECT_EQ(report.targets[0].held_by[static_cast<std::size_t>(LimitingConstraint::locked_element)],
            report.tets_before);
}

TEST(OnlyBelowLimit, TargetsAreReportedForTheWholeMesh) {
  TetMesh mesh = with_bad_corner();
  Options options;
  options.only_below = {{Measure::min_dihedral, 20}};
  options.targets = {{Measure::mean_ratio, 0.8}};
  const Report report = optimize(mesh, options);
  std::map<Index, double> missed;
  const std::vector<Measures> measures = measure_each(mesh);
  for (Index t = 0; t < static_cast<Index>(measures.size()); ++t) {
    const double value = measures[to_size_t(t)][static_cast<std::size_t>(Measure::mean_ratio)];
    if (value < 0.8) missed[t] = value;
  }
  ASSERT_EQ(report.targets.size(), 1U);
  EXPECT_EQ(report.targets[0].tets, static_cast<std::int64_t>(mesh.tets.size()));
  EXPECT_EQ(report.targets[0].missed, static_cast<std::int64_t>(missed.size()));
  for (const MissedTet& m : report.targets[0].worst) EXPECT_NEAR(missed.at(m.tet), m.value, 1e-12);
}

TEST(OnlyBelowLimit, InvertedTetrahedraAreBad) {
  TetMesh mesh = test::cube(6);
  for (Point3& p : mesh.points) {
    if (std::abs(p[0] - 0.5) + std::abs(p[1] - 0.5) + std::abs(p[2] - 0.5) < 1e-9) p[0] += 0.25;
  }
  Options options;
  options.only_below = {{Measure::min_dihedral, 5}};
  TetMesh refused = mesh;
  EXPECT_THROW(optimize(refused, options), MeshError);
  EXPECT_EQ(refused.points, mesh.points);
  options.untangle = true;
  const Report report = optimize(mesh, options);
  EXPECT_GT(report.tets_untangled, 0);
  EXPECT_LT(report.tets_active, report.tets_before);
  EXPECT_TRUE(validate(mesh).ok());
}

/// More tetrahedra miss the limit of the repaired mesh, but the input is inverted.
TEST(OnlyBelowLimit, ARepairedMeshIsKeptAlthoughMoreTetrahedraMissTheLimit) {
  int more = 0;
  for (const double limit : {40.0, 43.0, 44.9}) {
    TetMesh mesh = test::cube(6);
    for (Point3& p : mesh.points) {
      if (std::abs(p[0] - 0.5) + std::abs(p[1] - 0.5) + std::abs(p[2] - 0.5) < 1e-9) p[0] += 0.25;
    }
    Options options;
    options.only_below = {{Measure::min_dihedral, limit}};
    options.untangle = true;
    const std::int64_t before = count_missing(mesh, options.only_below[0]);
    const Report report = optimize(mesh, options);
    EXPECT_TRUE(validate(mesh).ok());
    EXPECT_EQ(report.unchanged, "");
    EXPECT_GT(report.tets_untangled, 0);
    if (count_missing(mesh, options.only_below[0]) > before) ++more;
  }
  EXPECT_GT(more, 0);
}

TEST(OnlyBelowLimit, TetrahedraThatCannotBeRepairedAreNamedByTheirNumbers) {
  TetMesh mesh = test::cube(6);
  const Index last = static_cast<Index>(mesh.tets.size()) - 1;
  // The last tetrahedron is made flat, and all its vertices are held.
  const auto tet = mesh.tets[to_size_t(last)];
  for (std::size_t k = 0; k < 3; ++k) {
    mesh.points[to_size_t(tet[3])][k] =
        (mesh.points[to_size_t(tet[0])][k] + mesh.points[to_size_t(tet[1])][k] + mesh.points[to_size_t(tet[2])][k]) / 3;
  }
  mesh.required_tets = {last};
  Options options;
  options.only_below = {{Measure::min_dihedral, 1}};
  options.untangle = true;
  try {
    optimize(mesh, options);
    FAIL() << "a flat tetrahedron cannot be repaired where it must not change";
  } catch (const UntangleError& e) {
    EXPECT_TRUE(std::find(e.left.begin(), e.left.end(), last) != e.left.end());
  }
}

TEST(OnlyBelowLimit, ErrorsNameWhatIsNotValidInTheWholeMeshOrStay) {
  const TetMesh valid = test::cube(3);
  TetMesh inverted = valid;
  std::swap(inverted.tets[7][0], inverted.tets[7][1]);
  TetMesh part = test::one_tet();
  std::swap(part.tets[0][0], part.tets[0][1]);
  const MeshError of_part(validate(part).message(false));
  EXPECT_EQ(error_of_whole(of_part, part, inverted, 1).what(), validate(inverted).message(false));
  EXPECT_STREQ(error_of_whole(of_part, part, valid, 1).what(), of_part.what());
  const MeshError other("flips would need room for too many tetrahedra");
  EXPECT_STREQ(error_of_whole(other, part, inverted, 1).what(), other.what());
  EXPECT_STREQ(error_of_whole(other, part, valid, 1).what(), other.what());
}

TEST(OnlyBelowLimit, WrongOptionsAreRefused) {
  TetMesh mesh = test::cube(2);
  Options options;
  options.only_below = {{Measure::min_dihedral, 80}};
  EXPECT_THROW(optimize(mesh, options), OptionError);
  options.only_below = {{Measure::min_dihedral, 10}};
  options.rings = -1;
  EXPECT_THROW(optimize(mesh, options), OptionError);
  options.rings = 2;
  options.frozen_regions = {77};
  EXPECT_THROW(optimize(mesh, options), OptionError);
  options.frozen_regions.clear();
  EXPECT_THROW(move(mesh, mesh.points, options), OptionError);
}

}  // namespace
}  // namespace tetune

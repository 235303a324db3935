// SPDX-License-Identifier: Apache-2.0
// Options::only_below where vertices are inserted and removed: numbers stay, also where the run is stopped.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "only_below_fixture.hpp"
#include "support/meshes.hpp"
#include "tetune/move.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

using namespace test;

/// Replaces a tetrahedron by four around a new vertex in its middle.
void split(TetMesh& mesh, std::size_t t) {
  const auto tet = mesh.tets[t];
  const Point3 center = test::centroid(mesh, t);
  const auto added = static_cast<Index>(mesh.points.size());
  mesh.points.push_back(center);
  mesh.point_tags.push_back(7);
  for (std::size_t k = 0; k < 4; ++k) {
    auto part = tet;
    part[k] = added;
    if (k == 0) {
      mesh.tets[t] = part;
    } else {
      mesh.tets.push_back(part);
      mesh.tet_tags.push_back(mesh.tet_tags[t]);
    }
  }
}

TEST(OnlyBelowLimit, VerticesDoNotBecomeFewer) {
  Options options;
  options.effort = Effort::best;
  // Effort::best removes the vertex in the middle.
  TetMesh alone = test::one_tet();
  split(alone, 0);
  options.frozen_vertices = {1, 1, 1, 1, 0};
  optimize(alone, options);
  ASSERT_EQ(alone.points.size(), 4U);
  // In a larger mesh it stays, as others would be renumbered.
  options.frozen_vertices.clear();
  options.rings = 0;
  options.only_below = {{Measure::min_dihedral, 35}};
  TetMesh mesh = test::cube(5);
  split(mesh, mesh.tets.size() / 2);
  number_data(mesh);
  const TetMesh before = mesh;
  const std::vector<bool> active = active_by_definition(mesh, options);
  ASSERT_EQ(std::count(active.begin(), active.end(), true), 4);
  const Report report = optimize(mesh, options);
  EXPECT_EQ(mesh.points.size(), before.points.size());
  EXPECT_EQ(report.vertices_removed, 0);
  EXPECT_EQ(mesh.point_tags, before.point_tags);
  expect_rest_unchanged(before, mesh, active, report);
}

/// Vertices that Effort::best removes: in the middle of a part of the tetrahedra.
TetMesh with_vertices_to_remove() {
  TetMesh mesh = test::cube(4, 0.15, 3);
  const std::size_t size = mesh.tets.size();
  for (std::size_t t = 0; t < size; t += 3) split(mesh, t);
  number_data(mesh);
  return mesh;
}

class StoppedOnlyBelow : public testing::TestWithParam<Boundary> {};

/// Where more vertices were removed than inserted until the stop, the part is optimized once more without either.
TEST_P(StoppedOnlyBelow, ResultIsValidAndNoWorkIsLost) {
  const TetMesh before = with_vertices_to_remove();
  Options options;
  options.effort = Effort::best;
  options.boundary = GetParam();
  options.rings = 1;
  options.restarts = 1;
  options.only_below = {{Measure::min_dihedral, 20}};
  const std::vector<bool> active = active_by_definition(before, options);
  double converged = 0;  // mean of the mean ratios after flips and sweeps alone
  bool is_stopped = true;
  for (int calls = 2; is_stopped; calls += 1 + calls / 2) {
    TetMesh mesh = before;
    int called = 0, after_stop = 0, alternating = 0;
    const Context context{[&](const Progress& p) {
                            if (called == calls) ++after_stop;
                            const std::string phase = p.phase;
                            const bool alternates = phase == "load" || phase == "flips" || phase == "sweep";
                            if (called == alternating && alternates) ++alternating;
                            return ++called < calls;
                          },
                          {}};
    const Report report = optimize(mesh, options, context);
    is_stopped = called == calls;
    EXPECT_EQ(after_stop, 0);
    EXPECT_EQ(report.stop == StopReason::cancelled, is_stopped);
    EXPECT_TRUE(validate(mesh).ok());
    EXPECT_EQ(mesh.points.size(), before.points.size());
    EXPECT_EQ(report.tets_after, std::ssize(mesh.tets));
    EXPECT_EQ(report.vertices, std::ssize(before.points));
    EXPECT_EQ(report.free_vertices + report.plane_vertices + report.line_vertices + report.surface_vertices +
                  report.curve_vertices + report.fixed_vertices,
              report.vertices);
    EXPECT_TRUE(report.vertex2original.empty());
    expect_rest_unchanged(before, mesh, active, report);
    const double mean = quality(mesh).mean_ratio;
    if (alternating == called) converged = std::max(converged, mean);
    EXPECT_GT(mean, quality(before).mean_ratio);
    EXPECT_GE(mean, 0.95 * converged);
  }
  EXPECT_GT(converged, 0.7);
}
INSTANTIATE_TEST_SUITE_P(Boundaries, StoppedOnlyBelow, testing::Values(Boundary::preserve, Boundary::slide));

TEST(OnlyBelowLimit, AStopAfterUntanglingLeavesARepairedMesh) {
  TetMesh mesh = with_vertices_to_remove();
  for (Point3& p : mesh.points) {
    if (std::abs(p[0] - 0.5) + std::abs(p[1] - 0.5) + std::abs(p[2] - 0.5) < 0.2) p[0] += 0.3;
  }
  Options options;
  options.effort = Effort::best;
  options.untangle = true;
  options.only_below = {{Measure::min_dihedral, 20}};
  const auto proceeds = [](const Progress& p) { return std::string(p.phase) != "worst"; };
  const Report report = optimize(mesh, options, {proceeds, {}});
  EXPECT_EQ(report.stop, StopReason::cancelled);
  EXPECT_GT(report.tets_untangled, 0);
  EXPECT_EQ(report.vertices_removed, 0);
  EXPECT_TRUE(validate(mesh).ok());
}

}  // namespace
}  // namespace tetune

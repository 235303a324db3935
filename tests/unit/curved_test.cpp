// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "curved/curved_edges.hpp"
#include "curved/held_bound.hpp"
#include "driver/report/extend_report.hpp"
#include "support/curved.hpp"
#include "support/meshes.hpp"
#include "tetune/curve.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

TEST(Curved, QualityCountsTheElementsOfCurvedEdges) {
  TetMesh m = test::cube(2);
  EXPECT_EQ(quality(m).curved.tets, 0);
  EXPECT_TRUE(measure_curved_each(m).empty());
  m.second_order = true;
  const auto edge = ascending(m.tets[0][0], m.tets[0][1]);
  const Point3& p = m.points[static_cast<std::size_t>(edge[0])];
  const Point3& q = m.points[static_cast<std::size_t>(edge[1])];
  m.curved_edges = {{edge, {0.5 * (p[0] + q[0]) + 0.02, 0.5 * (p[1] + q[1]), 0.5 * (p[2] + q[2])}}};
  const std::vector<CurvedTet> each = measure_curved_each(m);
  const Quality q1 = measure_all(m, 1, 3);
  const Quality q4 = measure_all(m, 4, 3);
  ASSERT_EQ(q1.curved.tets, std::ssize(each));
  EXPECT_EQ(q1.curved.valid, q1.curved.tets);
  EXPECT_LT(q1.curved.min_scaled_jacobian, 1);
  EXPECT_EQ(q1.curved.min_scaled_jacobian, q4.curved.min_scaled_jacobian);
  ASSERT_LE(q1.curved.worst.size(), 3U);
  EXPECT_EQ(q1.curved.worst[0].scaled_jacobian(), q1.curved.min_scaled_jacobian);
  m.curved_edges[0].middle[0] += 10;
  EXPECT_GT(measure_curved(m).inverted, 0);
  m.curved_edges.push_back(m.curved_edges[0]);
  EXPECT_THROW(static_cast<void>(measure_curved(m)), MeshError);
}

TEST(Curved, OptimizationKeepsTheSurfaceAndValidity) {
  for (const Boundary boundary : {Boundary::fixed, Boundary::preserve}) {
    for (const Effort effort : {Effort::standard, Effort::best}) {
      TetMesh m = test::bulged_cube(0.05);
      const TetMesh before = m;
      const Quality q = quality(before);
      ASSERT_TRUE(q.curved.all_valid());
      Options options;
      options.boundary = boundary;
      options.effort = effort;
      options.threads = 1;
      const Report report = optimize(m, options);
      const Quality after = quality(m);
      EXPECT_TRUE(validate(m).ok()) << validate(m).message(false);
      EXPECT_TRUE(after.curved.all_valid());
      EXPECT_GE(after.curved.min_scaled_jacobian, q.curved.min_scaled_jacobian - 3e-3);
      EXPECT_GE(after.dihedral_min, q.dihedral_min);
      // The mean, as vertices may be inserted.
      EXPECT_LT(after.shape_sum / double(m.tets.size()), q.shape_sum / double(before.tets.size()));
      EXPECT_EQ(test::upper_middles(m), test::upper_middles(before));
      EXPECT_EQ(m.triangles, before.triangles);
      EXPECT_EQ(report.tets_after, std::ssize(m.tets));
      TetMesh again = before;
      options.threads = 3;
      optimize(again, options);
      EXPECT_EQ(again.points, m.points);
      EXPECT_EQ(again.tets, m.tets);
      EXPECT_EQ(again.curved_edges, m.curved_edges);
    }
  }
}

std::int64_t vertices_by_freedom(const Report& r) {
  return r.free_vertices + r.plane_vertices + r.line_vertices + r.fixed_vertices + r.surface_vertices +
         r.curve_vertices;
}

TEST(Curved, TheReportIsOfTheInputAndTheResult) {
  TetMesh jittered = test::ball(3, 0.15);
  curve(jittered);
  for (const TetMesh& before : {test::curved_ball(), jittered}) {
    for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
      Options options;
      options.untangle = true;
      options.max_growth = 3;
      options.boundary = boundary;
      // Leaves flat tetrahedra at the surface, which must be split.
      options.effort = Effort::fast;
      TetMesh m = before;
      const Report report = optimize(m, options);
      EXPECT_GT(report.vertices_inserted, 0);
      EXPECT_EQ(report.vertices, std::ssize(before.points));
      EXPECT_EQ(vertices_by_freedom(report), std::ssize(before.points));
      const bool slides = boundary == Boundary::slide;
      EXPECT_EQ(report.surface_vertices > 0, slides);
      EXPECT_EQ(report.energy_before, quality(before).shape_sum);
      EXPECT_EQ(report.energy_after, quality(m).shape_sum);
      EXPECT_NEAR(seconds_of_phases(report), report.seconds, 1e-9 * report.seconds);
    }
  }
}

TEST(Curved, EdgesThatAreStraightToTheRoundingOfTheirCoordinatesHoldNoVertex) {
  // Coordinates of 15 digits, as in files.
  const auto rounded = [](double x) { return std::round(x * 1e8) / 1e8; };
  TetMesh m = test::cube(3, 0.15);
  for (Point3& p : m.points) p = {rounded(1e6 + p[0]), rounded(1e6 + p[1]), rounded(1e6 + p[2])};
  TetMesh straight = m;
  std::set<std::array<Index, 2>> edges;
  for (const auto& face : test::skin(m)) {
    for (std::size_t k = 0; k < 3; ++k) edges.insert(ascending(face.v[k], face.v[(k + 1) % 3]));
  }
  m.second_order = true;
  for (const auto& edge : edges) {
    const Vec3 middle = 0.5 * (test::at(m, edge[0]) + test::at(m, edge[1]));
    const Point3 in_file{rounded(middle.x), rounded(middle.y), rounded(middle.z)};
    if (vec(in_file).x != middle.x || vec(in_file).y != middle.y || vec(in_file).z != middle.z) {
      m.curved_edges.push_back({edge, in_file});
    }
  }
  ASSERT_GT(m.curved_edges.size(), 50U);
  const Report expected = optimize(straight);
  const Report report = optimize(m);
  EXPECT_GT(report.plane_vertices, 0);
  EXPECT_EQ(report.plane_vertices, expected.plane_vertices);
  EXPECT_EQ(report.fixed_vertices, expected.fixed_vertices);
}

TEST(Curved, HeldNodesKeepTheRoundingOfTheirCoordinates) {
  // All mid-side nodes are beside the midpoint by less than a part of 1e-14 of the edge.
  TetMesh m = test::two_materials(4, 0.2);
  std::set<std::array<Index, 2>> edges, held;
  for (std::size_t t = 0; t < m.tets.size(); ++t) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) {
        const auto edge = ascending(m.tets[t][i], m.tets[t][j]);
        edges.insert(edge);
        if (m.tet_tags[t] == 2) held.insert(edge);
      }
    }
  }
  m.second_order = true;
  for (const auto& edge : edges) {
    const Vec3 middle = 0.5 * (test::at(m, edge[0]) + test::at(m, edge[1]));
    m.curved_edges.push_back({edge, {middle.x + 1e-15, middle.y - 1e-15, middle.z + 1e-15}});
  }
  Options options;
  options.frozen_regions = {2};
  for (const Boundary boundary : {Boundary::preserve, Boundary::fixed, Boundary::slide}) {
    options.boundary = boundary;
    TetMesh result = m;
    const Report report = optimize(result, options);
    ASSERT_TRUE(report.vertex2original.empty());
    for (const CurvedEdge& before : m.curved_edges) {
      if (!held.contains(before.vertices)) continue;
      const CurvedEdge* const after = find_edge(result.curved_edges, before.vertices);
      ASSERT_NE(after, nullptr);
      ASSERT_EQ(after->middle, before.middle);
    }
  }
}

TEST(Curved, WithoutSweepsAndFlipsNothingMoves) {
  TetMesh m = test::cube(3, 0.2);
  m.second_order = true;
  for (const auto& tet : m.tets) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) {
        const auto edge = ascending(tet[i], tet[j]);
        const Vec3 middle = 0.5 * (test::at(m, edge[0]) + test::at(m, edge[1]));
        const double offset = 0.002 * double(1 + (edge[0] + edge[1]) % 3);
        m.curved_edges.push_back({edge, {middle.x + offset, middle.y, middle.z - offset}});
      }
    }
  }
  std::sort(m.curved_edges.begin(), m.curved_edges.end(), is_before);
  const auto is_same = [](const CurvedEdge& e, const CurvedEdge& f) { return e.vertices == f.vertices; };
  m.curved_edges.erase(std::unique(m.curved_edges.begin(), m.curved_edges.end(), is_same), m.curved_edges.end());
  Options options;
  options.max_iterations = 0;
  options.flips = false;
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    options.boundary = boundary;
    TetMesh result = m;
    const Report report = optimize(result, options);
    EXPECT_EQ(result.points, m.points);
    EXPECT_TRUE(result.curved_edges == m.curved_edges);
    EXPECT_GT(report.free_vertices, 0);
  }
}

TEST(Curved, VerticesThatSlideDoNotHoldElements) {
  TetMesh m = test::ball(3, 0.15);
  curve(m);
  Options options;
  options.boundary = Boundary::slide;
  options.targets = {{Measure::scaled_jacobian, 0.7}};
  const Report report = optimize(m, options);
  ASSERT_GT(report.surface_vertices, 0);
  ASSERT_EQ(report.fixed_vertices, 0);
  const auto held_by = [&](LimitingConstraint c) { return report.targets.at(0).held_by[std::size_t(c)]; };
  EXPECT_GT(held_by(LimitingConstraint::boundary), 0);
  EXPECT_EQ(held_by(LimitingConstraint::fixed_vertices), 0);
  EXPECT_EQ(held_by(LimitingConstraint::feature_corner), 0);
  EXPECT_EQ(held_by(LimitingConstraint::feature_line), 0);
}

TEST(Curved, TargetsAreThoseOfTheResult) {
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    TetMesh m = test::ball(3, 0.15);
    curve(m);
    Options options;
    options.boundary = boundary;
    options.targets = {{Measure::min_dihedral, 30}, {Measure::min_dihedral, 5}};
    const Report report = optimize(m, options);
    const double smallest = quality(m).dihedral_min;
    ASSERT_EQ(report.targets.size(), 2U);
    for (const TargetReport& t : report.targets) {
      EXPECT_EQ(t.met(), smallest >= t.target.value) << smallest;
      if (t.met()) continue;
      EXPECT_NEAR(t.worst.front().value, smallest, 1e-9);
    }
  }
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "curved/curved_edges.hpp"
#include "driver/curved/curved_skeleton.hpp"
#include "driver/curved/split_elements.hpp"
#include "driver/curved/straighten.hpp"
#include "support/curved.hpp"
#include "tetune/curve.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

TEST(UntangleCurved, InvertedElementsAreRefusedOrUntangled) {
  TetMesh m = test::bulged_cube(-0.2);
  const TetMesh before = m;
  ASSERT_GT(quality(m).curved.inverted, 0);
  try {
    optimize(m);
    ADD_FAILURE() << "accepted";
  } catch (const CurvedError& e) {
    EXPECT_EQ(std::ssize(e.tets), quality(m).curved.tets - quality(m).curved.valid);
    EXPECT_EQ(std::string(e.what()), e.message(false) + " measure_curved() measures them.");
    const std::string first = "counted from 1: " + std::to_string(e.tets.at(0) + 1);
    EXPECT_NE(e.message(true).find(first), std::string::npos) << e.message(true);
  }
  EXPECT_EQ(m.points, before.points);
  Options options;
  options.untangle = true;
  options.boundary = Boundary::fixed;
  const Report report = optimize(m, options);
  EXPECT_TRUE(validate(m).ok());
  EXPECT_TRUE(quality(m).curved.all_valid());
  EXPECT_EQ(test::upper_middles(m), test::upper_middles(before));
  EXPECT_EQ(report.vertices, std::ssize(before.points));
  for (const Index t : report.tet2original) EXPECT_LT(t, std::ssize(before.tets));
  for (std::size_t v = 0; v < m.points.size(); ++v) {
    const Index original = report.vertex2original.empty() ? Index(v) : report.vertex2original[v];
    if (original >= 0 && before.points[static_cast<std::size_t>(original)][2] == 1) {
      EXPECT_EQ(m.points[v], before.points[static_cast<std::size_t>(original)]);
    }
  }
}

/// A cube with a face, flat or raised by `shift`, that folds where one mid-side node passes a vertex.
TetMesh folded_cube(double shift = 0) {
  TetMesh m = test::bulged_cube(shift);
  CurvedEdge& edge = m.curved_edges[3];
  const Point3& p = m.points[static_cast<std::size_t>(edge.vertices[0])];
  const Point3& q = m.points[static_cast<std::size_t>(edge.vertices[1])];
  for (std::size_t k = 0; k < 2; ++k) edge.middle[k] = p[k] + 1.3 * (q[k] - p[k]);
  edge.middle[0] += 0.3 * (q[1] - p[1]);
  edge.middle[1] -= 0.3 * (q[0] - p[0]);
  return m;
}

TEST(UntangleCurved, FoldedSurfaceIsNamed) {
  TetMesh m = folded_cube();
  Options options;
  options.untangle = true;
  try {
    optimize(m, options);
    ADD_FAILURE() << "accepted";
  } catch (const UntangleError& e) {
    EXPECT_NE(std::string(e.what()).find("mid-side nodes fold"), std::string::npos) << e.what();
    EXPECT_EQ(e.reason, UntangleError::Reason::curved_surface);
    ASSERT_FALSE(e.folded.empty());
    EXPECT_TRUE(std::includes(e.left.begin(), e.left.end(), e.folded.begin(), e.folded.end()));
    EXPECT_EQ(e.message(false), e.what());
    const std::string first = "counted from 1: " + std::to_string(e.folded[0] + 1);
    EXPECT_NE(e.message(true).find(first), std::string::npos) << e.message(true);
  }
}

TEST(UntangleCurved, AStopNamesSecondOrderElements) {
  TetMesh m = test::bulged_cube(-0.2);
  Options options;
  options.untangle = true;
  Context context;
  context.stop = [] { return true; };
  try {
    optimize(m, options, context);
    ADD_FAILURE() << "accepted";
  } catch (const UntangleError& e) {
    EXPECT_EQ(e.reason, UntangleError::Reason::stopped);
    EXPECT_TRUE(e.of_curved);
    const std::string text =
        "stopped before all of " + std::to_string(e.tangled) +
        " second-order tetrahedra that are not proved valid were made so: " + std::to_string(e.left.size()) +
        " are left";
    EXPECT_EQ(e.message(true).substr(0, text.size()), text);
  }
}

TEST(UntangleCurved, ElementsWithTwoFacesOnASmoothSurfaceAreSplit) {
  const TetMesh before = test::curved_ball();
  Options options;
  options.untangle = true;
  options.max_growth = 3;
  TetMesh m = before;
  m.point_data.push_back({"id", 1, std::vector<std::int32_t>(m.points.size(), 7)});
  const Report report = optimize(m, options);
  EXPECT_TRUE(validate(m).ok());
  EXPECT_TRUE(quality(m).curved.all_valid());
  EXPECT_GT(quality(m).curved.min_scaled_jacobian, 0.2);
  EXPECT_GT(m.points.size(), before.points.size());
  EXPECT_EQ(report.tets_after, std::ssize(m.tets));
  ASSERT_EQ(report.tet2original.size(), m.tets.size());
  ASSERT_EQ(report.vertex2original.size(), m.points.size());
  EXPECT_EQ(std::get<std::vector<std::int32_t>>(m.point_data[0].values), std::vector<std::int32_t>(m.points.size(), 7));
  std::int64_t inserted = 0;
  for (std::size_t v = 0; v < m.points.size(); ++v) inserted += report.vertex2original[v] < 0 ? 1 : 0;
  EXPECT_EQ(inserted, std::ssize(m.points) - std::ssize(before.points));
  EXPECT_EQ(report.vertices_inserted, inserted);
  options.keep_vertices = true;
  m = before;
  EXPECT_THROW(optimize(m, options), UntangleError);
  EXPECT_EQ(m.curved_edges, before.curved_edges);
}

TEST(UntangleCurved, ElementsOfAValidMeshAreSplitWithTheirData) {
  TetMesh m = test::ball(3, 0);
  curve(m);
  ASSERT_TRUE(quality(m).curved.all_valid());
  const std::size_t vertices = m.points.size();
  m.point_data.push_back({"id", 1, std::vector<std::int32_t>(vertices, 7)});
  Options options;
  options.untangle = true;
  options.flips = false;
  const Report report = optimize(m, options);
  EXPECT_TRUE(quality(m).curved.all_valid());
  EXPECT_GT(m.points.size(), vertices);
  EXPECT_EQ(report.vertices_inserted, std::ssize(m.points) - static_cast<std::int64_t>(vertices));
  EXPECT_EQ(std::get<std::vector<std::int32_t>>(m.point_data[0].values), std::vector<std::int32_t>(m.points.size(), 7));
}

TEST(UntangleCurved, SmallerAnglesAreAWarning) {
  int smaller = 0;
  for (const double bulge : {-0.3, -0.2, -0.1}) {
    TetMesh m = test::bulged_cube(bulge);
    const double before = quality(m).dihedral_min;
    Options options;
    options.untangle = true;
    options.boundary = Boundary::fixed;
    const Report report = optimize(m, options);
    const bool is_smaller = quality(m).dihedral_min < before - 1e-9;
    EXPECT_EQ(report.warnings.size(), is_smaller ? 1U : 0U);
    if (!is_smaller) continue;
    ++smaller;
    EXPECT_TRUE(report.warnings[0].starts_with("the smallest dihedral angle is ")) << report.warnings[0];
    EXPECT_EQ(report.curved_warnings, report.warnings);
  }
  EXPECT_GT(smaller, 0);
}

TEST(UntangleCurved, SplitsCountAsGrowth) {
  TetMesh before = test::ball(3, 0);
  curve(before);
  std::vector<std::size_t> tets;
  for (const Effort effort : {Effort::standard, Effort::best}) {
    for (const double growth : {1.0, 1.05, 2.0}) {
      TetMesh m = before;
      Options options;
      options.untangle = true;
      options.flips = false;
      options.effort = effort;
      options.max_growth = growth;
      const Report report = optimize(m, options);
      EXPECT_TRUE(quality(m).curved.all_valid());
      EXPECT_LE(double(m.tets.size()), growth * double(before.tets.size()));
      // With Effort::best vertices are removed, and no element that the surface bounds is left.
      const bool is_limited = effort == Effort::standard && growth < 2;
      ASSERT_EQ(report.warnings.size(), is_limited ? 1U : 0U);
      if (is_limited) {
        EXPECT_TRUE(report.warnings[0].starts_with("the surface bounds the scaled Jacobian of ")) << report.warnings[0];
      }
      if (effort == Effort::standard) tets.push_back(m.tets.size());
    }
  }
  EXPECT_EQ(tets[0], before.tets.size());
  EXPECT_LT(tets[0], tets[1]);
  EXPECT_LT(tets[1], tets[2]);
}

/// The message of the refusal; empty if the mesh is optimized.
std::string curved_refusal(TetMesh m, const Options& options) {
  try {
    optimize(m, options);
    return "";
  } catch (const MeshError& e) {
    EXPECT_NE(std::string(e.what()).find("second-order tetrahedra that are not proved valid"), std::string::npos);
    return e.what();
  }
}

TEST(UntangleCurved, RefusalsSayWhatHelps) {
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  const TetMesh ball = test::curved_ball();
  Options helped;
  helped.untangle = true;
  helped.max_growth = 1;
  EXPECT_EQ(curved_refusal(ball, helped), "") << "splits that make elements valid are not limited";
  Options options = helped;
  options.data = DataTransfer::interpolate;
  EXPECT_TRUE(has(curved_refusal(ball, options), "inserted (data=carry)")) << curved_refusal(ball, options);
  options = helped;
  options.keep_vertices = true;
  const std::string kept = curved_refusal(ball, options);
  EXPECT_TRUE(has(kept, "inserted (without keep_vertices), ")) << kept;
  EXPECT_TRUE(has(kept, "straighten=true")) << kept;
  EXPECT_FALSE(has(kept, "free frozen")) << kept;
  EXPECT_FALSE(has(kept, "boundary=slide")) << kept;
  options.straighten = true;
  EXPECT_EQ(curved_refusal(ball, options), "");
  options.frozen_regions = {ball.tet_tags[0]};
  const std::string frozen = curved_refusal(ball, options);
  EXPECT_TRUE(has(frozen, "free frozen and required entities there")) << frozen;
  EXPECT_FALSE(has(frozen, "straighten=true")) << frozen;
}

TEST(UntangleCurved, FoldedSurfaceIsStraightenedWhereAsked) {
  const TetMesh before = folded_cube();
  TetMesh m = before;
  Options options;
  options.untangle = true;
  options.straighten = true;
  options.keep_vertices = true;
  options.max_iterations = 0;
  const Report report = optimize(m, options);
  EXPECT_TRUE(validate(m).ok());
  EXPECT_TRUE(quality(m).curved.all_valid());
  // The other edges of the surface have all of their curvature.
  ASSERT_EQ(report.straightened.size(), 1U);
  const StraightenedEdge& e = report.straightened[0];
  EXPECT_EQ(e.vertices, before.curved_edges[3].vertices);
  EXPECT_GT(e.kept, 0.1);
  EXPECT_LT(e.kept, 1);
  const auto full = before.curved_edges[3].middle;
  double moved = 0;
  for (const CurvedEdge& c : m.curved_edges) {
    if (c.vertices == e.vertices) {
      moved = std::hypot(c.middle[0] - full[0], c.middle[1] - full[1], c.middle[2] - full[2]);
    }
  }
  EXPECT_NEAR(moved, e.moved, 1e-12);

  options.frozen_regions = {before.tet_tags[0]};
  TetMesh frozen = before;
  EXPECT_THROW(optimize(frozen, options), MeshError);
  EXPECT_EQ(frozen.curved_edges, before.curved_edges);

  // Nor do mid-side nodes of other elements move.
  options.frozen_regions.clear();
  TetMesh beside = before;
  const auto& [a, b] = before.curved_edges[3].vertices;
  beside.points.insert(beside.points.end(), {{9, 0, 0}, {9, 1, 0}});
  beside.point_tags.resize(beside.points.size(), 0);
  const Index last = static_cast<Index>(beside.points.size()) - 1;
  beside.others = {{"Quadrilaterals", 4, {a, b, last, last - 1}, {0}, {}, {}, true}};
  const TetMesh held = beside;
  EXPECT_THROW(optimize(beside, options), MeshError);
  EXPECT_EQ(beside.curved_edges, held.curved_edges);
}

TEST(UntangleCurved, EdgesBesideOneThatHasToBeStraightKeepTheirCurvature) {
  TetMesh m = folded_cube(0.03);
  // No part of its curvature that bisection finds is small enough.
  CurvedEdge& far = m.curved_edges[3];
  const std::array<Index, 2> folded = far.vertices;
  const Vec3 middle = 0.5 * (test::at(m, folded[0]) + test::at(m, folded[1]));
  far.middle = to_point(middle + 100 * (vec(far.middle) - middle));
  const std::vector<CurvedEdge> before = m.curved_edges;
  RelaxationGoal goal;
  goal.only_valid = true;
  const std::vector<StraightenedEdge> straightened = straighten(m, find_held(m, {}), {}, goal);
  EXPECT_TRUE(quality(m).curved.all_valid());
  ASSERT_EQ(straightened.size(), 1U);
  EXPECT_EQ(straightened[0].vertices, folded);
  EXPECT_EQ(straightened[0].kept, 0);
  for (const CurvedEdge& e : before) {
    const CurvedEdge* const now = find_edge(m.curved_edges, e.vertices);
    EXPECT_EQ(now != nullptr, e.vertices != folded);
    if (now != nullptr) {
      EXPECT_EQ(now->middle, e.middle);
    }
  }
}

TEST(UntangleCurved, SplitsThatDoNotHelpAreUndone) {
  TetMesh m = test::ball(2, 0);
  curve(m);
  // A mid-side node far along its edge folds curved triangles: no position of inner nodes makes their elements valid.
  CurvedEdge& edge = m.curved_edges[0];
  const Vec3 chord = test::at(m, edge.vertices[1]) - test::at(m, edge.vertices[0]);
  edge.middle = to_point(vec(edge.middle) + 0.8 * chord);
  const TetMesh before = m;
  HeldNodes held = find_held(m, {});
  Origins origins = own_origins(m);
  RelaxationGoal goal;
  goal.only_valid = true;
  const std::size_t unfolded = find_unfolded(m, 1).size();
  ASSERT_GT(unfolded, 0U);
  split_invalid(m, held, origins, goal);
  EXPECT_EQ(find_unfolded(m, 1).size(), unfolded);
  EXPECT_TRUE(m.tets == before.tets && m.points == before.points && m.curved_edges == before.curved_edges);
  EXPECT_EQ(held.vertices.size(), m.points.size());
  EXPECT_EQ(origins.tets.size(), m.tets.size());
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
// Options::only_below: listed edges, triangles and corners of the active part.
#include <gtest/gtest.h>

#include "backend/span.hpp"
#include "mesh/tet.hpp"
#include "support/entities.hpp"
#include "support/meshes.hpp"
#include "tetune/optimize.hpp"

namespace tetune {
namespace {

using test::edges_of;
using test::faces_of;

TEST(OnlyBelowLimit, ListedEdgesThatNoLongerExistAreDropped) {
  std::int64_t dropped = 0;
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    TetMesh mesh = test::cube(6, 0.2, seed);
    const auto edges = edges_of(mesh);
    mesh.edges.assign(edges.begin(), edges.end());
    mesh.edge_tags.assign(mesh.edges.size(), 0);
    Options options;
    options.only_below = {{Measure::min_dihedral, 36}};
    options.rings = 0;
    dropped += optimize(mesh, options).edges_dropped;
    const auto existing = edges_of(mesh);
    for (const auto& [a, b] : mesh.edges) EXPECT_TRUE(existing.contains(ascending(a, b)));
  }
  EXPECT_GT(dropped, 0);
}

/// A triangle inside the part may have frozen vertices alone.
TEST(OnlyBelowLimit, ListedTrianglesThatNoLongerAreFacesAreDropped) {
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    TetMesh mesh = test::cube(6, 0.2, seed);
    const auto before = faces_of(mesh);
    mesh.triangles.assign(before.begin(), before.end());
    mesh.triangle_tags.assign(mesh.triangles.size(), 0);
    Options options;
    options.only_below = {{Measure::min_dihedral, 36}};
    options.rings = 0;
    const Report report = optimize(mesh, options);
    EXPECT_EQ(report.triangles_dropped, std::ssize(before) - std::ssize(mesh.triangles));
    EXPECT_GT(report.triangles_dropped, 0);
    const auto existing = faces_of(mesh);
    for (const auto& triangle : mesh.triangles) EXPECT_TRUE(existing.contains(ascending(triangle)));
  }
}

/// The map of the part's report is empty then, as where all are kept.
TEST(OnlyBelowLimit, ListedEdgesAreDroppedWhereThePartKeepsNone) {
  const TetMesh input = test::cube(6, 0.2);
  Options options;
  options.only_below = {{Measure::min_dihedral, 60}};
  TetMesh mesh = input;
  optimize(mesh, options);
  const auto kept = edges_of(mesh);
  mesh = input;
  for (const auto& edge : edges_of(input)) {
    if (!kept.contains(edge) && mesh.edges.size() < 5) mesh.edges.push_back(edge);
  }
  ASSERT_EQ(mesh.edges.size(), 5U);
  mesh.edge_tags.assign(5, 0);
  const Report report = optimize(mesh, options);
  EXPECT_EQ(report.edges_dropped, 5);
  EXPECT_TRUE(mesh.edges.empty());
  EXPECT_TRUE(mesh.edge_tags.empty());
  EXPECT_TRUE(report.edge2original.empty());
}

/// A corner that is listed, and that the geometry does not show, is held as in the whole mesh.
TEST(OnlyBelowLimit, ListedCornersDoNotMove) {
  TetMesh mesh = test::cube(8, 0.2, 3);
  for (Index v = 0; v < static_cast<Index>(mesh.points.size()) && mesh.corners.empty(); ++v) {
    const Point3& p = mesh.points[to_size_t(v)];
    if (p[2] == 0 && p[0] > 0.3 && p[0] < 0.7 && p[1] > 0.3 && p[1] < 0.7) mesh.corners.push_back(v);
  }
  ASSERT_EQ(mesh.corners.size(), 1U);
  const TetMesh before = mesh;
  Options options;
  options.only_below = {{Measure::min_dihedral, 40}};
  options.effort = Effort::best;
  const Report report = optimize(mesh, options);
  EXPECT_GT(report.plane_vertices, 0);
  ASSERT_EQ(mesh.corners, before.corners);
  EXPECT_EQ(mesh.points[to_size_t(mesh.corners[0])], before.points[to_size_t(before.corners[0])]);
}

}  // namespace
}  // namespace tetune

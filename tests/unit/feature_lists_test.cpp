// SPDX-License-Identifier: Apache-2.0
// Features and corners that the caller gives: patches, ridges, tagged edges and frozen parts, and lists that are not
// lists of features.
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "boundary/classify.hpp"
#include "support/meshes.hpp"
#include "support/sliding_dofs.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

using test::classify_sliding, test::cube_vertex, test::expect_dofs, test::Sliding;

/// Triangles of the face z = 0 of a cube of n^3 cells, tagged by their column.
template <class Tag>
TetMesh with_patches(int n, const Tag& tag) {
  TetMesh m = test::cube(n);
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      m.triangles.push_back({cube_vertex(n, i, j, 0), cube_vertex(n, i + 1, j, 0), cube_vertex(n, i + 1, j + 1, 0)});
      m.triangles.push_back({cube_vertex(n, i, j, 0), cube_vertex(n, i, j + 1, 0), cube_vertex(n, i + 1, j + 1, 0)});
      m.triangle_tags.insert(m.triangle_tags.end(), 2, tag(i, j));
    }
  }
  return m;
}

TEST(Features, BordersBetweenPatchesAreLines) {
  const TetMesh halves = with_patches(4, [](int i, int) { return i < 2 ? 5 : 6; });
  // With 180 degrees the boundary of the face is a line as well, between tags 5 or 6 and no tag; it meets the border
  // between the patches twice.
  expect_dofs(classify_sliding(halves), 8 + 2, 36 - 2 + 3, 54 - 3, 27);
  expect_dofs(classify_sliding(halves, 180), 2, 16 - 2 + 3, 98 - 16 - 3, 27);
  const TetMesh whole = with_patches(4, [](int, int) { return 5; });
  expect_dofs(classify_sliding(whole), 8, 36, 54, 27);
  expect_dofs(classify_sliding(whole, 180), 0, 16, 98 - 16, 27);
}

TEST(Features, RidgesAreLinesWhateverTheAngle) {
  TetMesh m = test::cube(4);
  // A closed line around the inside of the face z = 0.
  const std::array<std::array<int, 2>, 8> ring{{{1, 1}, {2, 1}, {3, 1}, {3, 2}, {3, 3}, {2, 3}, {1, 3}, {1, 2}}};
  for (std::size_t k = 0; k < 8; ++k) {
    const auto& a = ring[k];
    const auto& b = ring[(k + 1) % 8];
    m.edges.push_back({cube_vertex(4, a[0], a[1], 0), cube_vertex(4, b[0], b[1], 0)});
    m.ridges.push_back(static_cast<Index>(k));
  }
  m.edge_tags.assign(8, 0);
  expect_dofs(classify_sliding(m), 8 + 4, 36 + 4, 54 - 8, 27);  // it turns sharply at four corners
  expect_dofs(classify_sliding(m, 180), 0, 8, 98 - 8, 27);
  m.required_edges = {0};
  expect_dofs(classify_sliding(m, 180), 2, 6, 98 - 8, 27);
}

TEST(Features, VerticesOfATaggedLineInsideSlideAlongIt) {
  TetMesh m = test::cube(4);
  for (int i = 1; i < 3; ++i) m.edges.push_back({cube_vertex(4, i, 2, 2), cube_vertex(4, i + 1, 2, 2)});
  m.edge_tags = {7, 7};
  expect_dofs(classify_sliding(m), 8 + 2, 36 + 1, 54, 27 - 3);
}

TEST(Lists, OfEdgesThatMeetInFewPlacesAreFeatures) {
  const auto are_lines = [](const std::vector<Index>& ends, Size first, const std::vector<VertexDof>& dof) {
    return are_feature_lines(span_of(ends), first, span_of(dof));
  };
  const std::vector<VertexDof> dof(1000, VertexDof::surface);
  const auto star = [](Index center) {
    std::vector<Index> ends;
    for (Index k = 1; k <= 3; ++k) {
      ends.push_back(center);
      ends.push_back(center + k);
    }
    return ends;
  };
  const auto stars = [&](int count) {
    std::vector<Index> ends;
    for (int i = 0; i < count; ++i) {
      const std::vector<Index> one = star(static_cast<Index>(4 * i));
      ends.insert(ends.end(), one.begin(), one.end());
    }
    return ends;
  };
  EXPECT_TRUE(are_lines({}, 0, dof));
  EXPECT_TRUE(are_lines(stars(50), 0, dof));  // one in twenty
  EXPECT_FALSE(are_lines(stars(51), 0, dof));
  // Ten junctions are accepted in any mesh.
  const std::vector<VertexDof> small(44, VertexDof::surface);
  EXPECT_TRUE(are_lines(stars(10), 0, small));
  EXPECT_FALSE(are_lines(stars(11), 0, small));
  // Neither the first entries nor junctions that are fixed anyway count.
  EXPECT_TRUE(are_lines(stars(51), 6, dof));
  std::vector<VertexDof> corners = dof;
  for (std::size_t i = 0; i < 4 * 51; i += 4) corners[i] = VertexDof::fixed;
  EXPECT_TRUE(are_lines(stars(51), 0, corners));
}

TEST(Lists, OfEdgesWithTagsOfTheirOwnHaveNoEnds) {
  // Two tags meet in the middle of each edge of the cube, and every edge of the mesh has a tag of its own afterwards.
  constexpr int n = 4;
  TetMesh m = test::cube(n);
  for (int i = 0; i < n; ++i) {
    m.edges.push_back({cube_vertex(n, i, 0, 0), cube_vertex(n, i + 1, 0, 0)});
    m.edges.push_back({cube_vertex(n, 0, i, 0), cube_vertex(n, 0, i + 1, 0)});
    m.edges.push_back({cube_vertex(n, 0, 0, i), cube_vertex(n, 0, 0, i + 1)});
    m.edges.push_back({cube_vertex(n, i, n, n), cube_vertex(n, i + 1, n, n)});
    m.edge_tags.insert(m.edge_tags.end(), 4, i < n / 2 ? 1 : 2);
  }
  const Report halves = classify_sliding(m);
  expect_dofs(halves, 8 + 4, 36 - 4, 54, 27);
  EXPECT_EQ(halves.line_ends_not_held, 0);
  for (std::size_t e = 0; e < m.edges.size(); ++e) m.edge_tags[e] = static_cast<int>(e) + 1;
  const Report own = classify_sliding(m);
  expect_dofs(own, 8, 36, 54, 27);
  EXPECT_EQ(own.line_ends_not_held, 4 * (n - 1));
  EXPECT_EQ(own.edges_not_held, 0);
}

/// All edges of the surface, tagged, as TetGen lists them.
TetMesh all_edges_tagged(int n) {
  TetMesh m = test::cube(n);
  const Sliding s(m, 45);
  for (Size t = 0; t < s.reference.triangles.size(); ++t) {
    const SurfaceTriangle f = s.reference.triangles.span()[t];
    for (int k = 0; k < 3; ++k) m.edges.push_back({f.v[k], f.v[(k + 1) % 3]});
  }
  m.edge_tags.assign(m.edges.size(), 1);
  return m;
}

TEST(Lists, OfAllEdgesAreNoFeatures) {
  TetMesh m = all_edges_tagged(4);
  const Report r = classify_sliding(m);
  expect_dofs(r, 8, 36, 54, 27);
  EXPECT_EQ(r.edges_not_held, 96 * 3);  // each once: 192 triangles
  // They remain edges of the mesh.
  TetMesh after = m;
  Options options;
  options.boundary = Boundary::slide;
  optimize(after, options);
  EXPECT_EQ(after.edges, m.edges);
  // Ridges among them remain features: here on the face z = 0.
  const std::array<std::array<Index, 2>, 2> ridge{
      {{cube_vertex(4, 1, 2, 0), cube_vertex(4, 2, 2, 0)}, {cube_vertex(4, 2, 2, 0), cube_vertex(4, 3, 2, 0)}}};
  for (const auto& e : ridge) {
    m.edges.push_back(e);
    m.edge_tags.push_back(0);
    m.ridges.push_back(static_cast<Index>(m.edges.size() - 1));
  }
  expect_dofs(classify_sliding(m), 8 + 2, 36 + 1, 54 - 3, 27);
  // The same decision for Boundary::preserve.
  Options preserve;
  preserve.max_iterations = 0;
  TetMesh again = all_edges_tagged(4);
  EXPECT_EQ(optimize(again, preserve).plane_vertices, 54);
}

TEST(Lists, OfFewCornersAreCornersAndOfManyAreNot) {
  TetMesh m = test::cube(6);
  for (int i = 1; i <= 5; ++i) m.corners.push_back(cube_vertex(6, i, 3, 0));
  Report r = classify_sliding(m);
  expect_dofs(r, 8 + 5, 60, 150 - 5, 125);
  EXPECT_EQ(r.corners_not_held, 0);
  m.corners.clear();
  for (int i = 1; i <= 5; ++i) {
    for (int j = 1; j <= 5; ++j) m.corners.push_back(cube_vertex(6, i, j, 0));
  }
  m.corners.push_back(0);
  r = classify_sliding(m);
  expect_dofs(r, 8, 60, 150, 125);
  EXPECT_EQ(r.corners_not_held, 25);
  // Required vertices are fixed, whatever their number.
  m.required_vertices = m.corners;
  expect_dofs(classify_sliding(m), 8 + 25, 60, 150 - 25, 125);
}

TEST(Frozen, RegionsPatchesAndVerticesOfTheOptionsDoNotMove) {
  TetMesh m = test::two_materials(4);
  Options options;
  options.boundary = Boundary::slide;
  options.max_iterations = 0;
  options.frozen_regions = {2};
  TetMesh copy = m;
  // 3 of 5 layers of 25 vertices.
  EXPECT_EQ(optimize(copy, options).fixed_vertices, 75 + 4);
  options.frozen_regions = {3};
  EXPECT_THROW(optimize(copy, options), OptionError);
  options.frozen_regions.clear();
  options.frozen_patches = {5};
  EXPECT_THROW(optimize(copy, options), OptionError);
  TetMesh patched = with_patches(4, [](int i, int) { return i < 2 ? 5 : 6; });
  EXPECT_EQ(optimize(patched, options).fixed_vertices, 15 + 4 + 2);
  options.frozen_patches.clear();
  options.frozen_vertices.assign(m.points.size() - 1, 0);
  EXPECT_THROW(optimize(copy, options), OptionError);
  options.frozen_vertices.assign(m.points.size(), 1);
  EXPECT_EQ(optimize(copy, options).fixed_vertices, 125);
}

TEST(Frozen, APatchInsideARegionRemainsWithoutOpenBoundaries) {
  TetMesh m = test::cube(4);
  m.triangles = {{cube_vertex(4, 1, 2, 1), cube_vertex(4, 2, 2, 1), cube_vertex(4, 2, 2, 2)},
                 {cube_vertex(4, 2, 1, 1), cube_vertex(4, 2, 1, 2), cube_vertex(4, 3, 1, 2)}};
  m.triangle_tags = {3, 4};
  Options options;
  options.max_iterations = 0;
  options.open_boundaries = false;
  TetMesh dropped = m;
  Report r = optimize(dropped, options);
  EXPECT_EQ(r.triangles_dropped, 2);
  EXPECT_EQ(r.free_vertices, 27);
  options.frozen_patches = {3};
  TetMesh kept = m;
  r = optimize(kept, options);
  EXPECT_EQ(r.triangles_dropped, 1);
  EXPECT_EQ(r.free_vertices, 24);
  EXPECT_EQ(kept.triangles, (std::vector<std::array<Index, 3>>{m.triangles[0]}));
  options.frozen_patches.clear();
  options.open_boundaries = true;
  TetMesh all = m;
  r = optimize(all, options);
  EXPECT_EQ(r.triangles_dropped, 0);
  EXPECT_EQ(r.free_vertices, 21);
}

}  // namespace
}  // namespace tetune

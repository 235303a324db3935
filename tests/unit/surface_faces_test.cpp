// SPDX-License-Identifier: Apache-2.0
// Faces of the boundary and between regions, against all half-faces matched by a map.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "io/second_order.hpp"
#include "mesh/surface_edges.hpp"
#include "mesh/tet_orientation.hpp"
#include "quality/mesh_surface.hpp"
#include "support/meshes.hpp"

namespace tetune {
namespace {

using FaceVertices = std::array<Index, 3>;
using SurfaceFaces = std::set<std::pair<FaceVertices, bool>>;  // and whether it is on the boundary

SurfaceFaces found_faces(const TetMesh& m, int threads) {
  SurfaceFaces faces;
  FaceVertices last{-1, -1, -1};
  for_each_surface_face(m, threads, [&](const SortedHalfFace& face, bool is_boundary) {
    EXPECT_LT(last, face.vertices);
    last = face.vertices;
    const auto& tet = m.tets[to_size_t(face.tet)];
    for (const Index v : face.vertices) EXPECT_NE(std::find(tet.begin(), tet.end(), v), tet.end());
    faces.insert({face.vertices, is_boundary});
  });
  return faces;
}

SurfaceFaces expected_faces(const TetMesh& m) {
  std::map<FaceVertices, std::vector<int>> regions;
  for (std::size_t t = 0; t < m.tets.size(); ++t) {
    for (std::size_t f = 0; f < 4; ++f) {
      FaceVertices face{};
      for (std::size_t k = 0; k < 3; ++k) face[k] = m.tets[t][(f + 1 + k) % 4];
      std::sort(face.begin(), face.end());
      regions[face].push_back(m.tet_tags[t]);
    }
  }
  SurfaceFaces faces;
  for (const auto& [face, at] : regions) {
    if (at.size() == 1 || at[0] != at[1]) faces.insert({face, at.size() == 1});
  }
  return faces;
}

/// The same mesh with other numbers of vertices and tetrahedra.
TetMesh shuffled(TetMesh m, std::mt19937& random) {
  std::vector<Index> ids(m.points.size());
  for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = static_cast<Index>(i);
  std::shuffle(ids.begin(), ids.end(), random);
  for (auto& tet : m.tets) {
    for (Index& v : tet) v = ids[to_size_t(v)];
  }
  const std::vector<Point3> points = m.points;
  for (std::size_t i = 0; i < ids.size(); ++i) m.points[to_size_t(ids[i])] = points[i];
  for (std::size_t i = m.tets.size(); i > 1; --i) {
    const std::size_t j = random() % i;
    std::swap(m.tets[i - 1], m.tets[j]);
    std::swap(m.tet_tags[i - 1], m.tet_tags[j]);
  }
  return m;
}

TEST(ForEachSurfaceFace, VisitsFacesOfOneTetrahedronAndOfTwoRegions) {
  std::mt19937 random(3);
  for (const TetMesh& mesh : {test::one_tet(), test::cube(6, 0.2), test::two_materials(6)}) {
    for (int i = 0; i < 3; ++i) {
      const TetMesh m = shuffled(mesh, random);
      for (const int threads : {1, 3}) EXPECT_EQ(found_faces(m, threads), expected_faces(m));
    }
  }
}

TEST(ForEachSurfaceFace, DoesNotDependOnTheOrientationOfTetrahedra) {
  std::mt19937 random(4);
  TetMesh m = test::two_materials(5);
  const SurfaceFaces expected = expected_faces(m);
  for (auto& tet : m.tets) {
    if (random() % 3 == 0) std::swap(tet[2], tet[3]);
  }
  EXPECT_EQ(found_faces(m, 2), expected);
}

TEST(ForEachSurfaceFace, VisitsAllFacesBetweenManyRegions) {
  std::mt19937 random(5);
  TetMesh m = test::cube(5, 0.1);
  for (int& tag : m.tet_tags) tag = static_cast<int>(random() % 5) - 2;
  EXPECT_EQ(found_faces(m, 2), expected_faces(m));
}

TEST(SurfaceEdges, AreThoseOfTheFaces) {
  std::mt19937 random(7);
  TetMesh m = test::cube(4, 0.1);
  for (int& tag : m.tet_tags) tag = static_cast<int>(random() % 8) == 0 ? 2 : 1;
  std::set<Index> vertices;
  std::set<std::pair<Index, Index>> edges;
  for (const auto& [v, is_boundary] : expected_faces(m)) {
    vertices.insert(v.begin(), v.end());
    edges.insert({{v[0], v[1]}, {v[1], v[2]}, {v[0], v[2]}});
  }
  const SurfaceEdges surface(m);
  int across = 0;
  for (const auto& tet : m.tets) {
    for (const auto& [i, j] : kTetEdges) {
      const std::array<Index, 2> e = ascending(tet[to_size_t(i)], tet[to_size_t(j)]);
      const bool is_across = vertices.contains(e[0]) && vertices.contains(e[1]) && !edges.contains({e[0], e[1]});
      EXPECT_EQ(surface.is_across(e[0], e[1]), is_across);
      across += is_across ? 1 : 0;
    }
  }
  EXPECT_GT(across, 0);
  for (Index v = 0; v < std::ssize(m.points); ++v) {
    EXPECT_EQ(span_of(surface.on_surface())[v] != 0, vertices.contains(v));
  }
}

/// The midpoint of each edge is a sample of a comparison, taken from a triangle that lists the edge in one direction.
TEST(FindSurface, ListsEachEdgeInBothDirections) {
  std::mt19937 random(6);
  TetMesh regions = test::cube(4, 0.1);
  for (int& tag : regions.tet_tags) tag = static_cast<int>(random() % 5) - 2;
  for (const TetMesh& mesh : {test::one_tet(), test::cube(4, 0.2), test::two_materials(4), regions}) {
    std::set<std::pair<Index, Index>> edges;
    for (const auto& v : find_surface(shuffled(mesh, random), 1, 1).ids) {
      edges.insert({{v[0], v[1]}, {v[1], v[2]}, {v[2], v[0]}});
    }
    for (const auto& [a, b] : edges) EXPECT_TRUE(edges.contains({b, a}));
  }
}

}  // namespace
}  // namespace tetune

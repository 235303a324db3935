// SPDX-License-Identifier: Apache-2.0
// The features of the surface that vertices slide on, and its corners, by geometry and regions.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "support/meshes.hpp"
#include "support/sliding_dofs.hpp"

namespace tetune {
namespace {

using test::classify_sliding, test::cube_vertex, test::expect_dofs, test::Sliding;

/// A pyramid with its tip down, over a square whose triangle beside the diagonal (0, 1) is a cap with its vertex at
/// `cap`; vertex 2 is at `corner`.
TetMesh pyramid_with_cap(const Point3& cap, const Point3& corner) {
  TetMesh m;
  m.points = {{-1, 0, 0}, {1, 0, 0}, corner, {0, -1, 0}, cap, {0, 0, -2}};
  m.tets = {{0, 1, 2, 5}, {0, 4, 1, 5}, {0, 3, 4, 5}, {4, 3, 1, 5}};
  for (auto& t : m.tets) std::swap(t[0], t[1]);
  return test::with_tags(m);
}
/// Whether the edge between two vertices is one of the reference surface that is no feature.
bool is_smooth_edge(const Sliding& s, Index a, Index b) {
  const ReferenceView ref = s.reference.view();
  for (Size corner = 0; corner < 3 * ref.triangles.size(); ++corner) {
    const SurfaceTriangle& t = ref.triangles[corner / 3];
    const Index u = t.v[(corner + 1) % 3];
    const Index v = t.v[(corner + 2) % 3];
    if ((u == a && v == b) || (u == b && v == a)) return ref.across[corner] != kFeatureEdge;
  }
  ADD_FAILURE() << "no edge " << a << ' ' << b;
  return false;
}

TEST(Features, NoneAtACapWhoseNormalIsNoise) {
  // The cap is turned by 63 degrees against all its neighbors, which are coplanar.
  const Sliding s(pyramid_with_cap({0, -0.01, 0.02}, {0, 1, 0}), 50);
  EXPECT_TRUE(is_smooth_edge(s, 0, 1));
  EXPECT_TRUE(is_smooth_edge(s, 0, 4));
  EXPECT_TRUE(is_smooth_edge(s, 1, 4));
  EXPECT_EQ(s.dof[4], VertexDof::surface);
}
TEST(Features, BesideACapAreKept) {
  // The surface folds by 45 degrees at the diagonal, beside which the cap is coplanar with the other two triangles.
  const Sliding flat(pyramid_with_cap({0, -0.01, 0}, {0, 1, -1}), 40);
  EXPECT_FALSE(is_smooth_edge(flat, 0, 1));
  EXPECT_EQ(flat.dof[4], VertexDof::surface);
  // With a cap whose normal is noise, the fold is at its short edges.
  const Sliding noisy(pyramid_with_cap({0, -0.01, 0.02}, {0, 1, -1}), 40);
  EXPECT_TRUE(is_smooth_edge(noisy, 0, 1));
  EXPECT_FALSE(is_smooth_edge(noisy, 0, 4));
  EXPECT_FALSE(is_smooth_edge(noisy, 1, 4));
  EXPECT_EQ(noisy.dof[4], VertexDof::curve);
}
TEST(Features, ATriangleWithAShortEdgeIsNoCap) {
  // Two long strips of width 0.01 that fold by 90 degrees: thin triangles with normals that count.
  TetMesh m;
  m.points = {{0, 0, 0}, {1, 0, 0}, {0, 0.01, 0}, {1, 0.01, 0}, {0, 0, -0.01}, {1, 0, -0.01}};
  m.tets = {{0, 2, 1, 4}, {1, 2, 3, 5}, {1, 2, 5, 4}};
  const Sliding s(test::with_tags(m), 40);
  EXPECT_FALSE(is_smooth_edge(s, 0, 1));
  EXPECT_TRUE(is_smooth_edge(s, 1, 2));
}

TEST(Features, OfACube) {
  expect_dofs(classify_sliding(test::cube(4)), 8, 36, 54, 27);
  expect_dofs(classify_sliding(test::cube(4), 89), 8, 36, 54, 27);
  // The surface turns by 90 degrees at the edges of the cube.
  expect_dofs(classify_sliding(test::cube(4), 91), 0, 0, 98, 27);
  expect_dofs(classify_sliding(test::cube(4), 180), 0, 0, 98, 27);
}

TEST(Features, OfAPartMuchSmallerThanTheMeshAreTheSame) {
  TetMesh m = test::cube(4);
  const auto one = static_cast<Index>(m.points.size());
  const TetMesh large = m;
  for (Point3& p : m.points) p = {1e-45 * p[0], 1e-45 * p[1], 1e-45 * p[2]};
  for (const Point3& p : large.points) m.points.push_back({p[0] - 2, p[1], p[2]});
  for (auto tet : large.tets) {
    for (Index& v : tet) v += one;
    m.tets.push_back(tet);
  }
  expect_dofs(classify_sliding(test::with_tags(m)), 16, 72, 108, 54);
}

TEST(Features, OfATurnedAndStretchedCubeAreTheSame) {
  TetMesh m = test::cube(4);
  const double c = std::cos(0.7);
  const double s = std::sin(0.7);
  for (Point3& p : m.points) {
    p = {c * p[0] - s * p[1], s * p[0] + c * p[1], 3e5 * p[2]};
    p = {p[0], c * p[1] - s * p[2], s * p[1] + c * p[2]};
  }
  expect_dofs(classify_sliding(m), 8, 36, 54, 27);
}

TEST(Features, OfTwoMaterialsIncludeTheBorderOfTheInterface) {
  expect_dofs(classify_sliding(test::two_materials(4)), 8 + 4, 36 - 4 + 12, 54 - 12 + 9, 27 - 9);
  // The border of the interface is on three sheets, so it is a feature for any angle. It is closed; its four turns by
  // 90 degrees are within a feature angle of 180 degrees.
  expect_dofs(classify_sliding(test::two_materials(4), 180), 0, 16, 98 - 16 + 9, 27 - 9);
}

TEST(Features, LinesKeepTheirOrder) {
  const Sliding s(test::cube(4), 45);
  for (int i = 1; i < 4; ++i) {
    const auto line = s.reference.line.span()[cube_vertex(4, i, 0, 0)];
    EXPECT_EQ(std::minmax(line.next[0], line.next[1]),
              std::minmax<Index>(cube_vertex(4, i - 1, 0, 0), cube_vertex(4, i + 1, 0, 0)));
  }
  EXPECT_EQ(s.reference.line.span()[cube_vertex(4, 1, 1, 0)].next[0], -1);
}

TEST(Features, AdjacencyAcrossEdgesIsSymmetric) {
  for (const double angle : {45.0, 180.0}) {
    const Sliding s(test::two_materials(4, 0.1), angle);
    int features = 0;
    for (Size c = 0; c < s.reference.across.size(); ++c) {
      const Index other = s.reference.across.span()[c];
      if (other == kFeatureEdge) {
        ++features;
        continue;
      }
      EXPECT_EQ(s.reference.across.span()[other], c);
      const SurfaceTriangle t = s.reference.triangles.span()[c / 3];
      const SurfaceTriangle q = s.reference.triangles.span()[other / 3];
      EXPECT_EQ(std::minmax(t.v[(c + 1) % 3], t.v[(c + 2) % 3]),
                std::minmax(q.v[(other + 1) % 3], q.v[(other + 2) % 3]));
    }
    // 16 border edges with three triangles each; the edges of the cube, 12 times 4, with two.
    EXPECT_EQ(features, 3 * 16 + (angle < 90 ? 2 * 48 : 0));
  }
}

enum class PrismEnd { flat, apex };

/// A prism of n sides around a center line, of the given number of layers.
TetMesh prism(int n, int layers, PrismEnd end) {
  TetMesh m;
  for (int l = 0; l <= layers; ++l) {
    m.points.push_back({0, 0, static_cast<double>(l)});
    const double r = end == PrismEnd::apex ? 1 - static_cast<double>(l) / (layers + 1) : 1;
    for (int i = 0; i < n; ++i) {
      const double a = 2 * std::numbers::pi * i / n;
      m.points.push_back({r * std::cos(a), r * std::sin(a), static_cast<double>(l)});
    }
  }
  const auto at = [n](int l, int i) { return static_cast<Index>(l * (n + 1) + 1 + i % n); };
  const auto axis = [n](int l) { return static_cast<Index>(l * (n + 1)); };
  for (int l = 0; l < layers; ++l) {
    for (int i = 0; i < n; ++i) {
      // The wedge between two sides, with its columns in ascending order, so that neighbors have the same diagonals.
      std::array<std::pair<Index, Index>, 3> column{
          {{axis(l), axis(l + 1)}, {at(l, i), at(l + 1, i)}, {at(l, i + 1), at(l + 1, i + 1)}}};
      std::sort(column.begin(), column.end());
      m.tets.push_back({column[0].first, column[1].first, column[2].first, column[2].second});
      m.tets.push_back({column[0].first, column[1].first, column[1].second, column[2].second});
      m.tets.push_back({column[0].first, column[0].second, column[1].second, column[2].second});
    }
  }
  if (end == PrismEnd::apex) {
    m.points.push_back({0, 0, layers + 1.0});
    for (int i = 0; i < n; ++i) {
      m.tets.push_back({axis(layers), at(layers, i), at(layers, i + 1), static_cast<Index>(m.points.size() - 1)});
    }
  }
  for (auto& t : m.tets) {
    const auto p = [&](std::size_t k) { return test::at(m, t[k]); };
    if (dot(cross(p(1) - p(0), p(2) - p(0)), p(3) - p(0)) < 0) std::swap(t[2], t[3]);
  }
  return test::with_tags(m);
}

TEST(Features, OfACylinderAreItsTwoCircles) {
  // 12 sides turn by 30 degrees each, and so do the circles at each vertex.
  const TetMesh m = prism(12, 3, PrismEnd::flat);
  expect_dofs(classify_sliding(m), 0, 2 * 12, 2 * 12 + 2, 2);
  // Below 30 degrees the edges between the sides are features too; they meet the circles in corners.
  expect_dofs(classify_sliding(m, 20), 2 * 12, 2 * 12, 2, 2);
  expect_dofs(classify_sliding(m, 180), 0, 0, 4 * 12 + 2, 2);
  // 6 sides turn by 60.
  expect_dofs(classify_sliding(prism(6, 3, PrismEnd::flat)), 2 * 6, 2 * 6, 2, 2);
}

TEST(Features, OfAConeAreItsCircleAndNotItsApex) {
  // The edges at the apex turn by less than the angle: no feature ends there. A list of corners may contain it.
  TetMesh m = prism(16, 3, PrismEnd::apex);
  expect_dofs(classify_sliding(m), 0, 16, 3 * 16 + 1 + 1, 3);
  m.corners = {static_cast<Index>(m.points.size() - 1)};
  expect_dofs(classify_sliding(m), 1, 16, 3 * 16 + 1, 3);
}

/// Two cubes of n^3 cells. Coincident vertices at p are merged if shared(p).
template <class IsShared>
TetMesh two_cubes(int n, const Point3& offset, const IsShared& shared) {
  TetMesh m = test::cube(n);
  const TetMesh other = m;
  std::vector<Index> number;
  for (const Point3& p : other.points) {
    const Point3 q{p[0] + offset[0], p[1] + offset[1], p[2] + offset[2]};
    const auto at = std::find(m.points.begin(), m.points.begin() + static_cast<std::ptrdiff_t>(other.points.size()), q);
    if (shared(q) && at != m.points.begin() + static_cast<std::ptrdiff_t>(other.points.size())) {
      number.push_back(static_cast<Index>(at - m.points.begin()));
    } else {
      number.push_back(static_cast<Index>(m.points.size()));
      m.points.push_back(q);
    }
  }
  for (auto t : other.tets) {
    for (Index& v : t) v = number[static_cast<std::size_t>(v)];
    m.tets.push_back(t);
  }
  m.tet_tags.clear();
  return test::with_tags(m);
}

TEST(Features, AVertexSharedByTwoCubesIsFixed) {
  const TetMesh m = two_cubes(2, {1, 1, 1}, [](const Point3&) { return true; });
  ASSERT_EQ(m.points.size(), 2U * 27 - 1);
  EXPECT_EQ(classify_sliding(m).fixed_vertices, 15);
  expect_dofs(classify_sliding(m, 180), 1, 0, 2 * 25, 2);
}

TEST(Features, VerticesOfAnEdgeSharedByTwoCubesSlideAlongIt) {
  const TetMesh m = two_cubes(4, {1, 1, 0}, [](const Point3&) { return true; });
  ASSERT_EQ(m.points.size(), 2U * 125 - 5);
  const Report r = classify_sliding(m, 180);
  // Its ends are ends of a line.
  expect_dofs(r, 2, 3, 2 * (98 - 5), 2 * 27);
  TetMesh after = m;
  Options options;
  options.boundary = Boundary::slide;
  options.feature_angle = 180;
  optimize(after, options);
  for (std::size_t v = 0; v < m.points.size(); ++v) {
    if (m.points[v][0] == 1 && m.points[v][1] == 1) {
      EXPECT_EQ(after.points[v][0], 1);
      EXPECT_EQ(after.points[v][1], 1);
    }
  }
}

TEST(Features, AVertexSharedByTwoSheetsIsFixed) {
  // Cubes that share the middle vertex of a face alone: two closed fans at one vertex.
  const TetMesh m = two_cubes(2, {1, 0, 0}, [](const Point3& p) { return p[1] == 0.5 && p[2] == 0.5; });
  ASSERT_EQ(m.points.size(), 2U * 27 - 1);
  expect_dofs(classify_sliding(m, 180), 1, 0, 2 * 25, 2);
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
// Elements of other kinds with mid-side nodes beside curved tetrahedra.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "mesh/element_kinds.hpp"
#include "support/curved.hpp"
#include "tetune/curve.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// A curved ball with prisms of second order on some triangles of its surface, all of whose edges are curved.
TetMesh ball_with_prisms(int n) {
  TetMesh m = test::ball(n);
  curve(m, {});
  ElementBlock prisms{"Prisms", 6, {}, {}, {}, {}, true};
  std::vector<test::SkinFace> faces = test::skin(m);
  for (std::size_t f = 0; f < faces.size(); f += 7) {
    const Index first = to_index(m.points.size());
    for (const Index v : faces[f].v) prisms.element2vertex.push_back(v);
    for (std::size_t k = 0; k < 3; ++k) {
      const Point3 p = m.points[to_size_t(faces[f].v[k])];
      m.points.push_back({1.5 * p[0], 1.5 * p[1], 1.5 * p[2]});
      m.point_tags.push_back(0);
      prisms.element2vertex.push_back(first + to_index(k));
    }
    prisms.tags.push_back(5);
  }
  m.others = {prisms};
  std::vector<CurvedEdge> outside;
  for_each_other_middle(m, [&](Index a, Index b) {
    const auto edge = ascending(a, b);
    if (find_edge(m.curved_edges, edge) != nullptr) return;
    Point3 middle = midpoint(m.points[to_size_t(a)], m.points[to_size_t(b)]);
    middle[0] += 0.01;
    outside.push_back({edge, middle});
  });
  merge_edges(m.curved_edges, outside);
  return m;
}

/// The positions of the nodes of the elements of other kinds, in their order.
std::vector<Point3> nodes_of_others(const TetMesh& m) {
  std::vector<Point3> nodes;
  const CurvedEdges curved(m);
  for (const ElementBlock& block : m.others) {
    for (const Index v : block.element2vertex) nodes.push_back(m.points[to_size_t(v)]);
  }
  for_each_other_middle(m, [&](Index a, Index b) { nodes.push_back(to_point(curved.middle(a, b))); });
  return nodes;
}

TEST(CurvedOthers, KeepTheBitsOfAllTheirNodes) {
  const TetMesh before = ball_with_prisms(3);
  ASSERT_TRUE(validate(before).ok()) << validate(before).message(false);
  ASSERT_GE(before.others[0].tags.size(), 10U);
  for (const Boundary boundary : {Boundary::fixed, Boundary::preserve, Boundary::slide}) {
    for (const Effort effort : {Effort::standard, Effort::best}) {
      TetMesh m = before;
      Options options;
      options.boundary = boundary;
      options.effort = effort;
      optimize(m, options);
      ASSERT_TRUE(validate(m).ok()) << validate(m).message(false);
      EXPECT_TRUE(quality(m).curved.all_valid());
      EXPECT_LT(quality(m).shape_sum, quality(before).shape_sum);
      EXPECT_TRUE(nodes_of_others(m) == nodes_of_others(before));
    }
  }
}

TEST(CurvedOthers, AQuadrilateralInsideKeepsItsMidSideNodes) {
  // Its sides are edges of tetrahedra on both sides.
  TetMesh m = test::bulged_cube(0.05);
  const std::vector<test::SkinFace> faces = test::skin(m);
  std::vector<std::uint8_t> on_surface(m.points.size(), 0);
  for (const test::SkinFace& face : faces) {
    for (const Index v : face.v) on_surface[to_size_t(v)] = 1;
  }
  ElementBlock quads{"Quadrilaterals", 4, {}, {}, {}, {}, true};
  for (const auto& tet : m.tets) {
    const auto inside = std::count_if(tet.begin(), tet.end(), [&](Index v) { return on_surface[to_size_t(v)] == 0; });
    if (inside < 3 || !quads.tags.empty()) continue;
    quads.element2vertex.assign(tet.begin(), tet.end());
    quads.tags = {1};
  }
  ASSERT_EQ(quads.tags.size(), 1U);
  m.others = {quads};
  std::vector<CurvedEdge> bent;
  for_each_other_middle(m, [&](Index a, Index b) {
    Point3 middle = midpoint(m.points[to_size_t(a)], m.points[to_size_t(b)]);
    middle[2] += 1e-3;
    bent.push_back({ascending(a, b), middle});
  });
  merge_edges(m.curved_edges, bent);
  const TetMesh before = m;
  ASSERT_TRUE(quality(before).curved.all_valid());
  optimize(m, {});
  EXPECT_TRUE(validate(m).ok()) << validate(m).message(false);
  EXPECT_TRUE(quality(m).curved.all_valid());
  EXPECT_TRUE(nodes_of_others(m) == nodes_of_others(before));
}

TEST(CurvedOthers, TheirEdgesAreCurvedEdgesOfTheMesh) {
  TetMesh m = ball_with_prisms(2);
  m.others[0].second_order = false;
  EXPECT_FALSE(validate(m).ok());
  m.others[0].second_order = true;
  m.others[0].kind = "Unknown";
  EXPECT_FALSE(validate(m).ok());
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
// Nodes in the middles of edges of quadrilaterals, pyramids, prisms and hexahedra are read and written in the order of
// each format.
#include <algorithm>
#include <functional>
#include <utility>

#include "io_fixture.hpp"
#include "second_order_manuals.hpp"

namespace tetune::test {
namespace {

class SecondOrderNodes : public IoTest {
 protected:
  /// Reads an element of a format, in which the node of each edge in turn is beside the midpoint, and writes it again.
  void check(const Manual& manual, const Listing& edges, const std::function<Written(const Manual&, Ends)>& file) {
    const Written straight = file(manual, {-1, -1});
    SCOPED_TRACE(straight.name + " " + manual.kind);
    const TetMesh m = read_mesh(put(straight.name, straight.text), nullptr, 1);
    check_block(manual, m);
    EXPECT_TRUE(m.curved_edges.empty());
    for (const Ends& edge : edges) {
      if (edge[0] == edge[1]) continue;
      const Written bent = file(manual, edge);
      const TetMesh curved = read_mesh(put(bent.name, bent.text), nullptr, 1);
      check_block(manual, curved);
      ASSERT_EQ(curved.curved_edges.size(), 1U);
      const auto [a, b] = curved.curved_edges[0].vertices;
      std::vector<Point3> found{curved.points[std::size_t(a)], curved.points[std::size_t(b)]};
      std::vector<Point3> expected{vertex_at(edge[0]), vertex_at(edge[1])};
      std::sort(found.begin(), found.end());
      std::sort(expected.begin(), expected.end());
      EXPECT_EQ(found, expected);
      write_mesh(path("again_" + bent.name), curved, 1);
      const TetMesh again = read_mesh(path("again_" + bent.name), nullptr, 1);
      check_block(manual, again);
      EXPECT_EQ(again.curved_edges, curved.curved_edges);
    }
  }
  static void check_block(const Manual& manual, const TetMesh& m) {
    EXPECT_TRUE(m.second_order);
    ASSERT_EQ(m.others.size(), 1U);
    const ElementBlock& block = m.others[0];
    EXPECT_EQ(block.kind, manual.kind);
    EXPECT_TRUE(block.second_order);
    EXPECT_EQ(block.tags, std::vector<int>{7});
    ASSERT_EQ(block.element2vertex.size(), std::size_t(vertices_of(manual)));
    ASSERT_EQ(m.points.size(), block.element2vertex.size());
    for (int v = 0; v < vertices_of(manual); ++v) {
      EXPECT_EQ(m.points[std::size_t(block.element2vertex[std::size_t(v)])], vertex_at(v));
    }
  }
};

TEST_F(SecondOrderNodes, AreInTheOrderOfGmsh) {
  for (const Manual& m : manuals()) check(m, m.gmsh, in_msh);
}
TEST_F(SecondOrderNodes, AreInTheOrderOfAbaqusAndCalculiX) {
  for (const Manual& m : manuals()) {
    if (!m.inp_type.empty()) check(m, m.vertices_first, in_inp);
  }
}
TEST_F(SecondOrderNodes, AreInTheOrderOfNastran) {
  for (const Manual& m : manuals()) check(m, m.nastran, in_bdf);
}
TEST_F(SecondOrderNodes, AreInTheOrderOfIdeas) {
  for (const Manual& m : manuals()) check(m, m.unv, in_unv);
}

}  // namespace
}  // namespace tetune::test

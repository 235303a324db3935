// SPDX-License-Identifier: Apache-2.0
// Formats through VTK and Gmsh: second-order elements and their mid-side nodes.
#include "plugin_fixture.hpp"

namespace tetune::test {
namespace {

/// A tetrahedron of second order as Gmsh writes it; the node in the middle of the first edge at x.
std::string second_order_tet(const std::string& x) {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 " + x +
         " 0 0\n6 0.5 0.5 0\n7 0 0.5 0\n8 0 0 0.5\n9 0 0.5 0.5\n10 0.5 0 0.5\n$EndNodes\n$Elements\n1\n"
         "1 11 2 1 1 1 2 3 4 5 6 7 8 9 10\n$EndElements\n";
}

TEST_F(Plugins, SecondOrderIsRebuilt) {
  const TetMesh m = read_mesh(put("straight.msh", second_order_tet("0.5")), nullptr, 1);
  EXPECT_TRUE(m.second_order);
  EXPECT_EQ(m.points.size(), 4U);
  for (const std::string name : {"a.vtu", "a.msh", "a.e", "a.inp"}) {
    write_mesh(path(name), m, 1);
    const TetMesh back = read_mesh(path(name), nullptr, 1);
    EXPECT_TRUE(back.second_order);
    EXPECT_EQ(back.points, m.points);
    EXPECT_EQ(back.tets, m.tets);
  }
  const TetMesh curved = read_mesh(put("curved.msh", second_order_tet("0.6")), nullptr, 1);
  EXPECT_EQ(curved.curved_edges, (std::vector<CurvedEdge>{{{0, 1}, {0.6, 0, 0}}}));
  for (const std::string name : {"b.vtu", "b.msh", "b.e", "b.inp"}) {
    write_mesh(path(name), curved, 1);
    const TetMesh back = read_mesh(path(name), nullptr, 1);
    EXPECT_TRUE(back.second_order);
    EXPECT_EQ(back.tets, curved.tets);
    EXPECT_EQ(back.curved_edges, curved.curved_edges) << name;
  }
}

/// Replaces a run of 32-bit numbers, most significant byte first, which the file has once.
void replace_numbers(std::string& file, const std::vector<char>& before, const std::vector<char>& after) {
  const auto bytes = [](const std::vector<char>& numbers) {
    std::string text;
    for (const char n : numbers) text += std::string(3, '\0') + n;
    return text;
  };
  const std::size_t at = file.find(bytes(before));
  ASSERT_NE(at, std::string::npos);
  ASSERT_EQ(file.find(bytes(before), at + 1), std::string::npos);
  file.replace(at, 4 * before.size(), bytes(after));
}

TEST_F(Plugins, ElementsOfOtherKindsBehindMidSideNodesKeepTheirVertices) {
  TetMesh m;
  m.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {5, 0, 0}, {6, 0, 0}, {6, 1, 0}, {5, 1, 0}};
  m.point_tags.assign(8, 0);
  m.tets = {{0, 1, 2, 3}};
  m.tet_tags = {1};
  m.second_order = true;
  m.others = {{"Quadrilaterals", 4, {4, 5, 6, 7}, {2}, {}}};
  // The file has the mid-side nodes last: the quadrilateral changes places with four of them.
  write_mesh(path("a.e"), m, 1);
  std::string file = get("a.e");
  replace_numbers(file, {5, 6, 7, 8}, {10, 11, 13, 14});
  replace_numbers(file, {1, 2, 3, 4, 9, 12, 10, 11, 13, 14}, {1, 2, 3, 4, 9, 12, 5, 6, 7, 8});
  const TetMesh exodus = read_mesh(put("b.e", file), nullptr, 1);
  ASSERT_EQ(exodus.others.size(), 1U);
  EXPECT_EQ(exodus.others[0].element2vertex, (std::vector<Index>{4, 5, 6, 7}));
  EXPECT_EQ(exodus.points.size(), 8U);
  const TetMesh nastran = read_mesh(
      put("a.bdf",
          "GRID,1,,0.,0.,0.\nGRID,2,,.5,0.,0.\nGRID,3,,1.,0.,0.\nGRID,4,,.5,.5,0.\nGRID,5,,0.,1.,0.\nGRID,6,,0.,.5,0.\n"
          "GRID,7,,0.,0.,1.\nGRID,8,,0.,0.,.5\nGRID,9,,.5,0.,.5\nGRID,10,,0.,.5,.5\nGRID,11,,5.,0.,0.\n"
          "GRID,12,,6.,0.,0.\nGRID,13,,6.,1.,0.\nGRID,14,,5.,1.,0.\nCTETRA,1,1,1,3,5,7,2,4,+A\n+A,6,8,9,10\n"
          "CQUAD4,2,2,11,12,13,14\nENDDATA\n"),
      nullptr, 1);
  EXPECT_TRUE(nastran.second_order);
  ASSERT_EQ(nastran.others.size(), 1U);
  EXPECT_EQ(nastran.others[0].element2vertex, (std::vector<Index>{4, 5, 6, 7}));
  EXPECT_EQ(nastran.points, m.points);
}

TEST_F(Plugins, SetsOfNodesHoldMidSideNodesBetweenMembers) {
  TetMesh m = cube(2);
  m.second_order = true;
  std::vector<std::uint8_t> side;
  for (const Point3& p : m.points) side.push_back(p[0] == 0 ? 1 : 0);
  m.point_data = {{"node_set:4:left", 1, side}};
  write_mesh(path("a.e"), m, 1);
  // Reading warns of mid-side nodes that are members otherwise.
  std::vector<std::string> warnings;
  const TetMesh back = read_mesh(path("a.e"), &warnings, 1);
  EXPECT_TRUE(warnings.empty()) << warnings[0];
  ASSERT_EQ(back.point_data.size(), 1U);
  EXPECT_EQ(back.point_data[0].name, "node_set:4:left");
  EXPECT_EQ(std::get<std::vector<std::uint8_t>>(back.point_data[0].values), side);
}

}  // namespace
}  // namespace tetune::test

// SPDX-License-Identifier: Apache-2.0
// Quadrilaterals, pyramids, prisms and hexahedra with nodes in the middles of their edges, in the formats of the
// library.
#include <algorithm>

#include "io_fixture.hpp"
#include "second_order_manuals.hpp"

namespace tetune::test {
namespace {

class SecondOrderOthers : public IoTest {
 protected:
  /// Reads a deck, and expects the same text where it is written again.
  TetMesh read_and_write(const std::string& deck) {
    const TetMesh m = read_mesh(put("a.inp", deck), nullptr, 1);
    write_mesh(path("b.inp"), m, 1);
    EXPECT_EQ(get("b.inp"), deck);
    return m;
  }
};

/// A tetrahedron of second order beside a prism and a hexahedron of either order.
TetMesh mixed() {
  TetMesh m;
  for (int v = 0; v < 18; ++v) m.points.push_back(vertex_at(v));
  m.point_tags.assign(18, 0);
  m.tets = {{0, 2, 1, 3}};
  m.tet_tags = {3};
  m.second_order = true;
  m.others = {{"Prisms", 6, {4, 5, 6, 7, 8, 9}, {4}, {}, {}, true},
              {"Hexahedra", 8, {0, 1, 2, 3, 10, 11, 12, 13}, {5}, {}},
              {"Hexahedra", 8, {10, 11, 12, 13, 14, 15, 16, 17}, {6}, {}, {}, true}};
  return m;
}

TEST_F(SecondOrderOthers, ElementsOfBothOrdersComeBackAsTheyWere) {
  TetMesh m = mixed();
  m.curved_edges = {{{0, 2}, {1, 1, 1}}, {{4, 7}, {2, 2, 2}}, {{10, 14}, {3, 3, 3}}};
  for (const std::string name : {"a.msh", "a.inp", "a.bdf", "a.unv"}) {
    SCOPED_TRACE(name);
    write_mesh(path(name), m, 1);
    const TetMesh back = read_mesh(path(name), nullptr, 1);
    EXPECT_EQ(back.points, m.points);
    EXPECT_EQ(back.tets, m.tets);
    EXPECT_EQ(back.curved_edges, m.curved_edges);
    ASSERT_EQ(back.others.size(), m.others.size());
    for (const ElementBlock& block : m.others) {
      const auto same = std::find_if(back.others.begin(), back.others.end(), [&block](const ElementBlock& b) {
        return b.kind == block.kind && b.second_order == block.second_order;
      });
      ASSERT_NE(same, back.others.end());
      EXPECT_EQ(same->element2vertex, block.element2vertex);
      EXPECT_EQ(same->tags, block.tags);
    }
  }
}

TEST_F(SecondOrderOthers, FormatsOfFirstOrderListTheVerticesWithAWarning) {
  for (const std::string name : {"a.mesh", "a.meshb", "a.su2"}) {
    std::vector<std::string> warnings;
    write_mesh(path(name), mixed(), 1, &warnings);
    EXPECT_TRUE(contains(warnings, "written as linear elements")) << name;
    const TetMesh back = read_mesh(path(name), nullptr, 1);
    EXPECT_FALSE(back.second_order);
    std::size_t hexahedra = 0;
    for (const ElementBlock& block : back.others) hexahedra += block.kind == "Hexahedra" ? block.tags.size() : 0;
    EXPECT_EQ(hexahedra, 2U) << name;
  }
}

TEST_F(SecondOrderOthers, FormatsWithoutTheElementsRefuseThem) {
  TetMesh m = mixed();
  EXPECT_TRUE(contains(write_error(path("a.vol"), m), "Prisms with mid-side nodes are not written to Netgen's files"));
  m.others = {{"Pyramids", 5, {0, 1, 2, 3, 4}, {1}, {}, {}, true}};
  EXPECT_TRUE(contains(write_error(path("a.inp"), m), "neither Abaqus nor CalculiX has Pyramids with mid-side nodes"));
}

TEST_F(SecondOrderOthers, NodesInTheMiddlesOfFacesAreRefusedWithAdvice) {
  const std::string head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n$Elements\n1\n";
  for (const std::string type : {"10", "12", "13", "14"}) {
    const std::string error = read_error(put("a.msh", head + "1 " + type + " 2 1 1 1\n$EndElements\n"));
    EXPECT_TRUE(contains(error, "a.msh:10: element 1 is of type " + type)) << error;
    EXPECT_TRUE(contains(error, "Mesh.SecondOrderIncomplete = 1")) << error;
  }
  const std::string unv =
      "    -1\n  2411\n1 1 1 11\n0 0 0\n    -1\n    -1\n  2412\n1 95 1 1 7 9\n1 1 1 1 1 1 1 1\n1\n    -1\n";
  const std::string error = read_error(put("a.unv", unv));
  EXPECT_TRUE(contains(error, "should have 4 or 8 nodes, and has 9")) << error;
  EXPECT_TRUE(contains(error, "elements with nodes in the middles of faces are not read")) << error;
}

TEST_F(SecondOrderOthers, LinearTetrahedraBesideThemAreRefused) {
  TetMesh m = mixed();
  write_mesh(path("a.bdf"), m, 1);
  std::string text = get("a.bdf");
  // The nodes of the tetrahedron in the middles of edges are on a line of their own but for two.
  const std::size_t tet = text.find("CTETRA");
  ASSERT_NE(tet, std::string::npos);
  const std::size_t first_line = text.find('\n', tet), second_line = text.find('\n', first_line + 1);
  text.erase(first_line, second_line - first_line);
  text.erase(tet + 56, first_line - tet - 56);
  const std::string error = read_error(put("b.bdf", text));
  EXPECT_TRUE(contains(error, "the tetrahedra are of first order, but the 1 Prisms have mid-side nodes")) << error;
}

TEST_F(SecondOrderOthers, SimplicesWithoutMidSideNodesGetThemWithAWarning) {
  const std::string text =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n11\n1 0 0 0\n2 2 0 0\n3 0 2 0\n4 0 0 2\n5 1 0 0\n6 1 1 0\n"
      "7 0 1 0\n8 0 0 1\n9 0 1 1\n10 1 0 1\n11 1 -2 0\n$EndNodes\n$Elements\n3\n"
      "1 11 2 1 1 1 2 3 4 5 6 7 8 9 10\n2 2 2 2 1 1 2 11\n3 2 2 2 1 1 2 3\n$EndElements\n";
  std::vector<std::string> warnings;
  const TetMesh m = read_mesh(put("a.msh", text), &warnings, 1);
  EXPECT_EQ(m.points.size(), 5U);
  ASSERT_EQ(warnings.size(), 1U);
  // Also the one whose edges have the nodes of the tetrahedron.
  EXPECT_TRUE(contains(warnings[0], "as other elements have them: 2 of the triangles")) << warnings[0];
  warnings.clear();
  write_mesh(path("b.msh"), m, 1);
  read_mesh(path("b.msh"), &warnings, 1);
  EXPECT_EQ(warnings, std::vector<std::string>());
}

TEST_F(SecondOrderOthers, ATetrahedronBetweenMidSideNodesOfOthersIsCounted) {
  std::string text =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n1 0 0 0\n2 2 0 0\n3 0 2 0\n4 0 0 2\n5 1 0 0\n6 1 1 0\n"
      "7 0 1 0\n8 0 0 1\n9 0 1 1\n10 1 0 1\n$EndNodes\n$Elements\n8\n1 4 2 1 1 1 2 3 4\n";
  const std::vector<std::string> edges{"1 2 5", "2 3 6", "3 1 7", "1 4 8", "3 4 9", "2 4 10"};
  for (std::size_t e = 0; e < edges.size(); ++e) text += std::to_string(e + 2) + " 8 2 1 1 " + edges[e] + "\n";
  // An element that version 2.2 lists for two groups is one.
  text += "8 8 2 2 1 1 2 5\n$EndElements\n";
  std::vector<std::string> warnings;
  const TetMesh m = read_mesh(put("a.msh", text), &warnings, 1);
  EXPECT_TRUE(m.second_order);
  EXPECT_EQ(m.edges.size(), 6U);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(warnings[0].ends_with("as other elements have them: 1 of the tetrahedra")) << warnings[0];
}

TEST_F(SecondOrderOthers, CurvedEdgesOfNoOtherElementAreNamedWhereTheyBecomeStraight) {
  TetMesh m = one_tet();
  m.points.insert(m.points.end(), {{2, 0, 0}, {3, 0, 0}});
  m.point_tags.assign(6, 0);
  m.edges = {{4, 5}};
  m.edge_tags = {1};
  m.second_order = true;
  m.curved_edges = {{{4, 5}, {2.5, 0.5, 0}}};
  for (const std::string name : {"a.bdf", "a.vol"}) {
    std::vector<std::string> warnings;
    write_mesh(path(name), m, 1, &warnings);
    EXPECT_TRUE(contains(warnings, "1 curved edges of no other element are straight")) << name;
    EXPECT_EQ(read_mesh(path(name), nullptr, 1).points, m.points) << name;
  }
  // A deck has neither such edges nor their mid-side nodes.
  write_mesh(path("a.inp"), m, 1);
  EXPECT_EQ(read_mesh(path("a.inp"), nullptr, 1).points, m.points);
}

TEST_F(SecondOrderOthers, NastranElementsHaveAllMidSideNodesOrNone) {
  Written file = in_bdf(manuals()[2], {-1, -1});
  const std::size_t last = file.text.rfind(",15");
  file.text.erase(last, 3);
  const std::string error = read_error(put(file.name, file.text));
  EXPECT_TRUE(contains(error, "CPENTA lacks some of its 9 mid-side nodes")) << error;
}

// Decks keep elements that the mesh cannot have as second-order ones, with their nodes held.

std::string deck_of_hexahedron(const std::string& more) { return in_inp(manuals()[3], {-1, -1}).text + more; }

TEST_F(SecondOrderOthers, DecksKeepTypesAndText) {
  std::string text = deck_of_hexahedron("*NODE\n31, 0, 0, 9\n*ELEMENT, TYPE=S8RT\n2, 1, 2, 3, 4, 9, 10, 11, 12\n");
  text.replace(text.find("C3D20"), 5, "C3D20R");
  const TetMesh m = read_and_write(text);
  EXPECT_EQ(m.others.size(), 2U);
  EXPECT_EQ(m.points.size(), 9U);
}

TEST_F(SecondOrderOthers, InDecksOfLinearTetrahedraTheirNodesAreHeld) {
  const std::string text = deck_of_hexahedron("*NODE\n31, 0, 0, 9\n*ELEMENT, TYPE=C3D4\n2, 1, 2, 3, 31\n");
  const TetMesh m = read_and_write(text);
  EXPECT_FALSE(m.second_order);
  EXPECT_TRUE(m.others.empty());
  EXPECT_EQ(m.points.size(), 21U);
  EXPECT_EQ(m.required_vertices.size(), 20U);
}

TEST_F(SecondOrderOthers, InDecksElementsWithAMidSideNodeThatIsAVertexAreHeld) {
  const std::string text = deck_of_hexahedron("*ELEMENT, TYPE=B31\n2, 9, 10\n");
  const TetMesh m = read_and_write(text);
  EXPECT_FALSE(m.second_order);
  EXPECT_TRUE(m.others.empty());
  EXPECT_EQ(m.required_vertices.size(), 20U);
  std::vector<std::string> warnings;
  write_mesh(path("c.msh"), m, 1, &warnings);
  EXPECT_TRUE(contains(warnings, "nor its elements of other types (1)"));
}

TEST_F(SecondOrderOthers, InDecksElementsWithAVertexTwiceAreHeld) {
  std::string text = deck_of_hexahedron("");
  const std::string vertices = "\n1, 1, 2,";
  text.replace(text.find(vertices), vertices.size(), "\n1, 1, 1,");
  const TetMesh m = read_and_write(text);
  EXPECT_TRUE(m.others.empty());
}

TEST_F(SecondOrderOthers, SetsInDecksKeepTheirMidSideNodes) {
  const std::string text =
      deck_of_hexahedron("*NSET, NSET=some\n9, 13, 20\n*CLOAD\n10, 1, 3.0\nsome, 2, 1.0\n*BOUNDARY\nsome, 1\n");
  const TetMesh m = read_and_write(text);
  EXPECT_EQ(m.others.size(), 1U);
  EXPECT_TRUE(m.edges.empty());
}

}  // namespace
}  // namespace tetune::test

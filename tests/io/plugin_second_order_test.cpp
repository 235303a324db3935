// SPDX-License-Identifier: Apache-2.0
// Formats through VTK and Gmsh: second-order elements and their mid-side nodes.
#include "io/second_order.hpp"
#include "math/vec3.hpp"
#include "mesh/tet.hpp"
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

/// A cell alone in a file of VTK, with a node beside the midpoint of the edge `bent` of its list.
std::string cell_in_vtk(int type, std::size_t vertices, const std::vector<std::array<std::size_t, 2>>& edges,
                        std::size_t bent) {
  std::vector<Point3> points;
  for (std::size_t v = 0; v < vertices; ++v) {
    points.push_back({double(v) + 0.25 * double(v * v), double(v % 3), double(v % 2) + 0.5 * double(v)});
  }
  for (std::size_t e = 0; e < edges.size(); ++e) {
    points.push_back(tetune::midpoint(points[edges[e][0]], points[edges[e][1]]));
    if (e == bent) points.back()[2] += 0.5;
  }
  const std::string n = std::to_string(points.size());
  std::string text = "# vtk DataFile Version 2.0\na cell\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS " + n + " double\n";
  for (const Point3& p : points) {
    text += std::to_string(p[0]) + " " + std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
  }
  text += "CELLS 1 " + std::to_string(points.size() + 1) + "\n" + n;
  for (std::size_t i = 0; i < points.size(); ++i) text += " " + std::to_string(i);
  return text + "\nCELL_TYPES 1\n" + std::to_string(type) + "\n";
}

TEST_F(Plugins, OtherCellsOfSecondOrderHaveTheirNodesInTheOrderOfVtk) {
  struct Cell {
    int type;
    std::string kind;
    std::size_t vertices;
    std::vector<std::array<std::size_t, 2>> edges;
  };
  const std::vector<Cell> cells{
      {23, "Quadrilaterals", 4, {{0, 1}, {1, 2}, {2, 3}, {3, 0}}},
      {27, "Pyramids", 5, {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}}},
      {26, "Prisms", 6, {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}}},
      {25,
       "Hexahedra",
       8,
       {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}}};
  for (const Cell& cell : cells) {
    SCOPED_TRACE(cell.kind);
    for (std::size_t bent = 0; bent < cell.edges.size(); ++bent) {
      const std::string text = cell_in_vtk(cell.type, cell.vertices, cell.edges, bent);
      TetMesh m = read_mesh(put("a.vtk", text), nullptr, 1);
      ASSERT_EQ(m.others.size(), 1U);
      EXPECT_EQ(m.others[0].kind, cell.kind);
      EXPECT_TRUE(m.others[0].second_order);
      ASSERT_EQ(m.points.size(), cell.vertices);
      ASSERT_EQ(m.curved_edges.size(), 1U);
      const auto ends = ascending(Index(cell.edges[bent][0]), Index(cell.edges[bent][1]));
      EXPECT_EQ(m.curved_edges[0].vertices, ends);
      if (bent > 0) continue;
      if (cell.type == 23) m.others[0].required = {0};
      m.others[0].tags = {7};
      for (const std::string name : {"a.vtu", "b.vtk", "a.e"}) {
        write_mesh(path(name), m, 1);
        const TetMesh back = read_mesh(path(name), nullptr, 1);
        EXPECT_EQ(back.points, m.points);
        EXPECT_EQ(back.curved_edges, m.curved_edges);
        ASSERT_EQ(back.others.size(), 1U);
        EXPECT_TRUE(back.others[0].second_order);
        EXPECT_EQ(back.others[0].element2vertex, m.others[0].element2vertex);
        EXPECT_EQ(back.others[0].tags, m.others[0].tags);
        EXPECT_EQ(back.others[0].required, name == "a.e" ? std::vector<Index>() : m.others[0].required);
      }
    }
  }
  const std::string error = read_error(put("a.vtk", cell_in_vtk(28, 9, {}, 9)));
  EXPECT_TRUE(contains(error, "cell 0 is of VTK's type 28")) << error;
  EXPECT_TRUE(contains(error, "elements with nodes in the middles of faces are not read")) << error;
}

TEST_F(Plugins, QuadrilateralsOfBothOrdersKeepTheirLists) {
  TetMesh m = cube(2);
  m.second_order = true;
  m.others = {{"Quadrilaterals", 4, {0, 1, 4, 3, 1, 2, 5, 4}, {1, 2}, {1}},
              {"Quadrilaterals", 4, {9, 10, 13, 12, 10, 11, 14, 13}, {3, 4}, {0}, {}, true}};
  write_mesh(path("a.vtu"), m, 1);
  const TetMesh back = read_mesh(path("a.vtu"), nullptr, 1);
  ASSERT_EQ(back.others.size(), 2U);
  for (std::size_t b = 0; b < 2; ++b) {
    EXPECT_EQ(back.others[b].element2vertex, m.others[b].element2vertex);
    EXPECT_EQ(back.others[b].tags, m.others[b].tags);
    EXPECT_EQ(back.others[b].required, m.others[b].required);
    EXPECT_EQ(back.others[b].second_order, m.others[b].second_order);
  }
}

TEST_F(Plugins, SetsOfTheSurfaceHoldNoMidSideNodesInside) {
  // Three tetrahedra around the edge between the first and the last vertex.
  TetMesh m;
  m.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  m.point_tags.assign(5, 0);
  m.tets = {{0, 1, 2, 4}, {0, 2, 3, 4}, {0, 3, 1, 4}};
  m.tet_tags.assign(3, 1);
  m.second_order = true;
  const auto set = [](std::vector<std::uint8_t> members) { return DataArray{"node_set:1:s", 1, std::move(members)}; };
  for (const auto& [members, has_middle] :
       {std::pair{std::vector<std::uint8_t>{1, 1, 1, 1, 1}, true}, {{1, 1, 0, 1, 1}, false}}) {
    m.point_data = {set(members)};
    TetMesh with_middles = m;
    const Middles middles(with_middles);
    const auto& values = std::get<std::vector<std::uint8_t>>(with_middles.point_data[0].values);
    EXPECT_EQ(values[std::size_t(middles.of(0, 4))], has_middle ? 1 : 0);
    EXPECT_EQ(values[std::size_t(middles.of(0, 1))], 1);
    std::vector<std::string> warnings;
    write_mesh(path("a.e"), m, 1);
    read_mesh(path("a.e"), &warnings, 1);
    EXPECT_TRUE(warnings.empty()) << warnings[0];
  }
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

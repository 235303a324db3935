// SPDX-License-Identifier: Apache-2.0
// Universal files of I-deas as they are read.
#include "io/plain_text.hpp"
#include "mesh_contents.hpp"
#include "unv_fixture.hpp"

namespace tetune::test {
namespace {

/// The lines of an element of 2412 with its nodes.
std::string element(int number, int descriptor, int property, const std::vector<int>& nodes,
                    const std::string& beam = "") {
  const auto columns = [](int value) {
    const std::string digits = std::to_string(value);
    return std::string(10 - digits.size(), ' ') + digits;
  };
  std::string text = columns(number) + columns(descriptor) + columns(property) + columns(1) + columns(7) +
                     columns(int(nodes.size())) + "\n" + beam;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    text += columns(nodes[k]);
    if ((k + 1) % 8 == 0 || k + 1 == nodes.size()) text += '\n';
  }
  return text;
}

/// The lines of a group of 2467: kinds and numbers.
std::string group(int number, const std::string& name, const std::vector<std::pair<int, int>>& entities) {
  std::string text = std::to_string(number) + " 0 0 0 0 0 0 " + std::to_string(entities.size()) + "\n" + name + "\n";
  for (std::size_t k = 0; k < entities.size(); ++k) {
    text += "         " + std::to_string(entities[k].first) + " " + std::to_string(entities[k].second) + " 0 0";
    if (k % 2 == 1 || k + 1 == entities.size()) text += '\n';
  }
  return text;
}

std::vector<std::uint8_t> set_of(const TetMesh& mesh, const std::string& name) {
  for (const DataArray& array : mesh.point_data) {
    if (array.name == name) return std::get<std::vector<std::uint8_t>>(array.values);
  }
  return {};
}

const Group* named(const TetMesh& mesh, const std::string& name, int dimension = 3) {
  const auto at = std::find_if(mesh.groups.begin(), mesh.groups.end(),
                               [&](const Group& g) { return g.name == name && g.dimension == dimension; });
  return at == mesh.groups.end() ? nullptr : &*at;
}

TEST_F(Unv, NodesOfAllDataSets) {
  const TetMesh m = read(kUnvNodes + unv_set("2412", kUnvTet));
  EXPECT_TRUE(warnings_.empty()) << warnings_[0];
  EXPECT_EQ(m.points, one_tet().points);
  EXPECT_EQ(m.tets, (std::vector<std::array<Index, 4>>{{0, 1, 2, 3}}));
  EXPECT_EQ(m.tet_tags, std::vector<int>{7});
  EXPECT_EQ(m.deck_nodes, (std::vector<std::int64_t>{1, 2, 3, 4}));
  const TetMesh old = read(unv_set("781", kUnvTetNodes) +
                           unv_set("780", "1 111 1 7 1 1 7 4\n1 2 3 4\n2 21 1 9 1 1 7 2\n0 1 1 1 1\n1 2\n"));
  EXPECT_EQ(old.points, m.points);
  EXPECT_EQ(old.tet_tags, m.tet_tags);
  EXPECT_EQ(old.edge_tags, std::vector<int>{9});
  const TetMesh single =
      read(unv_set("15",
                   "         1         0         0         0  0.00000E+00  0.00000E+00  0.00000E+00\n"
                   "         2         0         0         0  1.00000E+00-0.00000E+00 -0.00000E+00\n"
                   "         3         0         0         0  0.00000E+00  1.00000E+00  0.00000E+00\n"
                   "         4         0         0         0  0.00000E+00  0.00000E+00  1.00000E+00\n") +
           unv_set("2412", kUnvTet));
  EXPECT_EQ(single.points, m.points);
}

TEST_F(Unv, NumbersThatTouchAreColumns) {
  const TetMesh m = read(kUnvNodes + unv_set("2412",
                                             "         1       1112147483647         1         7         4\n"
                                             "         1         2         3         4\n"));
  EXPECT_EQ(m.tet_tags, std::vector<int>{2147483647});
}

TEST_F(Unv, EveryKindOfElement) {
  std::string nodes;
  for (int i = 1; i <= 8; ++i) {
    nodes += std::to_string(10 * i) + " 1 1 11\n" + std::to_string(i & 1) + " " + std::to_string(i / 2 % 2) + " " +
             std::to_string(i / 4) + "\n";
  }
  const std::string beam = "         0         1         1\n";
  std::string lines;
  int number = 0;
  for (const int descriptor : {11, 21, 22, 24}) lines += element(++number, descriptor, 1, {10, 20}, beam);
  lines += element(++number, 21, 1, {20, 30});  // without the line of a beam
  for (const int descriptor : {41, 51, 61, 74, 81, 91}) lines += element(++number, descriptor, 2, {10, 20, 30});
  for (const int descriptor : {44, 54, 64, 71, 84, 94}) lines += element(++number, descriptor, 3, {10, 20, 40, 30});
  lines += element(++number, 111, 4, {10, 20, 30, 40});
  lines += element(++number, 312, 5, {10, 20, 30, 40, 50});
  lines += element(++number, 112, 6, {10, 20, 30, 40, 50, 60});
  lines += element(++number, 115, 7, {10, 20, 30, 40, 50, 60, 70, 80});
  lines += element(++number, 136, 8, {10, 20});
  lines += element(++number, 161, 8, {10});
  const TetMesh m = read(unv_set("2411", nodes) + unv_set("2412", lines));
  EXPECT_EQ(m.edges.size(), 5U);
  EXPECT_EQ(m.edges[4], (std::array<Index, 2>{1, 2}));
  EXPECT_EQ(m.triangle_tags, std::vector<int>(6, 2));
  EXPECT_TRUE(m.listed_inside_out);
  EXPECT_EQ(m.tets, (std::vector<std::array<Index, 4>>{{0, 1, 3, 2}}));
  ASSERT_EQ(m.others.size(), 4U);
  EXPECT_EQ(m.others[0].kind, "Quadrilaterals");
  EXPECT_EQ(m.others[0].tags, std::vector<int>(6, 3));
  EXPECT_EQ(m.others[1].kind, "Pyramids");
  EXPECT_EQ(m.others[2].kind, "Prisms");
  EXPECT_EQ(m.others[3].kind, "Hexahedra");
  EXPECT_EQ(m.others[3].element2vertex, (std::vector<Index>{0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(m.deck_nodes.front(), 10);
  EXPECT_TRUE(warned("2 elements with the FE descriptors 136, 161 are not kept"));
}

TEST_F(Unv, MidSideNodesFollowTheVertexBefore) {
  const auto node = [](int number, double x, double y, double z) {
    return std::to_string(number) + " 1 1 11\n" + std::to_string(x) + " " + std::to_string(y) + " " +
           std::to_string(z) + "\n";
  };
  // Vertices 1, 3, 5, 10; the node of the first edge is off the midpoint.
  const std::string nodes = node(1, 0, 0, 0) + node(2, .6, 0, 0) + node(3, 1, 0, 0) + node(4, .5, .5, 0) +
                            node(5, 0, 1, 0) + node(6, 0, .5, 0) + node(7, 0, 0, .5) + node(8, .5, 0, .5) +
                            node(9, 0, .5, .5) + node(10, 0, 0, 1);
  const TetMesh m =
      read(unv_set("2411", nodes) +
           unv_set("2412", element(1, 118, 1, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}) + element(2, 92, 2, {1, 2, 3, 4, 5, 6}) +
                               element(3, 24, 3, {1, 2, 3}, "         0         1         1\n") +
                               element(4, 22, 3, {3, 4, 5})));
  EXPECT_TRUE(m.second_order);
  EXPECT_EQ(m.points.size(), 4U);
  EXPECT_EQ(m.tets, (std::vector<std::array<Index, 4>>{{0, 1, 2, 3}}));
  EXPECT_EQ(m.triangles, (std::vector<std::array<Index, 3>>{{0, 1, 2}}));
  EXPECT_EQ(m.edges, (std::vector<std::array<Index, 2>>{{0, 1}, {1, 2}}));
  ASSERT_EQ(m.curved_edges.size(), 1U);  // so that all others are at midpoints
  EXPECT_EQ(m.curved_edges[0].vertices, (std::array<Index, 2>{0, 1}));
  EXPECT_EQ(m.curved_edges[0].middle, (Point3{.6, 0, 0}));
  EXPECT_EQ(m.deck_nodes, (std::vector<std::int64_t>{1, 3, 5, 10}));
  const std::string text = unv_set("2411", nodes + node(200, .6, 0, 0)) +
                           unv_set("2412", element(1, 118, 1, {1, 200, 3, 4, 5, 6, 7, 8, 200, 10}));
  EXPECT_NE(error(text).find("a.unv: node 200 is a mid-side node of two edges"), std::string::npos) << error(text);
}

TEST_F(Unv, GroupsOfElementsAndNodes) {
  const std::string elements = kUnvTet + element(2, 91, 8, {1, 2, 3}) + element(3, 91, 8, {1, 2, 4});
  for (const std::string number : {"2467", "2477", "2452", "2435"}) {
    const TetMesh m =
        read(kUnvNodes + unv_set("2412", elements) +
             unv_set(number, group(3, "hot wall ", {{8, 2}, {8, 3}}) + group(4, "part 1", {{8, 1}, {7, 2}, {7, 4}})));
    EXPECT_TRUE(warnings_.empty()) << warnings_[0];
    ASSERT_EQ(m.groups.size(), 2U);
    ASSERT_NE(named(m, "hot wall", 2), nullptr);
    EXPECT_EQ(named(m, "hot wall", 2)->number, 3);
    EXPECT_EQ(named(m, "hot wall", 2)->tags, std::vector<int>{8});
    ASSERT_NE(named(m, "part 1"), nullptr);
    EXPECT_EQ(named(m, "part 1")->tags, std::vector<int>{7});
    EXPECT_EQ(set_of(m, "node_set:4:part 1"), (std::vector<std::uint8_t>{0, 1, 0, 1}));
  }
  const TetMesh pairs =
      read(kUnvNodes + unv_set("2412", elements) + unv_set("2430", "1 0 0 0 0 0 0 3\nwall\n8 2 8 3\n7 1\n"));
  EXPECT_EQ(named(pairs, "wall", 2)->tags, std::vector<int>{8});
  EXPECT_EQ(set_of(pairs, "node_set:1:wall"), (std::vector<std::uint8_t>{1, 0, 0, 0}));
}

TEST_F(Unv, WhereAllPropertiesAreEqualTheGroupsAreTheTags) {
  // As Salome writes it.
  std::string elements;
  for (int i = 1; i <= 5; ++i) elements += element(i, 41, 2, {1, 2, 3 + i % 2});
  const TetMesh m = read(kUnvNodes + unv_set("2412", elements) +
                         unv_set("2467", group(1, "inlet", {{8, 1}}) + group(2, "outlet", {{8, 2}}) +
                                             group(9, "both", {{8, 3}}) + group(6, "both again", {{8, 3}, {8, 4}})));
  EXPECT_EQ(m.triangle_tags[0], 1);
  EXPECT_EQ(m.triangle_tags[1], 2);
  EXPECT_EQ(m.triangle_tags[3], 6);
  EXPECT_EQ(distinct(m.triangle_tags).size(), 5U);
  EXPECT_EQ(named(m, "both", 2)->tags, std::vector<int>{m.triangle_tags[2]});
  EXPECT_EQ(named(m, "both again", 2)->tags.size(), 2U);
  EXPECT_FALSE(warned("property"));
  // With other properties they are a loss.
  read(kUnvNodes + unv_set("2412", elements + element(6, 41, 5, {1, 3, 4})) + unv_set("2467", group(1, "a", {{8, 1}})));
  EXPECT_TRUE(warned("elements with one property number are in different groups: 1 of these"));
}

TEST_F(Unv, GroupsThatDoNotFitAreNamed) {
  read(kUnvNodes + unv_set("2412", kUnvTet) +
       unv_set("2467",
               group(1, "empty", {}) + group(2, "away", {{8, 9}, {7, 9}}) + group(3, "other", {{3, 1}, {8, 1}})));
  EXPECT_TRUE(warned("the group \"empty\" has no nodes and elements"));
  EXPECT_TRUE(warned("2 entities of groups are nodes or elements that the mesh does not have"));
  EXPECT_TRUE(warned("1 entities of groups are neither nodes nor elements"));
}

TEST_F(Unv, FilesOfGmsh) {
  // Groups of several dimensions with one number, as Gmsh 4.8 writes them: two volumes, the second in two groups.
  const TetMesh m = read(
      unv_set("2411", kUnvTetNodes + "         5         1         1        11\n"
                                     "   1.0000000000000000D+00   1.0000000000000000D+00   1.0000000000000000D+00\n") +
      unv_set("2412",
              "         2        21         1         0         7         2\n"
              "         0         0         0\n"
              "         1         2\n"
              "         3        91         1         0         7         3\n"
              "         1         3         2\n"
              "         4       111         1         0         7         4\n"
              "         1         2         3         4\n"
              "         5       111         2         0         7         4\n"
              "         2         3         4         5\n") +
      unv_set("2477",
              "         1         0         0         0         0         0         0         1\n"
              "wall_a\n"
              "         8         3         0         0\n"
              "         1         0         0         0         0         0         0         2\n"
              "all\n"
              "         8         4         0         0         8         5         0         0\n"
              "         5         0         0         0         0         0         0         1\n"
              "right\n"
              "         8         5         0         0\n"));
  EXPECT_EQ(m.tet_tags, (std::vector<int>{1, 2}));
  EXPECT_EQ(named(m, "all")->tags, (std::vector<int>{1, 2}));
  EXPECT_EQ(named(m, "all")->number, 1);
  EXPECT_EQ(named(m, "right")->tags, std::vector<int>{2});
  EXPECT_EQ(named(m, "wall_a", 2)->tags, std::vector<int>{1});
  EXPECT_EQ(named(m, "wall_a", 2)->number, 1);
  // Gmsh reads groups in this data set alone.
  write_mesh(path("b.unv"), m, 1);
  EXPECT_TRUE(contains(get("b.unv"), "    -1\n  2477\n"));
  EXPECT_FALSE(contains(get("b.unv"), "   164\n"));
}

TEST_F(Unv, ATruncationWithinADataSetIsNoticed) {
  const std::string elements = unv_set("2412", kUnvTet);
  const std::string whole = kUnvNodes + elements + unv_set("2467", group(4, "part", {{8, 1}}));
  std::vector<std::size_t> between;
  const std::size_t end = kUnvNodes.size() + elements.size();
  // From before the end of the line to the blanks of the next data set, which is not needed.
  for (std::size_t n = end - 1; n <= end + 4; ++n) between.push_back(n);
  between.push_back(whole.size() - 1);
  EXPECT_EQ(silent_cuts("a.unv", whole), between);
  read(kUnvNodes);
  EXPECT_TRUE(warned("it has nodes and no elements (data set 2412); the file may be cut short after line 1"));
}

TEST_F(Unv, DataSetsThatAreNotReadAreNamed) {
  const std::string results = unv_set("2414", "         1\nRESULTS\n        -1\n         2\n");
  read(unv_set("151", "model\n\n") + kUnvNodes + results + unv_set("2412", kUnvTet) + results);
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_TRUE(warned("the data sets 151 (header), 2414 (results) are not kept"));
  const std::string mesh = kUnvNodes + unv_set("2412", kUnvTet);
  read(mesh + results.substr(0, results.size() - 20));
  EXPECT_TRUE(warned("may be cut short"));
  read(mesh + "    -1\n");
  EXPECT_TRUE(warned("may be cut short"));
  read(kUnvNodes + unv_set("2412", element(1, 21, 1, {1, 2}, "         4         3         3\n")));
  EXPECT_TRUE(warned("the orientations and cross sections of 1 beams are not kept"));
  read(kUnvNodes +
       unv_set("2412", kUnvTet + "         3       111         7         2         7         4\n1 2 3 4\n"));
  EXPECT_TRUE(warned("the numbers of materials of elements are not kept"));
  EXPECT_TRUE(warned("the elements are not numbered from 1 to 2"));
}

TEST_F(Unv, CoordinateSystems) {
  const auto systems = [](const std::string& kind, const std::string& row) {
    return unv_set("2420", "1\npart\n1 " + kind + " 0\nfirst\n" + row + "\n0. 1. 0.\n0. 0. 1.\n0. 0. 0.\n");
  };
  const std::string elements = unv_set("2412", kUnvTet);
  read(systems("0", "1. 0. 0.") + kUnvNodes + elements);
  EXPECT_TRUE(warnings_.empty()) << warnings_[0];
  read(systems("1", "1. 0. 0.") + kUnvNodes + elements);
  EXPECT_TRUE(warned("4 nodes name coordinate systems (1) that are not the global Cartesian one"));
  read(systems("0", "1.D0 1. 0.") + kUnvNodes + elements);
  EXPECT_TRUE(warned("4 nodes name coordinate systems (1)"));
  const std::string refused = error(systems("1", "1. 0. 0.") + unv_set("781", kUnvTetNodes) + elements);
  EXPECT_TRUE(contains(refused, "a.unv:14: the coordinates of this node are in the coordinate system 1")) << refused;
}

TEST_F(Unv, DamagedFilesAreRefusedWithTheLine) {
  const std::string tet = unv_set("2412", kUnvTet);
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {"$MeshFormat\n", "a.unv:1: this line should be -1, the start of a data set"},
           {"", "a.unv:0: the file ends without nodes"},
           {unv_set("2412", ""), "the file ends without nodes"},
           {kUnvNodes + "    -1\n  2412\n" + kUnvTet,
            "it ends within the data set 2412, before the -1 after its lines"},
           {kUnvNodes + "    -1\n  2412\n         1       11", "it ends within the data set 2412"},
           {"    -1\n  2411\n" + kUnvTetNodes.substr(0, 90), "it ends within the data set 2411"},
           {kUnvNodes + unv_set("2412", "1 111 x 1 7 4\n1 2 3 4\n"), "a.unv:14: this should be an integer"},
           {kUnvNodes + unv_set("2412", "1 111 7 1 7\n1 2 3 4\n"),
            "a.unv:14: the first line of an element should have 6"},
           {kUnvNodes + unv_set("2412", "1 111 7 1 7 5\n1 2 3 4 5\n"), "should have 4 or 10 nodes, and has 5"},
           {kUnvNodes + unv_set("2412", "1 111 7 1 7 4\n1 2 3 4 1\n"), "more than its 4 nodes"},
           {kUnvNodes + unv_set("2412", "1 111 7 1 7 4\n1 2 3 9\n"), "a.unv:14: this element has node 9, and no node"},
           {kUnvNodes + unv_set("2412", kUnvTet + "1 91 7 1 7 3\n1 2 3\n"), "the element 1 is also in line 14"},
           {kUnvNodes + unv_set("2412", "1 95 7 1 7 8\n1 2 3 1 4 2 1 3\n"),
            "node 1 is a vertex of this element and in"},
           {kUnvNodes + unv_set("2412", "1 117 7 1 7 32\n"),
            "FE descriptor 117 is of an order that tetune does not read"},
           {kUnvNodes + unv_set("2412", "1 161 7 1 7 999999999\n1\n"),
            "a.unv:16: the data set 2412 ends here within a record"},
           {kUnvNodes + unv_set("2411", "4 1 1 11\n0. 0. 2.\n") + tet,
            "the node 4 is also in line 9, at another position"},
           {unv_set("2411", "1 1 1 11\n0. 1.x 0.\n"), "a.unv:4: this should be a coordinate, and is \"1.x\""},
           {unv_set("2411", "1 1 1 11\n0. 1D999 0.\n"), "this should be a coordinate"},
           {kUnvNodes + tet + unv_set("2467", "1 0 0 0 0 0 0 9999999999\na\n8 1 0 0\n"), "the data set 2467 ends here"},
           {kUnvNodes + tet + unv_set("2467", "1 0 0 0 0 0 0 1\na\n8 1 0 0 8 1 0 0\n"), "more than its 1 entities"},
           {kUnvNodes + tet + unv_set("2467", "1 0 0 0 0 0 0 1\na\n8 1 0\n"),
            "should have 4 integers; this line has 3"}}) {
    const std::string found = error(text);
    EXPECT_TRUE(contains(found, message)) << text << "\n" << found;
    EXPECT_TRUE(contains(found, "a.unv:"));
  }
  // Copies are one.
  const TetMesh m = read(kUnvNodes + kUnvNodes + unv_set("2412", kUnvTet + kUnvTet));
  EXPECT_EQ(m.points.size(), 4U);
  EXPECT_EQ(m.tets.size(), 1U);
}

TEST_F(Unv, EveryTruncationIsRefusedOrNamed) {
  const std::string whole = kUnvNodes + unv_set("2412", kUnvTet) + unv_set("2467", group(1, "a", {{8, 1}, {7, 2}}));
  const std::size_t end = whole.rfind("    -1");
  for (std::size_t n = 0; n < end; ++n) {
    const std::string text = whole.substr(0, n);
    const std::string found = error(text);
    if (!found.empty()) continue;
    read(text);
    // A file may end between data sets.
    EXPECT_TRUE(trimmed(text).ends_with("-1") || warned("cut short")) << text;
  }
}

TEST_F(Unv, NumbersOfNodesFromZeroAreNotKept) {
  std::string nodes = kUnvTetNodes, tet = kUnvTet;
  nodes.replace(9, 1, "0");
  tet.replace(tet.rfind("         1         2"), 10, "         0");
  const TetMesh m = read(unv_set("2411", nodes) + unv_set("2412", tet));
  EXPECT_EQ(m.tets, (std::vector<std::array<Index, 4>>{{0, 1, 2, 3}}));
  EXPECT_TRUE(m.deck_nodes.empty());
  EXPECT_TRUE(warned("a node has the number 0: the nodes are numbered from 1"));
}

}  // namespace
}  // namespace tetune::test

// SPDX-License-Identifier: Apache-2.0
// Gmsh's files, versions 2.2 and 4.1.
#include "msh_fixture.hpp"

#include <cstring>

#include "mesh_contents.hpp"

namespace tetune::test {
namespace {

/// Version 4.1, with numbers that need 64 bits, gaps and no order.
const std::string kSparse = kFormat +
                            "$PhysicalNames\n2\n3 7 \"steel # 1\"\n2 9 \"empty\"\n$EndPhysicalNames\n"
                            "$Entities\n0 0 0 1\n3 0 0 0 1 1 1 1 -7 0\n$EndEntities\n"
                            "$Nodes\n2 4 5 900000000000000003\n3 3 0 1\n900000000000000003\n0 0 1\n"
                            "3 3 1 3\n8589934592\n5\n900000000000000001\n1 0 0 .1 .2 .3\n0 0 0 .1 .2 .3\n0 1 0 0 0 0\n"
                            "$EndNodes\n$Elements\n1 1 8589934599 8589934599\n3 3 4 1\n"
                            "8589934599 5 8589934592 900000000000000001 900000000000000003\n$EndElements\n";

std::vector<std::string> warnings_of(const std::string& file) {
  std::vector<std::string> warnings;
  read_mesh(file, &warnings, 1);
  return warnings;
}

TEST_F(Msh, NumbersOf64BitsWithGapsAreRenumberedInOrder) {
  std::vector<std::string> warnings;
  const TetMesh m = read_mesh(put("a.msh", kSparse), &warnings, 1);
  EXPECT_EQ(m.points, (std::vector<Point3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
  EXPECT_EQ(m.tets, (std::vector<std::array<Index, 4>>{{0, 1, 2, 3}}));
  EXPECT_EQ(m.tet_tags, std::vector{7});
  ASSERT_EQ(m.groups.size(), 2U);
  EXPECT_EQ(m.groups[0].name, "empty");
  EXPECT_TRUE(m.groups[0].tags.empty());
  EXPECT_EQ(m.groups[1].name, "steel # 1");
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_TRUE(contains(warnings[0], "parametric coordinates"));
  EXPECT_TRUE(contains(warnings[1], "not numbered from 1 to 4"));
  write_mesh(path("b.msh"), m, 1);
  EXPECT_TRUE(contains(get("b.msh"), "3 7 \"steel # 1\"\n"));
  EXPECT_TRUE(contains(get("b.msh"), "2 9 \"empty\"\n"));
  EXPECT_TRUE(warnings_of(path("b.msh")).empty());
}

TEST_F(Msh, EveryDialectKeepsEverything) {
  for (const std::string& dialect : kDialects) {
    SCOPED_TRACE(dialect);
    TetMesh m = rich();
    m.points.push_back({9, 9, 9});  // in no element
    m.point_tags.push_back(0);
    m.point_data.clear();
    m.points[3] = {1.0 / 3, 5e-324, -1.7976931348623157e308};
    std::vector<double> heat(9 * m.points.size(), 1e-17);
    heat[4] = -0.1;
    m.point_data = {{"heat", 9, heat}};
    m.dialect = dialect;
    std::vector<std::string> warnings;
    write_mesh(path("a.msh"), m, 1, &warnings);
    EXPECT_TRUE(warnings.empty());
    const TetMesh back = read_mesh(path("a.msh"), &warnings, 1);
    EXPECT_TRUE(warnings.empty());
    EXPECT_EQ(back.dialect, dialect);
    EXPECT_EQ(back.points, m.points);
    EXPECT_TRUE(same_tags(m, back));
    EXPECT_EQ(tagged(back.edges, back.edge_tags), tagged(m.edges, m.edge_tags));
    EXPECT_TRUE(same_others(m, back));
    EXPECT_TRUE(same_groups(m, back));
    EXPECT_TRUE(same_point_data(m, back));
    EXPECT_EQ(by_tet(m, "load"), by_tet(back, "load"));
    write_mesh(path("b.msh"), back, 1);
    write_mesh(path("c.msh"), read_mesh(path("b.msh"), nullptr, 1), 1);
    EXPECT_TRUE(get("b.msh") == get("c.msh"));
  }
}

/// A tetrahedron of ten nodes, the first six lines of it as given: nodes 5 to 10 are on the edges 12, 23, 31, 14,
/// 34, 24.
std::string tet10(const std::string& fifth, const std::string& element = "1 11 2 1 1 1 2 3 4 5 6 7 8 9 10") {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n11\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 " + fifth +
         "\n6 0.5 0.5 0\n7 0 0.5 0\n8 0 0 0.5\n9 0 0.5 0.5000001\n10 0.5 0 0.5\n11 9 9 9\n$EndNodes\n$Elements\n1\n" +
         element + "\n$EndElements\n";
}

TEST_F(Msh, ValuesAtMidSideNodesAreLostWithAWarning) {
  const auto warnings_of = [this](const std::string& fifth) {
    std::string data = "$NodeData\n1\n\"heat\"\n1\n0\n3\n0\n1\n11\n";
    const std::vector<std::string> values{"0", "1", "0", "0", fifth, "0.5", "0", "0", "0", "0.5", "9"};
    for (std::size_t v = 0; v < values.size(); ++v) data += std::to_string(v + 1) + " " + values[v] + "\n";
    std::vector<std::string> warnings;
    read_mesh(put("a.msh", tet10("0.5 0 0") + data + "$EndNodeData\n"), &warnings, 1);
    return warnings;
  };
  EXPECT_TRUE(warnings_of("0.5").empty());
  ASSERT_EQ(warnings_of("0.25").size(), 1U);
  EXPECT_TRUE(contains(warnings_of("0.25")[0], "values at mid-side nodes are not kept: heat"));
}

TEST_F(Msh, IntegersThatDoublesRoundAreAWarning) {
  TetMesh m = cube(2);
  constexpr std::int64_t kExact = std::int64_t{1} << 53;
  m.point_data = {{"exact", 1, std::vector<std::int64_t>(m.points.size(), -kExact)},
                  {"low", 1, std::vector<std::int64_t>(m.points.size(), -kExact - 1)}};
  std::vector<std::uint64_t> ids(m.tets.size(), 1);
  ids.back() = ~std::uint64_t{0};
  m.tet_data = {{"ids", 1, ids}};
  std::vector<std::string> warnings;
  write_mesh(path("a.msh"), m, 1, &warnings);
  EXPECT_EQ(warnings,
            (std::vector<std::string>{
                path("a.msh") + ": integers beyond 2^53 are rounded, as Gmsh stores doubles: data \"ids\", \"low\""}));
}

TEST_F(Msh, CurvedEdgesKeepTheBitsOfTheirNodes) {
  const TetMesh straight = read_mesh(put("straight.msh", tet10("0.50001 0 0")), nullptr, 1);
  EXPECT_TRUE(straight.second_order);
  EXPECT_TRUE(straight.curved_edges.empty());  // rounding explains both
  const TetMesh curved = read_mesh(put("curved.msh", tet10("0.5 -0.1 0.3")), nullptr, 1);
  EXPECT_EQ(curved.points.size(), 5U);
  EXPECT_EQ(curved.curved_edges, (std::vector<CurvedEdge>{{{0, 1}, {0.5, -0.1, 0.3}}, {{2, 3}, {0, 0.5, 0.5000001}}}));
  for (const std::string& dialect : kDialects) {
    TetMesh m = curved;
    m.dialect = dialect;
    write_mesh(path("a.msh"), m, 1);
    const TetMesh back = read_mesh(path("a.msh"), nullptr, 1);
    EXPECT_EQ(back.points, curved.points);
    EXPECT_EQ(back.curved_edges, curved.curved_edges) << dialect;
  }
  write_mesh(path("a.inp"), curved, 1);
  EXPECT_TRUE(contains(get("a.inp"), "TYPE=C3D10, ELSET=Volume1\n1, 1, 2, 3, 4, 6, 9, 7, 8, 10, 11\n")) << get("a.inp");
  std::vector<std::string> warnings;
  write_mesh(path("a.mesh"), curved, 1, &warnings);
  EXPECT_TRUE(contains(warnings.back(), "2 curved edges are straight"));
  const std::string two = read_error(put("two.msh", tet10("0.5 0.1 0", "1 11 2 1 1 1 2 3 4 5 6 7 8 9 5")));
  EXPECT_TRUE(contains(two, "node 5 is a mid-side node of two edges")) << two;
  // Messages have the number of a node, also where numbers have gaps, large ones among them.
  for (const std::string number : {"50", "987654321"}) {
    std::string text = tet10("0.5 0.1 0", "1 11 2 1 1 1 2 3 4 " + number + " 6 7 8 9 " + number);
    text.replace(text.find("\n5 0.5") + 1, 1, number);
    const std::string error = read_error(put("two.msh", text));
    EXPECT_TRUE(contains(error, "node " + number + " is a mid-side node of two edges, or one of two nodes of the same"))
        << error;
  }
}

TEST_F(Msh, PartitionsAndSeveralStepsAreNamed) {
  const std::string file = put(
      "a.msh", kOldHead + kOldNodes + "$Elements\n2\n1 4 5 1 1 2 3 -1 1 2 3 4\n2 4 4 1 1 1 2 2 3 4 5\n$EndElements\n" +
                   "$NodeData\n1\n\"heat\"\n1\n0.5\n3\n0\n1\n1\n2 7\n$EndNodeData\n"
                   "$NodeData\n1\n\"heat\"\n1\n1.5\n3\n1\n1\n1\n2 8\n$EndNodeData\n"
                   "$ElementNodeData\n1\n\"stress\"\n1\n0\n3\n0\n1\n1\n1 4 1 2 3 4\n$EndElementNodeData\n");
  std::vector<std::string> warnings;
  const TetMesh m = read_mesh(file, &warnings, 1);
  ASSERT_EQ(warnings.size(), 4U);
  EXPECT_TRUE(contains(warnings[0], "of the data \"heat\" the first step is kept"));
  EXPECT_TRUE(contains(warnings[1], "section $ElementNodeData is not kept"));
  EXPECT_TRUE(contains(warnings[2], "ghost elements of partitions are not kept"));
  EXPECT_TRUE(contains(warnings[3], "the partitions are kept as the data \"gmsh:partition\""));
  EXPECT_EQ(doubles(*find(m.tet_data, "gmsh:partition")), (std::vector<double>{3, 2}));
  EXPECT_EQ(doubles(*find(m.point_data, "heat"))[1], 7);
}

/// The bytes of numbers, one after the other.
template <class... T>
std::string raw(T... values) {
  std::string bytes;
  (bytes.append(reinterpret_cast<const char*>(&values), sizeof(T)), ...);
  return bytes;
}

TEST_F(Msh, SizesOf32BitsAreRead) {
  using Short = std::uint32_t;
  std::string binary = "$MeshFormat\n4.1 1 4\n" + raw(1) + "\n$EndMeshFormat\n$Nodes\n";
  binary += raw(Short{1}, Short{4}, Short{1}, Short{4}, 3, 1, 0, Short{4}, Short{1}, Short{2}, Short{3}, Short{4});
  binary += raw(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0) + "\n$EndNodes\n$Elements\n";
  binary += raw(Short{1}, Short{1}, Short{1}, Short{1}, 3, 1, 4, Short{1}, Short{1}, Short{1}, Short{2}, Short{3});
  binary += raw(Short{4}) + "\n$EndElements\n";
  const std::string text =
      "$MeshFormat\n4.1 0 4\n$EndMeshFormat\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n"
      "0 1 0\n0 0 1\n$EndNodes\n$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n";
  for (const std::string& file : {binary, text}) {
    const TetMesh m = read_mesh(put("a.msh", file), nullptr, 1);
    EXPECT_EQ(m.points, (std::vector<Point3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
    EXPECT_EQ(m.tets, (decltype(m.tets){{0, 1, 2, 3}}));
    EXPECT_TRUE(contains(read_error(put("a.msh", file.substr(0, file.size() - 20))), "a.msh"));
  }
}

TEST_F(Msh, NamesOfDataLoseQuotationMarksWithAWarning) {
  TetMesh m = one_tet();
  m.point_data = {{"the \"load\"", 1, std::vector<double>{1, 2, 3, 4}}};
  std::vector<std::string> warnings;
  write_mesh(path("a.msh"), m, 1, &warnings);
  EXPECT_TRUE(contains(warnings, "without quotation marks and ends of lines: \"the 'load'\""));
  EXPECT_NE(find(read_mesh(path("a.msh"), nullptr, 1).point_data, "the 'load'"), nullptr);
}

TEST_F(Msh, NamesMayLackQuotationMarks) {
  const std::string file = kOldHead + "$PhysicalNames\n1\n3 1 mild steel\n$EndPhysicalNames\n" + kOldNodes +
                           "$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n"
                           "$ElementData\n1\nload \n1\n0\n3\n0\n1\n1\n1 2.5\n$EndElementData\n";
  const TetMesh m = read_mesh(put("a.msh", file), nullptr, 1);
  ASSERT_EQ(m.groups.size(), 1U);
  EXPECT_EQ(m.groups[0].name, "mild steel");
  ASSERT_NE(find(m.tet_data, "load"), nullptr);
  EXPECT_EQ(doubles(*find(m.tet_data, "load")), (std::vector<double>{2.5}));
  const std::string half = kOldHead + "$PhysicalNames\n1\n3 1 \"steel\n$EndPhysicalNames\n";
  EXPECT_TRUE(contains(read_error(put("a.msh", half)), "a.msh:6: expected a name in quotation marks"));
}

TEST_F(Msh, ErrorsSayWhere) {
  const auto refused = [this](const std::string& text, const std::string& said) {
    const std::string error = read_error(put("a.msh", text));
    EXPECT_TRUE(contains(error, path("a.msh"))) << said;
    EXPECT_TRUE(contains(error, said));
  };
  refused("", "empty");
  refused("SystemCall \"touch ran\";\n", "does not start with $MeshFormat");
  refused("$MeshFormat\n2.2 0 4\n$EndMeshFormat\n", "a.msh:2: numbers of 4 bytes");
  refused("$MeshFormat\n4.1 0 2\n$EndMeshFormat\n", "a.msh:2: numbers of 2 bytes");
  refused(kOldHead + kOldNodes, "$Nodes or $Elements is missing");
  refused(kOldHead + "$Elements\n0\n$EndElements\n", "a.msh:4: the section $Elements comes before $Nodes");
  refused(kOldHead + kOldNodes + kOldNodes, "a.msh:12: the section $Nodes occurs twice");
  refused(kOldHead + kOldNodes + "$NodeData\n", "a.msh:12: the section $NodeData comes before $Elements");
  refused(kOldHead + "$Nodes\n5000000\n1 0 0 0\n", "a.msh:5: number of nodes is 5000000, more than the rest");
  refused(kOldHead + "$Nodes\n2\n1 0 0 0\n1 0 0 0\n$EndNodes\n", "node 1 occurs twice");
  refused(kOldHead + "$Nodes\n1\n1 0 x 0\n$EndNodes\n", "a.msh:6: expected a number (coordinate), found \"x\"");
  refused(kOldHead + "$Nodes\n1\n1 0 0 0\n2 0 0 0\n$EndNodes\n", "a.msh:7: expected $EndNodes, found \"2\"");
  const auto element = [&](const std::string& line) {
    return kOldHead + kOldNodes + "$Elements\n1\n" + line + "\n$EndElements\n";
  };
  refused(element("1 4 2 0 1 1 2 3 9"), "element 1 has node 9, which does not exist");
  refused(element("1 29 2 0 1 1 2 3 4"), "a.msh:14: element 1 is of type 29, which tetune does not read");
  refused(element("1 4 2 0 3000000000 1 2 3 4"), "tag of an element 3000000000 does not fit 32 bits");
  refused(element("1 4 2 0 1 1 2 3"), "expected an integer (node), found \"$EndElements\"");
  TetMesh m = one_tet();
  m.dialect = "msh 4.1 binary";
  write_mesh(path("b.msh"), m, 1);
  refused(get("b.msh").substr(0, 30), "a.msh, byte 30: expected $EndMeshFormat, found \"$EndM\"");
}

TEST_F(Msh, EveryTruncationIsRefused) {
  for (const std::string& dialect : kDialects) {
    TetMesh m = one_tet();
    m.tet_tags = {5};
    m.groups = {{3, 5, "steel", {5}}};
    m.tet_data = {{"load", 1, std::vector<double>{1.5}}};
    m.dialect = dialect;
    write_mesh(path("whole.msh"), m, 1);
    const std::string whole = get("whole.msh");
    const std::size_t data = whole.find("$ElementData");
    for (std::size_t n = 0; n + 1 < whole.size(); ++n) {
      if (n + 1 == data || n == data) continue;  // a whole mesh without data
      EXPECT_NE(read_error(put("a.msh", whole.substr(0, n))), "") << dialect << " " << n;
    }
  }
}

TEST_F(Msh, TheOtherByteOrder) {
  // Version 2.2 with one node: the numbers of 32 and 64 bits reversed.
  const auto reversed = [](auto value) {
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    return std::string(bytes.rbegin(), bytes.rend());
  };
  std::string file = "$MeshFormat\n2.2 1 8\n" + reversed(1) + "\n$EndMeshFormat\n$Nodes\n4\n";
  for (int i = 0; i < 4; ++i) {
    file += reversed(i + 1);
    for (int k = 1; k <= 3; ++k) file += reversed(i == k ? 0.1 : 0.0);
  }
  file += "\n$EndNodes\n$Elements\n1\n";
  for (const int word : {4, 1, 2, 1, 0, 8, 1, 2, 3, 4}) file += reversed(word);
  const TetMesh m = read_mesh(put("a.msh", file + "\n$EndElements\n"), nullptr, 1);
  EXPECT_EQ(m.points[2], (Point3{0, 0.1, 0}));
  EXPECT_EQ(m.tet_tags, std::vector{8});
}

}  // namespace
}  // namespace tetune::test

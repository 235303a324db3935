// SPDX-License-Identifier: Apache-2.0
// Gmsh's files, versions 2.2 and 4.1.
#include <limits>

#include "io_fixture.hpp"
#include "mesh/tet.hpp"
#include "mesh_contents.hpp"
#include "tetune/optimize.hpp"
#include "tetune/validate.hpp"

namespace tetune::test {
namespace {

using Msh = IoTest;

const std::vector<std::string> kDialects{"msh 2.2 text", "msh 2.2 binary", "msh 4.1 text", "msh 4.1 binary"};

const std::string kOldHead = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
const std::string kFormat = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
const std::string kOldNodes = "$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n";

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

TEST_F(Msh, NamesOfVersion20HaveNoDimension) {
  const std::string elements = "$Elements\n2\n1 4 2 7 1 1 2 3 4\n2 2 2 101 1 1 3 2\n$EndElements\n";
  const std::string names = "$PhysicalNames\n3\n7\"body 1\"\n 101 \"wall\"\n 5 \"unused\"\n$EndPhysicalNames\n";
  const std::string head = "$MeshFormat\n2.0 0 8\n$EndMeshFormat\n";
  for (const std::string& text : {head + kOldNodes + elements + names, head + names + kOldNodes + elements}) {
    const TetMesh m = read_mesh(put("a.msh", text), nullptr, 1);
    ASSERT_EQ(m.groups.size(), 2U);
    EXPECT_EQ(m.groups[0].name, "wall");
    EXPECT_EQ(m.groups[0].dimension, 2);
    EXPECT_EQ(m.groups[1].name, "body 1");
    EXPECT_EQ(m.groups[1].dimension, 3);
    EXPECT_EQ(m.groups[1].tags, m.tet_tags);
  }
  EXPECT_TRUE(contains(read_error(put("a.msh", kFormat + names)), "a.msh:6: group 7 of dimension -1 is none"));
  EXPECT_FALSE(read_error(put("a.msh", head + "$PhysicalNames\n1\n7x\"body\"\n$EndPhysicalNames\n")).empty());
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

TEST_F(Msh, PeriodicLinksAreKeptAndMatch) {
  TetMesh m = cube(4, 0.2);
  m.tet_tags.assign(m.tets.size(), 1);
  m.cell_tags_name = "gmsh:geometrical";
  PeriodicLink link{2, 4, 3, {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, {}};
  const TetMesh regular = cube(4);
  for (std::size_t v = 0; v < m.points.size(); ++v) {
    if (regular.points[v][0] != 1) continue;
    for (std::size_t w = 0; w < m.points.size(); ++w) {
      if (regular.points[w] != Point3{0, regular.points[v][1], regular.points[v][2]}) continue;
      m.points[v] = {1, m.points[w][1], m.points[w][2]};
      link.pairs.push_back({static_cast<Index>(v), static_cast<Index>(w)});
    }
  }
  ASSERT_EQ(link.pairs.size(), 25U);
  m.periodic = {link};
  for (const std::string& dialect : kDialects) {
    SCOPED_TRACE(dialect);
    m.dialect = dialect;
    write_mesh(path("a.msh"), m, 1);
    TetMesh back = read_mesh(path("a.msh"), nullptr, 1);
    ASSERT_EQ(back.periodic.size(), 1U);
    EXPECT_EQ(back.periodic[0].dimension, 2);
    EXPECT_EQ(back.periodic[0].entity, 4);
    EXPECT_EQ(back.periodic[0].master, 3);
    EXPECT_EQ(back.periodic[0].affine, link.affine);
    EXPECT_EQ(back.periodic[0].pairs, link.pairs);
    Options options;
    options.effort = Effort::best;
    options.threads = 1;
    optimize(back, options);
    for (const auto& [vertex, master] : back.periodic[0].pairs) {
      const Point3& p = back.points[static_cast<std::size_t>(vertex)];
      const Point3& q = back.points[static_cast<std::size_t>(master)];
      EXPECT_EQ(p, (Point3{1, q[1], q[2]}));
      EXPECT_EQ(q[0], 0);
    }
  }
  EXPECT_FALSE(contains(get("a.msh"), "$Comments"));  // only the link names its entities
  std::vector<std::string> warnings;
  write_mesh(path("a.mesh"), m, 1, &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "periodic links"));
  // Entities that other tags divide are no longer those of the link.
  TetMesh divided = read_mesh(path("a.msh"), nullptr, 1);
  divided.triangles = {{0, 1, 6}, {0, 6, 5}};
  divided.triangle_tags = {1, 2};
  divided.triangle_data = {{"gmsh:geometrical", 1, std::vector<std::int32_t>{4, 4}}};
  warnings.clear();
  write_mesh(path("a.msh"), divided, 1, &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "1 periodic links of dimension 2 are not written"));
  EXPECT_TRUE(read_mesh(path("a.msh"), nullptr, 1).periodic.empty());
  // The middles of paired edges are pairs.
  m.second_order = true;
  m.dialect = "msh 4.1 text";
  write_mesh(path("a.msh"), m, 1);
  const std::string text = get("a.msh");
  EXPECT_TRUE(contains(text, "\n81\n"));  // 25 vertices and 56 edges on the face
  EXPECT_EQ(read_mesh(path("a.msh"), nullptr, 1).periodic[0].pairs, link.pairs);
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

TEST_F(Msh, TagsOfOneGroupBecomeOneWithAWarning) {
  TetMesh m = cube(2, 0.1);
  for (std::size_t t = 0; t < m.tets.size(); ++t) m.tet_tags[t] = t % 2 == 0 ? 1 : 2;
  m.groups = {{3, 1, "steel", {1, 2}}};
  std::vector<std::string> warnings;
  write_mesh(path("a.msh"), m, 1, &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "the 2 tags of the group \"steel\" become one"));
  const TetMesh back = read_mesh(path("a.msh"), nullptr, 1);
  EXPECT_EQ(back.tet_tags, std::vector<int>(m.tets.size(), 1));
}

TEST_F(Msh, CurvedEdgesKeepTheBitsOfTheirNodes) {
  const TetMesh straight = read_mesh(put("straight.msh", tet10("0.50001 0 0")), nullptr, 1);
  EXPECT_TRUE(straight.second_order);
  EXPECT_TRUE(straight.curved_edges.empty());  // rounding explains both
  const TetMesh curved = read_mesh(put("curved.msh", tet10("0.5 -0.1 0.3")), nullptr, 1);
  EXPECT_EQ(curved.points.size(), 5U);
  EXPECT_EQ(curved.curved_edges, (std::vector<CurvedEdge>{{{0, 1}, {0.5, -0.1, 0.3}}, {{2, 3}, {0, 0.5, 0.5000001}}}));
  for (const std::string dialect : {"msh 2.2 text", "msh 2.2 binary", "msh 4.1 text", "msh 4.1 binary"}) {
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
}

TEST_F(Msh, TrianglesOfLinksThatAreNoTranslationsAreNotFlipped) {
  TetMesh m = cube(3);
  m.triangle_tags.clear();
  m.triangles.clear();
  PeriodicLink link{2, 4, 3, {}, {}};
  std::map<std::array<Index, 3>, int> faces;
  for (const auto& tet : m.tets) {
    for (std::size_t k = 0; k < 4; ++k) ++faces[ascending_face(tet, k)];
  }
  const auto x = [&m](Index v) { return m.points[static_cast<std::size_t>(v)][0]; };
  for (const auto& [face, n] : faces) {
    if (n == 1 && x(face[0]) == 0 && x(face[1]) == 0 && x(face[2]) == 0) m.triangles.push_back(face);
  }
  ASSERT_EQ(m.triangles.size(), 18U);
  m.triangle_tags.assign(m.triangles.size(), 3);
  // The long diagonals of the face would be flipped.
  for (Point3& p : m.points) {
    p[1] += 0.9 * p[2];
    if (p[0] == 0) link.pairs.push_back({static_cast<Index>(&p - m.points.data()), 0});
  }
  TetMesh free = m;
  const auto before = tagged(m.triangles, m.triangle_tags);
  Options options;
  options.threads = 1;
  optimize(free, options);
  EXPECT_NE(tagged(free.triangles, free.triangle_tags), before);
  m.periodic = {link};
  optimize(m, options);
  EXPECT_EQ(tagged(m.triangles, m.triangle_tags), before);
}

TEST_F(Msh, PartitionsAndSeveralStepsAreNamed) {
  const std::string file = put(
      "a.msh", kOldHead + kOldNodes + "$Elements\n2\n1 4 5 1 1 2 3 -1 1 2 3 4\n2 4 4 1 1 1 2 2 3 4 5\n$EndElements\n" +
                   "$NodeData\n1\n\"heat\"\n1\n0.5\n3\n0\n1\n1\n2 7\n$EndNodeData\n"
                   "$NodeData\n1\n\"heat\"\n1\n1.5\n3\n1\n1\n1\n2 8\n$EndNodeData\n"
                   "$ElementNodeData\n1\n\"stress\"\n1\n0\n3\n0\n1\n1\n1 4 1 2 3 4\n$EndElementNodeData\n");
  std::vector<std::string> warnings;
  const TetMesh m = read_mesh(file, &warnings, 1);
  ASSERT_EQ(warnings.size(), 3U);
  EXPECT_TRUE(contains(warnings[0], "of the data \"heat\" the first step is kept"));
  EXPECT_TRUE(contains(warnings[1], "section $ElementNodeData is not kept"));
  EXPECT_TRUE(contains(warnings[2], "the partitions are kept as the data \"gmsh:partition\""));
  EXPECT_EQ(doubles(*find(m.tet_data, "gmsh:partition")), (std::vector<double>{3, 2}));
  EXPECT_EQ(doubles(*find(m.point_data, "heat"))[1], 7);
}

TEST_F(Msh, GroupsOfOtherProgramsThatShareAnEntity) {
  // One entity, whose elements are in different groups; the last is in two.
  const std::string file = put("a.msh", kOldHead + kOldNodes +
                                            "$Elements\n5\n1 2 2 5 1 1 2 3\n2 2 2 6 1 1 2 4\n3 2 2 5 1 1 3 4\n"
                                            "4 2 2 6 1 1 3 4\n5 4 2 0 1 1 2 3 4\n$EndElements\n");
  const TetMesh m = read_mesh(file, nullptr, 1);
  EXPECT_EQ(m.triangle_tags, (std::vector{5, 6, -1}));
  for (const std::string& dialect : kDialects) {
    TetMesh again = m;
    again.dialect = dialect;
    write_mesh(path("b.msh"), again, 1);
    const TetMesh back = read_mesh(path("b.msh"), nullptr, 1);
    EXPECT_TRUE(same_tags(m, back)) << dialect;
    EXPECT_TRUE(same_groups(m, back)) << dialect;
  }
}

TEST_F(Msh, ErrorsSayWhere) {
  const auto refused = [this](const std::string& text, const std::string& said) {
    const std::string error = read_error(put("a.msh", text));
    EXPECT_TRUE(contains(error, path("a.msh"))) << said;
    EXPECT_TRUE(contains(error, said));
  };
  refused("", "empty");
  refused("SystemCall \"touch ran\";\n", "does not start with $MeshFormat");
  refused("$MeshFormat\n4.1 0 4\n$EndMeshFormat\n", "a.msh:2: numbers of 4 bytes");
  refused(kOldHead + kOldNodes, "$Nodes or $Elements is missing");
  refused(kOldHead + "$Elements\n0\n$EndElements\n", "a.msh:5: the section $Elements comes before $Nodes");
  refused(kOldHead + "$Nodes\n5000000\n1 0 0 0\n", "a.msh:5: number of nodes is 5000000, more than the rest");
  refused(kOldHead + "$Nodes\n2\n1 0 0 0\n1 0 0 0\n$EndNodes\n", "node 1 occurs twice");
  refused(kOldHead + "$Nodes\n1\n1 0 x 0\n$EndNodes\n", "a.msh:6: expected a number (coordinate), found \"x\"");
  refused(kOldHead + "$Nodes\n1\n1 0 0 0\n2 0 0 0\n$EndNodes\n", "a.msh:7: expected $EndNodes, found \"2\"");
  const auto element = [&](const std::string& line) {
    return kOldHead + kOldNodes + "$Elements\n1\n" + line + "\n$EndElements\n";
  };
  refused(element("1 4 2 0 1 1 2 3 9"), "element 1 has node 9, which does not exist");
  refused(element("1 17 2 0 1 1 2 3 4"), "a.msh:14: element 1 is of type 17, which tetune does not read");
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

TEST_F(Msh, GmshKeepsWhatHasNoTagOrANegativeOne) {
  for (const std::string dialect : {"", "msh 4.1 text", "msh 2.2 text", "msh 2.2 binary"}) {
    for (const std::vector<int>& tags : {std::vector{0}, {0, -7}, {0, 3, -7}, {1, -1, -2, 2}}) {
      SCOPED_TRACE(dialect + " " + std::to_string(tags.size()));
      TetMesh m = with_tags(tags, {0, 5, -2});
      m.dialect = dialect;
      m.tet_data = {{"load", 1, std::vector<double>(m.tets.size(), 0.5)}};
      write_mesh(path("a.msh"), m, 1);
      TetMesh back = read_mesh(path("a.msh"), nullptr, 1);
      EXPECT_TRUE(same_tags(m, back));
      EXPECT_NE(find(back.tet_data, "load"), nullptr);
      write_mesh(path("again.msh"), back, 1);
      EXPECT_TRUE(same_tags(m, read_mesh(path("again.msh"), nullptr, 1)));
      m.triangles.clear();
      m.triangle_tags.clear();
      write_mesh(path("a.msh"), m, 1);
      EXPECT_TRUE(same_tags(m, read_mesh(path("a.msh"), nullptr, 1)));
    }
  }
}

TEST_F(Msh, EntitiesOfOtherProgramsInNoGroupStayEntities) {
  const std::string two =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 5 0 0\n6 6 0 0\n"
      "7 5 1 0\n8 5 0 1\n$EndNodes\n$Elements\n2\n1 4 2 3 3 1 2 3 4\n2 4 2 0 4 5 6 7 8\n$EndElements\n";
  const TetMesh m = read_mesh(put("a.msh", two), nullptr, 1);
  EXPECT_EQ(m.tet_tags, (std::vector{3, -4}));
  std::vector<std::string> warnings;
  write_mesh(path("b.msh"), m, 1, &warnings);
  EXPECT_TRUE(warnings.empty());
  EXPECT_TRUE(contains(get("b.msh"), "$MeshFormat\n2.2 0 8"));
  EXPECT_FALSE(contains(get("b.msh"), "$Comments"));
  EXPECT_TRUE(same_tags(m, read_mesh(path("b.msh"), nullptr, 1)));
  // Comments of others are comments.
  const std::string odd = "$Comments\ntetune: tags of entities in no physical group\n3 4 x\n$EndComments\n";
  EXPECT_EQ(read_mesh(put("c.msh", two + odd), nullptr, 1).tet_tags, (std::vector{3, -4}));
}

TEST_F(Msh, OptimizedMeshesKeepGroupsNamesAndLowerDimensions) {
  TetMesh m = two_materials(6, 0.25);
  const TetMesh r = rich();
  m.groups = {{3, 1, "steel", {1}}, {3, 2, "air gap", {2}}, {3, 3, "both", {1, 2}}, {1, 21, "rim", {21}}};
  m.edges = r.edges;
  m.edge_tags = r.edge_tags;
  write_mesh(path("in.msh"), m, 1);
  TetMesh read = read_mesh(path("in.msh"), nullptr, 1);
  EXPECT_EQ(read.dialect, "msh 4.1 binary");
  EXPECT_EQ(read.cell_tags_name, "gmsh:physical");
  ASSERT_EQ(read.groups.size(), 5U);  // and that of the second edge
  // Both regions are in two groups: the tags distinguish the entities.
  EXPECT_EQ(std::set<int>(read.tet_tags.begin(), read.tet_tags.end()), (std::set<int>{-1, -2}));
  const Report report = optimize(read);
  ASSERT_GT(report.flips32 + report.edge_removals, 0);
  write_mesh(path("out.msh"), read, 1);
  const TetMesh back = read_mesh(path("out.msh"), nullptr, 1);
  EXPECT_TRUE(validate(back).ok());
  EXPECT_TRUE(same_groups(read, back));
  EXPECT_EQ(back.groups.size(), read.groups.size());
  EXPECT_EQ(tagged(back.tets, back.tet_tags), tagged(read.tets, read.tet_tags));
  EXPECT_EQ(tagged(back.edges, back.edge_tags), tagged(read.edges, read.edge_tags));
  // Version 2.2 lists elements once for each group; they are read once.
  read.dialect = "msh 2.2 text";
  write_mesh(path("old.msh"), read, 1);
  EXPECT_EQ(get("old.msh").substr(0, 17), "$MeshFormat\n2.2 0");
  const TetMesh old = read_mesh(path("old.msh"), nullptr, 1);
  EXPECT_EQ(old.dialect, "msh 2.2 text");
  EXPECT_EQ(tagged(old.tets, old.tet_tags), tagged(read.tets, read.tet_tags));
  EXPECT_TRUE(same_groups(read, old));
}

}  // namespace
}  // namespace tetune::test

// SPDX-License-Identifier: Apache-2.0
// Formats through VTK and Gmsh: what comes back of what was written, and what damaged files do.
#include "io/registry.hpp"

#include <unistd.h>

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "io_fixture.hpp"
#include "mesh_contents.hpp"
#include "tetune/optimize.hpp"
#include "tetune/validate.hpp"

namespace tetune::test {
namespace {

class Plugins : public IoTest {
 protected:
  void SetUp() override {
    IoTest::SetUp();
    for (const Plugin& plugin : {kVtkPlugin, kGmshPlugin}) {
      if (!has_plugin(plugin)) GTEST_SKIP() << "built without " << plugin.library << ": install it with its headers";
    }
  }
};

const char* yes(bool kept) { return kept ? "yes" : "no"; }

const std::vector<std::string> kWritten{".mesh", ".meshb", ".msh", ".inp", ".ele", ".su2",
                                        ".vol",  ".vtu",   ".vtk", ".e",   ".unv", ".bdf"};

/// How the names of groups come back.
std::string names_kept(TetMesh m, const TetMesh& back) {
  // Where no edges are kept, neither are their groups.
  if (back.edges.empty()) std::erase_if(m.groups, [](const Group& g) { return g.dimension == 1; });
  if (same_groups(m, back)) return "yes";
  for (Group& g : m.groups) std::replace(g.name.begin(), g.name.end(), ' ', '_');
  return same_groups(m, back) ? "yes, blanks as `_`" : "no";
}

/// One line of the table in docs/formats.md.
std::string row(const std::string& ending, const std::string& file) {
  TetMesh m = rich();
  const bool no_pyramids = ending == ".unv";
  if (no_pyramids) {
    EXPECT_THROW(write_mesh(file, m, 1), FileError);
    m = rich(false);
  }
  const bool no_others = ending == ".ele";
  if (no_others) {
    EXPECT_THROW(write_mesh(file, m, 1), FileError);
    m.others.clear();
  }
  write_mesh(file, m, 1);
  const TetMesh plain = read_mesh(file, nullptr, 1);
  // A coordinate that needs all digits.
  const double off = farthest(m, plain);
  const bool points = std::any_of(plain.others.begin(), plain.others.end(),
                                  [](const ElementBlock& b) { return b.kind == kPoints && b.tags == std::vector{31}; });
  TetMesh listed = m;
  listed.point_tags[5] = 77;
  listed.corners = {0};
  listed.required_vertices = {3};
  listed.ridges = {0};
  listed.required_edges = {1};
  listed.required_triangles = {1};
  write_mesh(file, listed, 1);
  const TetMesh lists = read_mesh(file, nullptr, 1);
  TetMesh second = two_materials(2);
  second.second_order = true;
  write_mesh(file, second, 1);
  const TetMesh quadratic = read_mesh(file, nullptr, 1);
  const auto cells = [&](const TetMesh& n) { return by_tet(n, "load") == by_tet(m, "load"); };
  std::string line = "| `" + ending + "` |";
  for (const std::string& cell : std::vector<std::string>{
           ending == ".inp" ? "20 characters"
           : off == 0       ? "exact"
           : off < 1e-8     ? "rounded"
                            : "no",
           yes(tagged(plain.tets, plain.tet_tags) == tagged(m.tets, m.tet_tags)),
           yes(tagged(plain.triangles, plain.triangle_tags) == tagged(m.triangles, m.triangle_tags)),
           yes(tagged(plain.edges, plain.edge_tags) == tagged(m.edges, m.edge_tags)),
           yes(lists.point_tags == listed.point_tags), points ? "yes" : "no",
           std::string(yes(same_others(m, plain) && !no_others)) + (no_pyramids ? ", no pyramids" : ""),
           yes(lists.corners == listed.corners && lists.ridges == listed.ridges &&
               lists.required_edges == listed.required_edges && lists.required_triangles == listed.required_triangles &&
               std::find(lists.required_vertices.begin(), lists.required_vertices.end(), 3) !=
                   lists.required_vertices.end()),
           names_kept(m, plain), yes(same_point_data(m, plain)), yes(cells(plain)),
           yes(quadratic.second_order && farthest(second, quadratic) < 1e-8)}) {
    line += " " + cell + " |";
  }
  return line + "\n";
}

TEST_F(Plugins, TheTableInTheDocumentationIsTrue) {
  std::string table =
      "| | coordinates | region tags | triangle tags | edge tags | vertex tags | point elements | other kinds | "
      "corners, "
      "ridges, required | names of groups | vertex data | cell data | second order |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const std::string& ending : kWritten) table += row(ending, path("mesh" + ending));
  std::ifstream file(TETUNE_DOCS "/formats.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(page.find(table), std::string::npos) << "docs/formats.md should have this table:\n" << table;
}

TEST_F(Plugins, EverythingWrittenIsReadAndComesWithTheRightWarnings) {
  for (const std::string& ending : kWritten) {
    SCOPED_TRACE(ending);
    std::vector<std::string> warnings;
    TetMesh m = rich(ending != ".unv");
    if (ending == ".ele") m.others.clear();
    write_mesh(path("a" + ending), m, 1, &warnings);
    EXPECT_EQ(warnings.empty(), ending == ".msh" || ending == ".e") << warnings.size();
    for (const std::string& w : warnings) EXPECT_TRUE(contains(w, path("a" + ending)));
  }
  // A loss is reported once: points, and not their groups too.
  TetMesh probed = rich(false);
  probed.groups.push_back({0, 31, "probe", {31}});
  for (const std::string ending : {".unv", ".bdf", ".inp"}) {
    std::vector<std::string> warnings;
    write_mesh(path("a" + ending), probed, 1, &warnings);
    const auto about = [&warnings](const char* what) {
      return std::count_if(warnings.begin(), warnings.end(),
                           [what](const std::string& w) { return contains(w, what); });
    };
    EXPECT_EQ(about("elements of one vertex"), 1) << ending;
    EXPECT_EQ(about("probe"), 0) << ending;
  }
  for (const std::string& name : files()) EXPECT_EQ(name.find(".tmp"), std::string::npos);
}

TEST_F(Plugins, WhereThereAreNoEntitiesTheNumbersAreTheTags) {
  // Three volumes in two groups, as from Gmsh.
  TetMesh m = with_tags({1, 2, 3}, {1, 2});
  m.cell_tags_name = "gmsh:physical";
  m.tet_data = {{"gmsh:geometrical", 1, std::vector<std::int32_t>(m.tet_tags.begin(), m.tet_tags.end())}};
  m.triangle_data = {{"gmsh:geometrical", 1, std::vector<std::int32_t>{1, 2}}};
  for (int& tag : m.tet_tags) tag = tag == 2 ? 60 : 50;
  m.triangle_tags = {70, 70};
  m.groups = {{3, 50, "a", {50}}, {3, 60, "b", {60}}, {2, 70, "inlet", {70}}};
  for (const std::string ending : {".bdf", ".unv", ".inp", ".msh"}) {
    write_mesh(path("a" + ending), m, 1);
    EXPECT_TRUE(same_tags(m, read_mesh(path("a" + ending), nullptr, 1))) << ending;
  }
}

TEST_F(Plugins, NumbersThatNoTagCanHaveAreChangedWithAWarning) {
  const auto warned = [](const std::vector<std::string>& warnings, const char* what) {
    return std::any_of(warnings.begin(), warnings.end(), [what](const std::string& w) { return contains(w, what); });
  };
  const TetMesh m = with_tags({0, 3, -7, -3});
  std::vector<std::string> warnings;
  write_mesh(path("a.bdf"), m, 1, &warnings);
  EXPECT_TRUE(warned(warnings, "and 2 more"));
  EXPECT_EQ(distinct(read_mesh(path("a.bdf"), nullptr, 1).tet_tags), (std::set{1, 2, 3, 7}));
  warnings.clear();
  write_mesh(path("a.unv"), m, 1, &warnings);
  EXPECT_TRUE(warned(warnings, "and 1 more"));
  const TetMesh back = read_mesh(path("a.unv"), nullptr, 1);
  EXPECT_EQ(distinct(back.tet_tags).size(), 4U);
  EXPECT_EQ(distinct(back.tet_tags).count(0), 1U);
  write_mesh(path("a.msh"), back, 1);
  EXPECT_TRUE(same_tags(back, read_mesh(path("a.msh"), nullptr, 1)));
}

TEST_F(Plugins, TheLargestTagLeavesRoomForOthers) {
  constexpr int kMost = std::numeric_limits<int>::max();
  const TetMesh m = with_tags({kMost, 0, std::numeric_limits<int>::min()}, {kMost, 0});
  for (const std::string ending : {".msh", ".unv", ".bdf", ".inp", ".e"}) {
    write_mesh(path("a" + ending), m, 1);
    const TetMesh back = read_mesh(path("a" + ending), nullptr, 1);
    const std::set<int> regions = distinct(back.tet_tags);
    const std::set<int> patches = distinct(back.triangle_tags);
    EXPECT_EQ(regions.size(), 3U) << ending;
    EXPECT_EQ(patches.size(), ending == ".inp" ? 1U : 2U) << ending;  // triangles without a tag are in no surface
    if (ending == ".inp") {
      EXPECT_EQ(tagged(back.tets, back.tet_tags), tagged(m.tets, m.tet_tags));
    } else if (ending == ".msh") {
      EXPECT_TRUE(same_tags(m, back));
    } else {
      EXPECT_GE(*regions.begin(), 0) << ending;
      EXPECT_GE(*patches.begin(), 0) << ending;
    }
    EXPECT_EQ(regions.count(kMost), ending == ".bdf" ? 0U : 1U) << ending;
  }
}

TEST_F(Plugins, ElementsOfSeveralGroupsGetOneNameInExodus) {
  TetMesh m = with_tags({1, 2, 3}, {4, 77777});
  m.groups = {{3, 1, "all", {1, 2, 3}}, {3, 2, "part", {2}}, {2, 1, "load", {4, 77777}}};
  std::vector<std::string> warnings;
  const auto warned = [&warnings](const std::string& text) {
    return std::any_of(warnings.begin(), warnings.end(),
                       [&](const std::string& w) { return w.find(text) != std::string::npos; });
  };
  write_mesh(path("a.e"), m, 1, &warnings);
  EXPECT_TRUE(warned("group with the fewest tags"));
  const auto tags_of = [](const TetMesh& mesh, const std::string& name) {
    const auto at =
        std::find_if(mesh.groups.begin(), mesh.groups.end(), [&](const Group& g) { return g.name == name; });
    return at == mesh.groups.end() ? std::set<int>{} : std::set<int>(at->tags.begin(), at->tags.end());
  };
  const TetMesh back = read_mesh(path("a.e"), nullptr, 1);
  EXPECT_EQ(back.groups.size(), 3U);
  EXPECT_EQ(tags_of(back, "all"), (std::set<int>{1, 3}));
  EXPECT_EQ(tags_of(back, "part"), std::set<int>{2});
  EXPECT_EQ(tags_of(back, "load"), (std::set<int>{4, 77777}));
  EXPECT_TRUE(same_tags(m, back));
  // Programs that count from 0: the number of the second side set, big-endian.
  std::string bytes = get("a.e");
  const std::size_t at = bytes.find(std::string("\0\1\x2f\xd1", 4));
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at, 4, std::string(4, '\0'));
  const TetMesh from_0 = read_mesh(put("b.e", bytes), &warnings, 1);
  EXPECT_TRUE(warned("side set 0 gets the tag 5"));
  EXPECT_EQ(tags_of(from_0, "load"), (std::set<int>{4, 5}));
  write_mesh(path("b.msh"), from_0, 1);
  EXPECT_EQ(tags_of(read_mesh(path("b.msh"), nullptr, 1), "load").size(), 1U);  // elements of the same groups
}

TEST_F(Plugins, LossesAreNamedAsByOtherWriters) {
  TetMesh mesh = two_materials(2);
  mesh.groups = {{2, 90, "inlet", {90}}};
  mesh.others = {{"Quadrilaterals", 4, {0, 1, 4, 3}, {1}, {0}}};
  const auto has = [&](const std::string& name, const std::string& text) {
    std::vector<std::string> warnings;
    write_mesh(path(name), mesh, 1, &warnings);
    return std::find(warnings.begin(), warnings.end(), path(name) + ": " + text) != warnings.end();
  };
  const std::string lists = "the format cannot hold lists of corners, ridges and required entities";
  for (const char* const name : {"a.e", "a.unv", "a.bdf"}) EXPECT_TRUE(has(name, lists)) << name;
  const std::string group = "the group \"inlet\" has no elements; it is not written";
  for (const char* const name : {"a.e", "a.unv"}) EXPECT_TRUE(has(name, group)) << name;
  const std::string names = "the format cannot hold the names of groups";
  for (const char* const name : {"a.vtu", "a.vtk", "a.bdf"}) EXPECT_TRUE(has(name, names)) << name;
}

TEST_F(Plugins, TagsComeUnderTheNamesThatOtherProgramsGiveThem) {
  for (const std::string name : {"medit:ref", "gmsh:physical", "tetgen:ref", "refs", "gmsh:geometrical"}) {
    TetMesh m = rich();
    m.cell_tags_name = name;
    m.tet_data.push_back({"gmsh:other", 1, std::vector<std::int64_t>(m.tets.size(), 9)});
    write_mesh(path("a.vtu"), m, 1);
    const TetMesh back = read_mesh(path("a.vtu"), nullptr, 1);
    EXPECT_EQ(back.cell_tags_name, name);
    EXPECT_EQ(back.tet_tags, m.tet_tags);
    ASSERT_NE(find(back.tet_data, "gmsh:other"), nullptr);
    EXPECT_EQ(doubles(*find(back.tet_data, "gmsh:other")), std::vector<double>(m.tets.size(), 9));
  }
}

TEST_F(Plugins, VtkKeepsTheTypesOfData) {
  TetMesh m = cube(2);
  const std::size_t n = m.points.size();
  m.point_data = {{"f8", 1, std::vector<double>(n, 0.1)},      {"f4", 2, std::vector<float>(2 * n, 0.1F)},
                  {"i1", 1, std::vector<std::int8_t>(n, -1)},  {"u1", 1, std::vector<std::uint8_t>(n, 255)},
                  {"i2", 1, std::vector<std::int16_t>(n, -2)}, {"u2", 1, std::vector<std::uint16_t>(n, 65535)},
                  {"i4", 1, std::vector<std::int32_t>(n, -3)}, {"u4", 1, std::vector<std::uint32_t>(n, 4294967295U)},
                  {"i8", 1, std::vector<std::int64_t>(n, -4)}, {"u8", 9, std::vector<std::uint64_t>(9 * n, 5)}};
  write_mesh(path("a.vtu"), m, 1);
  const TetMesh back = read_mesh(path("a.vtu"), nullptr, 1);
  ASSERT_EQ(back.point_data.size(), m.point_data.size());
  for (std::size_t i = 0; i < m.point_data.size(); ++i) {
    EXPECT_EQ(back.point_data[i].name, m.point_data[i].name);
    EXPECT_EQ(back.point_data[i].components, m.point_data[i].components);
    EXPECT_EQ(back.point_data[i].values, m.point_data[i].values) << m.point_data[i].name;
  }
}

TEST_F(Plugins, InsideOutMeshesAreWrittenAsTheyCame) {
  for (const std::string name : {"a.vtu", "a.msh"}) {
    TetMesh m = cube(2);
    m.tet_tags.assign(m.tets.size(), 1);
    m.listed_inside_out = true;
    write_mesh(path(name), m, 1);
    const TetMesh back = read_mesh(path(name), nullptr, 1);
    EXPECT_TRUE(back.listed_inside_out);
    EXPECT_EQ(back.tets, m.tets);
  }
}

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

TEST_F(Plugins, ReadWhereStandardStreamsAreClosed) {
  write_mesh(path("a.vtu"), cube(2), 1);
  const int kept = ::dup(STDIN_FILENO);
  ::close(STDIN_FILENO);
  const std::string error = read_error(path("a.vtu"));
  if (kept >= 0) {
    ::dup2(kept, STDIN_FILENO);
    ::close(kept);
  }
  EXPECT_EQ(error, "");
}

/// The elements with a tag and their vertices, with the curved edges and other elements between these.
TetMesh part_of(const TetMesh& m, int tag) {
  TetMesh part;
  part.second_order = m.second_order;
  std::vector<Index> old2new(m.points.size(), -1);
  const auto now = [&old2new](Index v) { return old2new[static_cast<std::size_t>(v)]; };
  for (std::size_t t = 0; t < m.tets.size(); ++t) {
    if (m.tet_tags[t] != tag) continue;
    auto tet = m.tets[t];
    for (Index& v : tet) {
      Index& number = old2new[static_cast<std::size_t>(v)];
      if (number < 0) {
        number = static_cast<Index>(part.points.size());
        part.points.push_back(m.points[static_cast<std::size_t>(v)]);
      }
      v = number;
    }
    part.tets.push_back(tet);
    part.tet_tags.push_back(tag);
  }
  part.point_tags.assign(part.points.size(), 0);
  for (const CurvedEdge& e : m.curved_edges) {
    const Index a = now(e.vertices[0]), b = now(e.vertices[1]);
    if (a >= 0 && b >= 0) part.curved_edges.push_back({{std::min(a, b), std::max(a, b)}, e.middle});
  }
  std::sort(part.curved_edges.begin(), part.curved_edges.end(),
            [](const CurvedEdge& x, const CurvedEdge& y) { return x.vertices < y.vertices; });
  for (ElementBlock block : m.others) {
    for (Index& v : block.element2vertex) v = now(v);
    if (std::count(block.element2vertex.begin(), block.element2vertex.end(), -1) == 0) part.others.push_back(block);
  }
  return part;
}

const char* const kTwoParts =
    R"(<VTKFile type="PUnstructuredGrid" version="1.0"><PUnstructuredGrid GhostLevel="0"><PCellData>)"
    R"(<PDataArray type="Int32" Name="medit:ref"/></PCellData><PPoints><PDataArray type="Float64" NumberOfComponents="3"/>)"
    R"(</PPoints><Piece Source="part1.vtu"/><Piece Source="part2.vtu"/></PUnstructuredGrid></VTKFile>)";

TEST_F(Plugins, PartsAreJoinedWhereTheyMeet) {
  const TetMesh m = two_materials(4);
  for (int part = 1; part <= 2; ++part) write_mesh(path("part" + std::to_string(part) + ".vtu"), part_of(m, part), 1);
  const TetMesh joined = read_mesh(put("a.pvtu", kTwoParts), nullptr, 1);
  EXPECT_EQ(joined.points.size(), m.points.size());
  EXPECT_EQ(joined.tets.size(), m.tets.size());
  EXPECT_TRUE(validate(joined).ok());
  EXPECT_EQ(std::set<int>(joined.tet_tags.begin(), joined.tet_tags.end()), (std::set<int>{1, 2}));
}

/// The curved edges of a mesh, by positions.
std::set<std::pair<std::set<Point3>, Point3>> curved_places(const TetMesh& m) {
  std::set<std::pair<std::set<Point3>, Point3>> places;
  const auto at = [&m](Index v) { return m.points[static_cast<std::size_t>(v)]; };
  for (const CurvedEdge& e : m.curved_edges) places.insert({{at(e.vertices[0]), at(e.vertices[1])}, e.middle});
  return places;
}

TEST_F(Plugins, PartsOfSecondOrderAreJoinedWithTheirCurvedEdges) {
  TetMesh m = two_materials(4);
  std::set<std::array<Index, 2>> edges;
  for (const auto& tet : m.tets) {
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b < a; ++b) edges.insert({std::min(tet[a], tet[b]), std::max(tet[a], tet[b])});
    }
  }
  m.second_order = true;
  for (const auto& [a, b] : edges) {  // all, also those between both parts
    const Point3 p = m.points[static_cast<std::size_t>(a)], q = m.points[static_cast<std::size_t>(b)];
    m.curved_edges.push_back({{a, b}, {(p[0] + q[0]) / 2, (p[1] + q[1]) / 2 + 0.01, (p[2] + q[2]) / 2}});
  }
  // An element of another kind in each part, behind whose vertices the file has mid-side nodes.
  for (const auto& tet : {m.tets[0], m.tets.back()}) {
    m.others.push_back({"Quadrilaterals", 4, {tet.begin(), tet.end()}, {5}, {}});
  }
  for (int part = 1; part <= 2; ++part) write_mesh(path("part" + std::to_string(part) + ".vtu"), part_of(m, part), 1);
  const TetMesh joined = read_mesh(put("a.pvtu", kTwoParts), nullptr, 1);
  EXPECT_EQ(joined.points.size(), m.points.size());
  EXPECT_EQ(joined.curved_edges.size(), m.curved_edges.size());
  EXPECT_EQ(curved_places(joined), curved_places(m));
  EXPECT_TRUE(validate(joined).ok());
  ASSERT_EQ(joined.others.size(), 1U);
  std::vector<Point3> places;
  for (const Index v : joined.others[0].element2vertex) places.push_back(joined.points[static_cast<std::size_t>(v)]);
  std::vector<Point3> expected;
  for (const ElementBlock& block : m.others) {
    for (const Index v : block.element2vertex) expected.push_back(m.points[static_cast<std::size_t>(v)]);
  }
  EXPECT_EQ(places, expected);
}

TEST_F(Plugins, OtherKindsFreezeWhatTheyShare) {
  // A pyramid on two triangles of the cube's side.
  TetMesh m = cube(4, 0.2);
  const TetMesh regular = cube(4);
  const auto at = [&regular](double y, double z) {
    for (std::size_t v = 0; v < regular.points.size(); ++v) {
      if (regular.points[v] == Point3{1, y, z}) return static_cast<Index>(v);
    }
    return Index{-1};
  };
  const std::vector<Index> base{at(0, 0), at(0.25, 0), at(0.25, 0.25), at(0, 0.25)};
  m.points.push_back({1.3, 0.1, 0.1});
  m.point_tags.push_back(0);
  ElementBlock pyramid{"Pyramids", 5, base, {8}, {}};
  ASSERT_EQ(std::count(base.begin(), base.end(), -1), 0);
  pyramid.element2vertex.push_back(static_cast<Index>(m.points.size()) - 1);
  m.others = {pyramid};
  write_mesh(path("a.vtu"), m, 1);
  TetMesh read = read_mesh(path("a.vtu"), nullptr, 1);
  optimize(read);
  ASSERT_EQ(read.others.size(), 1U);
  EXPECT_EQ(read.others[0].element2vertex, pyramid.element2vertex);
  for (const Index v : pyramid.element2vertex) {
    EXPECT_EQ(read.points[static_cast<std::size_t>(v)], m.points[static_cast<std::size_t>(v)]);
  }
}

TEST_F(Plugins, DamagedFilesAreErrorsAndNothingElse) {
  const TetMesh m = rich(false);
  for (const std::string ending : {".vtu", ".vtk", ".e", ".msh", ".unv"}) {
    SCOPED_TRACE(ending);
    write_mesh(path("whole" + ending), m, 1);
    const std::string whole = get("whole" + ending);
    int refused = 0;
    for (std::size_t i = 0; i < 6; ++i) {
      std::string damaged = whole;
      if (i < 3) {
        damaged.resize(whole.size() * (i + 1) / 5);
      } else {
        const std::size_t from = whole.size() * (i - 2) / 5;
        for (std::size_t k = from; k < from + 64; ++k) damaged[k] = static_cast<char>(255 - i);
      }
      const std::string error = read_error(put("damaged" + ending, damaged));
      if (error.empty()) continue;
      ++refused;
      EXPECT_TRUE(contains(error, path("damaged" + ending)));
    }
    EXPECT_GE(refused, ending == ".unv" ? 2 : 4);
    EXPECT_NE(read_error(put("empty" + ending, "")), "");
    EXPECT_NE(read_error(put("text" + ending, "this is no mesh\n")), "");
  }
}

TEST_F(Plugins, ScriptsAreNotRun) {
  for (const std::string ending : {".msh", ".unv", ".bdf", ".vtu"}) {
    EXPECT_NE(read_error(put("a" + ending, "SystemCall \"touch " + path("ran") + "\";\n")), "");
  }
  EXPECT_FALSE(std::filesystem::exists(path("ran")));
}

TEST_F(Plugins, AFailedWriteLeavesTheOldFile) {
  TetMesh m = cube(2);
  m.others = {{"Heptahedra", 7, {0, 1, 2, 3, 4, 5, 6}, {1}, {}}};
  for (const std::string name : {"a.vtu", "a.msh", "a.e"}) {
    put(name, "old");
    EXPECT_THROW(write_mesh(path(name), m, 1), FileError);
    EXPECT_EQ(get(name), "old");
  }
  EXPECT_EQ(files().size(), 3U);
}

}  // namespace
}  // namespace tetune::test

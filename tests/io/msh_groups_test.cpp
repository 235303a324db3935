// SPDX-License-Identifier: Apache-2.0
// Groups, names and entities of Gmsh's files.
#include <algorithm>
#include <set>

#include "mesh_contents.hpp"
#include "msh_fixture.hpp"
#include "tetune/optimize.hpp"
#include "tetune/validate.hpp"

namespace tetune::test {
namespace {

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

TEST_F(Msh, ATagOfTheNumberOfAnotherGroupDoesNotJoinIt) {
  TetMesh m = cube(2, 0.1);
  for (std::size_t t = 0; t < m.tets.size(); ++t) m.tet_tags[t] = t % 3 == 0 ? 3 : 2;
  m.groups = {{3, 1, "wood", {}}, {3, 2, "steel", {3}}};
  for (const std::string& dialect : kDialects) {
    m.dialect = dialect;
    std::vector<std::string> warnings;
    write_mesh(path("a.msh"), m, 1, &warnings);
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_TRUE(contains(warnings[0], "with the tag 2, which is in no group, get the tag 3"));
    const TetMesh back = read_mesh(path("a.msh"), nullptr, 1);
    TetMesh expected = m;
    for (int& tag : expected.tet_tags) tag = tag == 3 ? 2 : 3;
    EXPECT_EQ(tagged(back.tets, back.tet_tags), tagged(expected.tets, expected.tet_tags)) << dialect;
    const auto steel =
        std::find_if(back.groups.begin(), back.groups.end(), [](const Group& group) { return group.name == "steel"; });
    ASSERT_NE(steel, back.groups.end()) << dialect;
    EXPECT_EQ(steel->tags, std::vector<int>{2});
  }
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

TEST_F(Msh, ManyTagsInNoGroupAreOneWarning) {
  std::vector<std::string> warnings;
  write_mesh(path("a.msh"), with_tags({-1, -2, -3}, {5}), 1, &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "elements of dimension 3 with the tag -1 are entity 1, in no group"));
  EXPECT_TRUE(contains(warnings[0], "likewise those with 2 more tags"));
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

// SPDX-License-Identifier: Apache-2.0
// Formats through VTK and Gmsh: tags and groups.
#include <algorithm>
#include <limits>
#include <set>

#include "mesh_contents.hpp"
#include "plugin_fixture.hpp"

namespace tetune::test {
namespace {

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
  const TetMesh m = with_tags({0, 3, -7, -3});
  std::vector<std::string> warnings;
  write_mesh(path("a.bdf"), m, 1, &warnings);
  EXPECT_TRUE(contains(warnings, "and 2 more"));
  EXPECT_EQ(distinct(read_mesh(path("a.bdf"), nullptr, 1).tet_tags), (std::set{1, 2, 3, 7}));
  warnings.clear();
  write_mesh(path("a.unv"), m, 1, &warnings);
  EXPECT_TRUE(contains(warnings, "and 1 more"));
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
  write_mesh(path("a.e"), m, 1, &warnings);
  EXPECT_TRUE(contains(warnings, "group with the fewest tags"));
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
  EXPECT_TRUE(contains(warnings, "side set 0 gets the tag 5"));
  EXPECT_EQ(tags_of(from_0, "load"), (std::set<int>{4, 5}));
  write_mesh(path("b.msh"), from_0, 1);
  EXPECT_EQ(tags_of(read_mesh(path("b.msh"), nullptr, 1), "load").size(), 1U);  // elements of the same groups
}

TEST_F(Plugins, DataWithTheNameOfTagsAreRenamedInFilesOfVtk) {
  for (const std::string tags_name : {"", "gmsh:physical"}) {
    TetMesh m = with_tags({5, 9}, {1});
    m.cell_tags_name = m.point_tags_name = tags_name;
    m.point_tags[0] = 3;
    const std::string name = tags_name.empty() ? "medit:ref" : tags_name;
    m.tet_data = {{name, 1, std::vector<double>(m.tets.size(), 1)},
                  {name + ":before", 1, std::vector<double>(m.tets.size(), 2)}};
    m.triangle_data = {{name, 1, std::vector<double>(m.triangles.size(), 4)}};
    m.point_data = {{name, 1, std::vector<double>(m.points.size(), 8)}};
    for (const std::string ending : {".vtu", ".vtk"}) {
      std::vector<std::string> warnings;
      write_mesh(path("a" + ending), m, 1, &warnings);
      EXPECT_TRUE(contains(warnings, "the cell data \"" + name + "\" are renamed to \"" + name + ":before:before\""));
      EXPECT_TRUE(contains(warnings, "the point data \"" + name + "\" are renamed to \"" + name + ":before\""));
      const TetMesh back = read_mesh(path("a" + ending), nullptr, 1);
      EXPECT_TRUE(same_tags(m, back)) << ending;
      EXPECT_EQ(back.point_tags, m.point_tags) << ending;
      const std::vector<std::pair<const std::vector<DataArray>*, std::string>> renamed{
          {&back.tet_data, ":before:before"}, {&back.triangle_data, ":before:before"}, {&back.point_data, ":before"}};
      const std::vector<double> values{1, 4, 8};
      for (std::size_t i = 0; i < renamed.size(); ++i) {
        const DataArray* const array = find(*renamed[i].first, name + renamed[i].second);
        ASSERT_NE(array, nullptr) << ending << " " << i;
        EXPECT_EQ(doubles(*array)[0], values[i]) << ending << " " << i;
      }
    }
  }
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

}  // namespace
}  // namespace tetune::test

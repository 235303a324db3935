// SPDX-License-Identifier: Apache-2.0
// Names of data in VTK's legacy files and Exodus, and contents of Exodus files that are not kept.
#include <algorithm>
#include <set>

#include "mesh_contents.hpp"
#include "netcdf_file.hpp"
#include "plugin_fixture.hpp"

namespace tetune::test {
namespace {

std::vector<std::string> names_of(const std::vector<DataArray>& data) {
  std::vector<std::string> names;
  for (const DataArray& array : data) names.push_back(array.name);
  return names;
}

DataArray numbered(const std::string& name, int components, std::size_t entries, double first) {
  std::vector<double> values;
  for (std::size_t i = 0; i < entries * static_cast<std::size_t>(components); ++i) {
    values.push_back(first + static_cast<double>(i));
  }
  return {name, components, std::move(values)};
}

std::size_t warnings_with(const std::vector<std::string>& warnings, const std::string& part) {
  return static_cast<std::size_t>(std::count_if(
      warnings.begin(), warnings.end(), [&](const std::string& w) { return w.find(part) != std::string::npos; }));
}

TEST_F(Plugins, LongNamesInLegacyFilesAreShortened) {
  TetMesh m = cube(2);
  const std::string fits(255, 'f');
  const std::string too_long(256, 'f');
  const std::string longest(400, 'f');
  std::string accents;  // a byte that is not ASCII takes three characters
  for (int i = 0; i < 43; ++i) accents += "\xC3\xB6";
  const std::size_t n = m.points.size();
  m.point_data = {numbered(fits, 1, n, 0), numbered(too_long, 1, n, 1), numbered(longest, 3, n, 2),
                  numbered(accents, 1, n, 3), numbered("last", 1, n, 4)};
  m.tet_data = {numbered(too_long, 1, m.tets.size(), 5)};
  std::vector<std::string> warnings;
  write_mesh(path("a.vtk"), m, 1, &warnings);
  const std::string second = std::string(253, 'f') + "~2";
  const std::string third = std::string(253, 'f') + "~3";
  const std::string without_last = accents.substr(0, 84);
  const TetMesh back = read_mesh(path("a.vtk"), nullptr, 1);
  EXPECT_EQ(names_of(back.point_data), (std::vector{fits, second, third, without_last, std::string("last")}));
  EXPECT_EQ(names_of(back.tet_data), std::vector{second});
  ASSERT_EQ(back.point_data.size(), m.point_data.size());
  for (std::size_t i = 0; i < m.point_data.size(); ++i)
    EXPECT_EQ(doubles(back.point_data[i]), doubles(m.point_data[i]));
  EXPECT_EQ(warnings.size(), 3U);
  EXPECT_EQ(warnings_with(warnings, "\"" + too_long + "\""), 1U);
  EXPECT_EQ(warnings_with(warnings, "\"" + second + "\""), 1U);
  warnings.clear();
  write_mesh(path("a.vtu"), m, 1, &warnings);
  EXPECT_TRUE(warnings.empty());
}

TEST_F(Plugins, LongNamesInExodusAreShortened) {
  TetMesh m = two_materials(2);
  const std::string start(254, 's');
  const std::size_t n = m.points.size();
  m.point_data = {numbered(start + "a", 1, n, 0), numbered(start + "ab", 1, n, 1), numbered(start + "ac", 1, n, 2),
                  numbered(start, 3, n, 3), numbered(start + "t", 12, n, 4)};
  m.point_data.push_back({"node_set:3:" + start + "ab", 1, std::vector<std::uint8_t>(n, 1)});
  m.groups = {{3, 1, start + "xy", {1}}, {3, 2, start + "xz", {2}}};
  std::vector<std::string> warnings;
  write_mesh(path("a.e"), m, 1, &warnings);
  EXPECT_EQ(warnings_with(warnings, "the name of the data"), 4U);
  EXPECT_EQ(warnings_with(warnings, "the name of the group"), 2U);
  EXPECT_EQ(warnings_with(warnings, "the name of the node set"), 1U);
  const TetMesh back = read_mesh(path("a.e"), nullptr, 1);
  const auto s = [](std::size_t count) { return std::string(count, 's'); };
  const std::vector<std::string> expected{
      "node_set:3:" + s(254) + "a", s(254) + "a", s(253) + "~2", s(253) + "~3", s(253), s(252)};
  EXPECT_EQ(names_of(back.point_data), expected);
  for (std::size_t i = 0; i + 1 < back.point_data.size(); ++i) {
    EXPECT_EQ(doubles(back.point_data[i + 1]), doubles(m.point_data[i])) << i;
  }
  ASSERT_EQ(back.groups.size(), 2U);
  EXPECT_NE(back.groups[0].name, back.groups[1].name);
  EXPECT_EQ(distinct(back.tet_tags).size(), 2U);
}

TEST_F(Plugins, ArraysOfAnyNumberOfComponentsComeBackFromExodus) {
  TetMesh m = cube(2);
  const std::size_t n = m.points.size();
  for (const int each : {1, 2, 3, 4, 6, 9, 12}) {
    m.point_data.push_back(numbered("p" + std::to_string(each), each, n, each));
    m.tet_data.push_back(numbered("t" + std::to_string(each), each, m.tets.size(), each));
  }
  write_mesh(path("a.e"), m, 1);
  const TetMesh back = read_mesh(path("a.e"), nullptr, 1);
  EXPECT_EQ(names_of(back.point_data), names_of(m.point_data));
  EXPECT_EQ(names_of(back.tet_data), names_of(m.tet_data));
  EXPECT_TRUE(same_point_data(m, back));
  // Three numbered scalars, two coordinates of three that are apart, and names with an array of their own.
  TetMesh scalars = cube(2);
  for (const char* const name :
       {"a_1", "a_2", "a_3", "b_X", "b_Y", "c", "b_Z", "c_1", "c_2", "c_3", "c_4", "d_2", "d_3", "d_4", "d_5"}) {
    scalars.point_data.push_back(numbered(name, 1, n, 0));
  }
  write_mesh(path("scalars.e"), scalars, 1);
  EXPECT_EQ(names_of(read_mesh(path("scalars.e"), nullptr, 1).point_data), names_of(scalars.point_data));
}

TEST_F(Plugins, ComponentsWithoutAnUnderscoreAreOneArrayAsVtkWritesThem) {
  TetMesh m = cube(2);
  for (const char* const name : {"dispX", "dispY", "dispZ", "flatX", "flatY", "X", "Y", "Z", "velX", "velY", "lowx",
                                 "lowy", "lowz", "velZ", "oneX", "hasX", "hasY", "hasZ", "has"}) {
    m.point_data.push_back(numbered(name, 1, m.points.size(), static_cast<double>(m.point_data.size())));
  }
  m.tet_data = {numbered("fluxX", 1, m.tets.size(), 0), numbered("fluxY", 1, m.tets.size(), 1)};
  write_mesh(path("a.e"), m, 1);
  const TetMesh back = read_mesh(path("a.e"), nullptr, 1);
  const std::vector<std::string> names{"disp", "flat", "X",    "Y",    "Z",    "velX", "velY", "lowx",
                                       "lowy", "lowz", "velZ", "oneX", "hasX", "hasY", "hasZ", "has"};
  EXPECT_EQ(names_of(back.point_data), names);
  EXPECT_EQ(back.point_data[0].components, 3);
  EXPECT_EQ(back.point_data[1].components, 2);
  const std::vector<double> values = std::get<std::vector<double>>(back.point_data[0].values);
  EXPECT_EQ(std::vector<double>(values.begin(), values.begin() + 6), (std::vector<double>{0, 1, 2, 1, 2, 3}));
  EXPECT_EQ(names_of(back.tet_data), std::vector<std::string>{"flux"});
}

TEST_F(Plugins, IntegersThatExodusRoundsAreAWarning) {
  TetMesh m = cube(2);
  const std::size_t n = m.points.size();
  constexpr std::int64_t kExact = std::int64_t{1} << 53;
  m.point_data = {{"exact", 1, std::vector<std::int64_t>(n, -kExact)},
                  {"low", 1, std::vector<std::int64_t>(n, -kExact - 1)},
                  {"real", 1, std::vector<double>(n, 1e300)}};
  std::vector<std::uint64_t> ids(m.tets.size(), 1);
  ids.back() = ~std::uint64_t{0};
  m.tet_data = {{"ids", 1, ids}};
  std::vector<std::string> warnings;
  write_mesh(path("a.e"), m, 1, &warnings);
  EXPECT_EQ(warnings_with(warnings, "integers beyond 2^53"), 1U);
  EXPECT_EQ(warnings_with(warnings, "are rounded, as Exodus stores doubles: data \"ids\", \"low\""), 1U);
}

TEST_F(Plugins, NodeSetsOfExodusHaveDifferentNumbers) {
  TetMesh m = cube(2);
  const auto only = [n = m.points.size()](std::size_t vertex) {
    std::vector<std::uint8_t> flags(n, 0);
    flags[vertex] = 1;
    return flags;
  };
  m.point_data = {{"node_set:2:first", 1, only(0)},
                  {"node_set:2:second", 1, only(1)},
                  {"node_set:hot wall", 1, only(2)},
                  {"node_set:1", 1, only(3)}};
  std::vector<std::string> warnings;
  write_mesh(path("a.e"), m, 1, &warnings);
  EXPECT_EQ(warnings_with(warnings, "2 node sets get other numbers"), 1U);
  const TetMesh back = read_mesh(path("a.e"), nullptr, 1);
  EXPECT_EQ(names_of(back.point_data),
            (std::vector<std::string>{"node_set:2:first", "node_set:3:second", "node_set:4", "node_set:1"}));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(doubles(back.point_data[i]), doubles(m.point_data[i])) << i;
}

TEST_F(Plugins, ASideSetOfANegativeTagKeepsItsName) {
  TetMesh m = cube(2);
  const auto& [a, b, c, d] = m.tets[0];
  m.triangles = {{a, c, b}, {a, b, d}};
  m.triangle_tags = {1, -7};
  m.groups = {{2, 1, "wall", {-7}}};
  std::vector<std::string> warnings;
  write_mesh(path("a.e"), m, 1, &warnings);
  EXPECT_EQ(warnings_with(warnings, "the tag -7 is side set 2"), 1U);
  const TetMesh back = read_mesh(path("a.e"), nullptr, 1);
  const auto wall = std::find_if(back.groups.begin(), back.groups.end(),
                                 [](const Group& g) { return g.dimension == 2 && g.name == "wall"; });
  ASSERT_NE(wall, back.groups.end());
  EXPECT_EQ(wall->tags, std::vector{2});
}

/// The values of an Exodus file that are not kept: those that all files have, or others.
enum class UnkeptValues { usual, special };

/// A tetrahedron with a side set and a node set.
std::string exodus_file(UnkeptValues values) {
  const bool special = values == UnkeptValues::special;
  NetCdfFile file;
  const auto real = [special](double value) { return special ? value : 1.0; };
  const auto whole = [special](int value, int plain) { return special ? value : plain; };
  file.add_attribute("api_version", std::vector{5.0F});
  file.add_attribute("version", std::vector{5.0F});
  file.add_attribute("floating_point_word_size", std::vector{8});
  file.add_attribute("file_size", std::vector{1});
  file.add_dimension("len_string", 33);
  file.add_dimension("four", 4);
  file.add_dimension("time_step", 0);
  file.add_dimension("num_dim", 3);
  file.add_dimension("num_nodes", 4);
  for (const char* const one :
       {"num_elem", "num_el_blk", "num_el_in_blk1", "num_side_sets", "num_side_ss1", "num_node_sets", "num_nod_ns1"}) {
    file.add_dimension(one, 1);
  }
  file.add_dimension("num_nod_per_el1", 4);
  file.add_dimension("num_df_ss1", 3);
  file.add_variable("coordx", {"num_nodes"}, std::vector{0.0, 1.0, 0.0, 0.0});
  file.add_variable("coordy", {"num_nodes"}, std::vector{0.0, 0.0, 1.0, 0.0});
  file.add_variable("coordz", {"num_nodes"}, std::vector{0.0, 0.0, 0.0, 1.0});
  const auto add_ids = [&file](const std::string& kind, const std::string& dimension, int id) {
    file.add_variable(kind + "_status", {dimension}, std::vector{1});
    file.add_variable(kind + "_prop1", {dimension}, std::vector{id}, {{"name", std::string("ID")}});
  };
  add_ids("eb", "num_el_blk", 4);
  add_ids("ss", "num_side_sets", 5);
  add_ids("ns", "num_node_sets", 6);
  file.add_variable("connect1", {"num_el_in_blk1", "num_nod_per_el1"}, std::vector{1, 2, 3, 4},
                    {{"elem_type", std::string("TETRA")}});
  file.add_variable("elem_ss1", {"num_side_ss1"}, std::vector{1});
  file.add_variable("side_ss1", {"num_side_ss1"}, std::vector{1});
  file.add_variable("dist_fact_ss1", {"num_df_ss1"}, std::vector{1.0, real(0.5), 1.0});
  file.add_variable("node_ns1", {"num_nod_ns1"}, std::vector{2});
  file.add_variable("dist_fact_ns1", {"num_nod_ns1"}, std::vector{real(2)});
  file.add_variable("node_num_map", {"num_nodes"}, std::vector{1, 2, 3, whole(40, 4)});
  file.add_variable("elem_num_map", {"num_elem"}, std::vector{whole(9, 1)});
  if (special) {
    file.add_dimension("num_att_in_blk1", 1);
    file.add_variable("attrib1", {"num_el_in_blk1", "num_att_in_blk1"}, std::vector{0.25});
    file.add_dimension("num_glo_var", 1);
    std::string name = "energy";
    name.resize(33, '\0');
    file.add_variable("name_glo_var", {"num_glo_var", "len_string"}, name);
  }
  return file.bytes();
}

TEST_F(Plugins, ContentsOfExodusThatAreNotKeptAreWarnings) {
  std::vector<std::string> warnings;
  const TetMesh plain = read_mesh(put("plain.e", exodus_file(UnkeptValues::usual)), &warnings, 1);
  EXPECT_EQ(plain.tets.size(), 1U);
  EXPECT_EQ(plain.triangle_tags, std::vector{5});
  EXPECT_EQ(names_of(plain.point_data), std::vector<std::string>{"node_set:6"});
  EXPECT_TRUE(warnings.empty());
  read_mesh(put("special.e", exodus_file(UnkeptValues::special)), &warnings, 1);
  const std::string start = path("special.e") + ": the ";
  const std::vector<std::string> expected{
      start + "attributes of the element blocks 4 are not kept",
      start + "distribution factors of the side sets 5 are not kept",
      start + "distribution factors of the node sets 6 are not kept",
      start + "global variables \"energy\" are not kept",
      start + "numbers of nodes are not kept",
      start + "numbers of elements are not kept",
  };
  EXPECT_EQ(warnings, expected);
}

}  // namespace
}  // namespace tetune::test

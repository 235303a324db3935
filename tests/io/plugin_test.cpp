// SPDX-License-Identifier: Apache-2.0
// Formats through VTK and Gmsh: written meshes are read back, and damaged files are refused.
#include "plugin_fixture.hpp"

#include <unistd.h>

#include <algorithm>

#include "mesh_contents.hpp"
#include "tetune/optimize.hpp"

namespace tetune::test {
namespace {

const char* yes(bool kept) { return kept ? "yes" : "no"; }

const std::vector<std::string> kWritten{".mesh", ".meshb", ".msh", ".inp", ".ele", ".su2",
                                        ".vol",  ".bdf",   ".unv", ".vtu", ".vtk", ".e"};

/// How the names of groups come back.
std::string names_kept(TetMesh m, const TetMesh& back) {
  // Where no edges are kept, neither are their groups.
  if (back.edges.empty()) std::erase_if(m.groups, [](const Group& g) { return g.dimension == 1; });
  if (same_groups(m, back)) return "yes";
  for (Group& g : m.groups) std::replace(g.name.begin(), g.name.end(), ' ', '_');
  return same_groups(m, back) ? "yes, blanks as `_`" : "no";
}

/// One line of the table in docs/formats.md.
/// Whether other elements with mid-side nodes come back as they were.
std::string second_order_others_kept(const std::string& file) {
  TetMesh m = rich();
  m.second_order = true;
  for (ElementBlock& block : m.others) block.second_order = block.kind != kPoints;
  const auto kept = [&] {
    try {
      write_mesh(file, m, 1);
    } catch (const FileError&) {
      return false;
    }
    const TetMesh back = read_mesh(file, nullptr, 1);
    return back.second_order && same_others(m, back) &&
           std::all_of(back.others.begin(), back.others.end(),
                       [](const ElementBlock& b) { return b.second_order || b.kind == kPoints; });
  };
  if (kept()) return "yes";
  std::erase_if(m.others, [](const ElementBlock& block) { return block.kind == "Pyramids"; });
  return kept() ? "yes, no pyramids" : "no";
}

std::string row(const std::string& ending, const std::string& file) {
  TetMesh m = rich();
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
           ending == ".inp"                  ? "20 characters"
           : ending == ".bdf" && off < 1e-14 ? "16 characters"
           : off == 0                        ? "exact"
           : off < 1e-8                      ? "rounded"
                                             : "no",
           yes(tagged(plain.tets, plain.tet_tags) == tagged(m.tets, m.tet_tags)),
           yes(tagged(plain.triangles, plain.triangle_tags) == tagged(m.triangles, m.triangle_tags)),
           yes(tagged(plain.edges, plain.edge_tags) == tagged(m.edges, m.edge_tags)),
           yes(lists.point_tags == listed.point_tags), points ? "yes" : "no", yes(same_others(m, plain) && !no_others),
           yes(lists.corners == listed.corners && lists.ridges == listed.ridges &&
               lists.required_edges == listed.required_edges && lists.required_triangles == listed.required_triangles &&
               std::find(lists.required_vertices.begin(), lists.required_vertices.end(), 3) !=
                   lists.required_vertices.end()),
           names_kept(m, plain), yes(same_point_data(m, plain)), yes(cells(plain)),
           yes(quadratic.second_order && farthest(second, quadratic) < 1e-8), second_order_others_kept(file)}) {
    line += " " + cell + " |";
  }
  return line + "\n";
}

TEST_F(Plugins, TheTableInTheDocumentationIsTrue) {
  std::string table =
      "| | coordinates | region tags | triangle tags | edge tags | vertex tags | point elements | other kinds | "
      "corners, "
      "ridges, required | names of groups | vertex data | cell data | second order | other kinds of second order |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const std::string& ending : kWritten) table += row(ending, path("mesh" + ending));
  std::ifstream file(TETUNE_DOCS "/formats.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(page.find(table), std::string::npos) << "docs/formats.md should have this table:\n" << table;
}

TEST_F(Plugins, EverythingWrittenIsReadAndComesWithTheRightWarnings) {
  for (const std::string& ending : kWritten) {
    SCOPED_TRACE(ending);
    std::vector<std::string> warnings;
    TetMesh m = rich();
    if (ending == ".ele") m.others.clear();
    write_mesh(path("a" + ending), m, 1, &warnings);
    EXPECT_EQ(warnings.empty(), ending == ".msh" || ending == ".e") << warnings.size();
    for (const std::string& w : warnings) EXPECT_TRUE(contains(w, path("a" + ending)));
  }
  // A loss is reported once: points, and not their groups too.
  TetMesh probed = rich_without_pyramids();
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
  const TetMesh m = rich_without_pyramids();
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

TEST_F(Plugins, VariablesOfExodusAreAVectorUnlessOneHasItsName) {
  TetMesh m = cube(2);
  const auto add = [](std::vector<DataArray>& data, std::size_t n, const std::string& name, int components) {
    data.push_back({name, components, std::vector<double>(n * static_cast<std::size_t>(components), 1)});
  };
  for (const char* const name : {"u", "u_X", "u_Y", "u_Z"}) add(m.point_data, m.points.size(), name, 1);
  add(m.point_data, m.points.size(), "v", 3);
  for (const char* const name : {"w_X", "w_Y", "w_Z", "w"}) add(m.tet_data, m.tets.size(), name, 1);
  write_mesh(path("a.e"), m, 1);
  const TetMesh read = read_mesh(path("a.e"), nullptr, 1);
  const auto names = [](const std::vector<DataArray>& data) {
    std::vector<std::string> list;
    for (const DataArray& array : data) list.push_back(array.name);
    return list;
  };
  EXPECT_EQ(names(read.point_data), names(m.point_data));
  EXPECT_EQ(names(read.tet_data), names(m.tet_data));
}

TEST_F(Plugins, ScriptsAreNotRun) {
  for (const std::string ending : {".msh", ".unv", ".bdf", ".vtu"}) {
    EXPECT_NE(read_error(put("a" + ending, "SystemCall \"touch " + path("ran") + "\";\n")), "");
  }
  EXPECT_FALSE(std::filesystem::exists(path("ran")));
}

class PluginFolders : public IoTest {};

TEST_F(PluginFolders, AreSearchedAndNamedWhereTheProgramIsMissing) {
  const Plugin plugin{"tetune-of-a-test", "Library"};
  EXPECT_THROW(add_plugin_folder("libexec"), OptionError);
  add_plugin_folder(path("plugins"));
  try {
    require_plugin(plugin, "a.vtu");
    FAIL() << "there is no such program";
  } catch (const FileError& e) {
    const std::string said = e.what();
    EXPECT_NE(said.find("no tetune-of-a-test in /"), std::string::npos) << said;
    EXPECT_NE(said.find(path("plugins")), std::string::npos) << said;
    EXPECT_NE(said.find("install Library"), std::string::npos) << said;
  }
  std::filesystem::create_directory(path("plugins"));
  put("plugins/tetune-of-a-test", "");
  EXPECT_TRUE(has_plugin(plugin));
  EXPECT_NO_THROW(require_plugin(plugin, "a.vtu"));
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

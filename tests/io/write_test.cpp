// SPDX-License-Identifier: Apache-2.0
// write_mesh leaves a whole new file or the old one, and nothing else.
#include <algorithm>

#include "io_fixture.hpp"
#include "system/file.hpp"

namespace tetune::test {
namespace {

TEST_F(IoTest, AnAbandonedOrFailedWriterCleansUp) {
  {
    FileWriter writer(path("a.mesh"));
    writer.write("half");
    TemporaryFile named(path("b.vtu"));
    put(named.name().substr(path("").size()), "half");
    EXPECT_TRUE(named.name().ends_with(".tmp.vtu"));
  }
  EXPECT_TRUE(files().empty());
  std::filesystem::create_directory(path("folder.mesh"));
  FileWriter writer(path("folder.mesh"));
  writer.write("whole");
  EXPECT_THROW(writer.commit(), FileError);
  EXPECT_EQ(files(), std::vector<std::string>{"folder.mesh"});
}

TEST_F(IoTest, BytesInMemoryReadAsTheFileDoes) {
  const TetMesh mesh = cube(3, 0.1);
  for (const std::string name : {"a.mesh", "a.meshb"}) {
    write_mesh(path(name), mesh);
    std::vector<std::string> warnings;
    expect_same(parse_mesh("bytes", get(name), &warnings), mesh);
    EXPECT_TRUE(warnings.empty());
    const std::string part = get(name).substr(0, get(name).size() * 3 / 4);
    try {
      parse_mesh("bytes", part);
      ADD_FAILURE() << "part of a file was read";
    } catch (const FileError& e) {
      EXPECT_TRUE(contains(e.what(), "bytes"));
    }
  }
  EXPECT_THROW(parse_mesh("bytes", ""), FileError);
  EXPECT_THROW(parse_mesh("bytes", std::string_view("\1\0", 2)), FileError);
}

TEST_F(IoTest, TextIsWrittenAsAWhole) {
  write_text(path("a"), "some text");
  EXPECT_EQ(get("a"), "some text");
  EXPECT_EQ(files().size(), 1U);
  EXPECT_THROW(write_text(path("absent/a"), "text"), FileError);
}

/// Windows does not replace a file that a program holds open; elsewhere that program keeps the old one.
TEST_F(IoTest, AFileThatIsOpenElsewhere) {
  put("a.mesh", "old");
  std::ifstream held(path("a.mesh"));
  const std::string error = write_error(path("a.mesh"), one_tet());
#ifdef _WIN32
  EXPECT_TRUE(contains(error, "cannot write " + path("a.mesh")));
  EXPECT_EQ(get("a.mesh"), "old");
#else
  EXPECT_EQ(error, "");
  expect_same(read_mesh(path("a.mesh")), one_tet());
#endif
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(held), {}), "old");
  EXPECT_EQ(files(), std::vector<std::string>{"a.mesh"});
}

TEST_F(IoTest, MeshesThatNoFileHolds) {
  put("a.mesh", "old");
  TetMesh unknown = one_tet();
  unknown.others.push_back({"Polyhedra", 4, {0, 1, 2, 3}, {0}, {}});
  EXPECT_TRUE(contains(write_error(path("a.mesh"), unknown), "Polyhedra"));
  EXPECT_TRUE(contains(write_error(path("a.meshb"), unknown), "Polyhedra"));
  TetMesh twice = one_tet();
  twice.others.assign(2, {"Pyramids", 5, {0, 1, 2, 3, 0}, {0}, {}});
  EXPECT_TRUE(contains(write_error(path("a.mesh"), twice), "two blocks of Pyramids"));
  TetMesh lengths = one_tet();
  lengths.point_tags.pop_back();
  EXPECT_TRUE(contains(write_error(path("a.mesh"), lengths), "vertex tags have 3 entries, and not 4"));
  lengths = one_tet();
  lengths.tet_tags.clear();
  EXPECT_TRUE(contains(write_error(path("a.mesh"), lengths), "tetrahedron tags have 0 entries, and not 1"));
  lengths = one_tet();
  lengths.triangle_tags = {1};
  EXPECT_TRUE(contains(write_error(path("a.mesh"), lengths), "triangle tags have 1 entries, and not 0"));
  lengths = one_tet();
  lengths.edge_tags = {1};
  EXPECT_TRUE(contains(write_error(path("a.mesh"), lengths), "edge tags have 1 entries, and not 0"));
  lengths = one_tet();
  lengths.others.push_back({"Prisms", 6, {0, 1, 2}, {0}, {}});
  EXPECT_TRUE(contains(write_error(path("a.mesh"), lengths), "Prisms"));
  lengths = one_tet();
  lengths.point_data = {{"heat", 2, std::vector<double>(4)}};
  EXPECT_TRUE(
      contains(write_error(path("a.mesh"), lengths), "values of \"heat\" on vertices have 4 entries, and not 8"));
  TetMesh narrow = one_tet();
  narrow.others.push_back({"Hexahedra", 4, {0, 1, 2, 3}, {0}, {}});
  EXPECT_TRUE(contains(write_error(path("a.mesh"), narrow), "vertices of Hexahedra have 4 entries, and not 8"));
  EXPECT_TRUE(contains(write_error(path("a.meshb"), narrow), "vertices of Hexahedra have 4 entries, and not 8"));
  for (std::vector<Index> TetMesh::*const list :
       {&TetMesh::corners, &TetMesh::ridges, &TetMesh::required_vertices, &TetMesh::required_edges,
        &TetMesh::required_triangles, &TetMesh::required_tets}) {
    for (const Index id : {-1, 1000000000}) {
      TetMesh unlisted = one_tet();
      (unlisted.*list) = {id};
      const std::string error = write_error(path("a.mesh"), unlisted);
      EXPECT_TRUE(contains(error, "has an index out of range (first, counted from 0: 0): index " + std::to_string(id) +
                                      ", but there are "));
      EXPECT_TRUE(contains(error, "\n  repair or remove"));
    }
  }
  EXPECT_EQ(get("a.mesh"), "old");
  EXPECT_EQ(files(), std::vector<std::string>{"a.mesh"});
}

TEST_F(IoTest, LongNamesOfFiles) {
  const std::string name = std::string(240, 'a') + ".mesh";
  write_mesh(path(name), one_tet());
  write_mesh(path(name), cube(2, 0.1));
  EXPECT_EQ(read_mesh(path(name)).tets.size(), cube(2, 0.1).tets.size());
  EXPECT_EQ(files(), std::vector<std::string>{name});
}

TEST_F(IoTest, WritersWarnOfWhatIsLost) {
  TetMesh mesh = one_tet();
  ElementBlock quads{"Quadrilaterals", 4, {0, 1, 2, 3}, {1}, {0}};
  quads.data = {{"heat", 1, std::vector<double>{20}}};
  mesh.others = {quads};
  const std::string lists = "the format cannot hold lists of corners, ridges and required entities";
  const std::string data = "the format cannot hold the data \"heat\"";
  const auto warnings_of = [&](const std::string& name) {
    std::vector<std::string> warnings;
    write_mesh(path(name), mesh, 1, &warnings);
    for (std::string& warning : warnings) warning.erase(0, path(name).size() + 2);
    return warnings;
  };
  const auto has = [](const std::vector<std::string>& warnings, const std::string& sought) {
    return std::find(warnings.begin(), warnings.end(), sought) != warnings.end();
  };
  for (const char* const name : {"a.msh", "a.vol", "a.su2", "a.inp"}) {
    EXPECT_TRUE(has(warnings_of(name), lists)) << name;
  }
  for (const char* const name : {"a.mesh", "a.vol", "a.su2", "a.inp"}) {
    EXPECT_TRUE(has(warnings_of(name), data)) << name;
  }
  EXPECT_FALSE(has(warnings_of("a.msh"), data));
  EXPECT_FALSE(has(warnings_of("a.mesh"), lists));
}

TEST_F(IoTest, LostDataAreOneWarning) {
  TetMesh mesh = one_tet();
  for (int i = 0; i < 12; ++i) mesh.tet_data.push_back({"a" + std::to_string(10 + i), 1, std::vector<double>{1}});
  std::vector<std::string> warnings;
  write_mesh(path("a.mesh"), mesh, 1, &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("the format cannot hold the data \"a10\", \"a11\""), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[0].find("\"a17\" and 4 more"), std::string::npos) << warnings[0];
}

TEST_F(IoTest, NamedGroupsWithoutElementsAreNamedOrKept) {
  TetMesh mesh = one_tet();
  mesh.tet_tags = {4};
  mesh.triangles = {{0, 1, 2}};
  mesh.triangle_tags = {7};
  mesh.groups = {
      {3, 1, "steel", {4}}, {2, 2, "inlet", {8}}, {2, 3, "wall", {7, 9}}, {3, 4, "none", {}}, {3, 5, "", {6}}};
  const auto not_written = [&](const std::string& name) {
    std::vector<std::string> found, warnings;
    write_mesh(path(name), mesh, 1, &warnings);
    for (const std::string& warning : warnings) {
      if (contains(warning, "no elements")) found.push_back(warning.substr(path(name).size() + 2));
    }
    return found;
  };
  const std::vector<std::string> both{"the group \"inlet\" has no elements; it is not written",
                                      "the group \"none\" has no elements; it is not written"};
  EXPECT_EQ(not_written("a.vol"), both);
  EXPECT_EQ(not_written("a.inp"), both);
  EXPECT_EQ(not_written("a.msh"), std::vector<std::string>());
  EXPECT_EQ(not_written("a.su2"), std::vector<std::string>());
  std::vector<std::string> markers;
  for (const Group& group : read_mesh(path("a.su2")).groups) markers.push_back(group.name);
  std::sort(markers.begin(), markers.end());
  EXPECT_EQ(markers, (std::vector<std::string>{"inlet", "wall"}));
}

TEST_F(IoTest, PlacesThatCannotBeWritten) {
  const auto refused = [](const std::string& file, const std::string& why) {
    std::string message;
    try {
      check_writable(file);
    } catch (const FileError& e) {
      message = e.what();
    }
    EXPECT_TRUE(contains(message, why));
    EXPECT_EQ(write_error(file, one_tet()), message);
  };
  refused(path("absent/a.mesh"), "the folder " + path("absent") + " does not exist");
  refused(path("a.stl"), "known endings: .mesh .meshb");
  refused(path("a.pvtu"), "tetune reads, but does not write files of ending \".pvtu\"");
  std::filesystem::create_directory(path("folder.mesh"));
  refused(path("folder.mesh"), "is a folder");
  put("file", "");
  refused(path("file/a.mesh"), "does not exist");
  refused(path(std::string(300, 'x') + "/a.mesh"), "does not exist");
  // The name of a file itself may be too long only for the file system.
  EXPECT_NE(write_error(path(std::string(300, 'x') + ".mesh"), one_tet()), "");
}

TEST_F(IoTest, CheckWritableLeavesNothing) {
  check_writable(path("a.mesh"));
  EXPECT_TRUE(files().empty());
}

/// A name without a folder means the working folder.
TEST_F(IoTest, NamesRelativeToTheWorkingFolder) {
  const std::filesystem::path here = std::filesystem::current_path();
  std::filesystem::current_path(path("."));
  EXPECT_EQ(write_error("a.mesh", one_tet()), "");
  std::filesystem::current_path(here);
  expect_same(read_mesh(path("a.mesh")), one_tet());
}

}  // namespace
}  // namespace tetune::test

// SPDX-License-Identifier: Apache-2.0
// Meshes in memory and at open descriptors, and the end of a process during a write.
#include <fcntl.h>
#include <unistd.h>

#include "io_fixture.hpp"
#include "system/file.hpp"

namespace tetune::test {
namespace {

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

TEST_F(IoTest, DescriptorsGetTheBytesOfTheFile) {
  const TetMesh mesh = cube(3, 0.1);
  for (const bool binary : {false, true}) {
    const std::string name = binary ? "a.meshb" : "a.mesh";
    write_mesh(path(name), mesh);
    const int out = ::open(path("copy").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    ASSERT_GE(out, 0);
    write_mesh(out, "copy", binary, mesh);
    EXPECT_EQ(::write(out, "x", 1), 1) << "the descriptor stays open";
    ::close(out);
    EXPECT_EQ(get("copy"), get(name) + "x");
  }
  EXPECT_THROW(write_mesh(-1, "nowhere", false, mesh), FileError);
}

TEST_F(IoTest, TextIsWrittenAsAWhole) {
  write_text(path("a"), "some text");
  EXPECT_EQ(get("a"), "some text");
  EXPECT_EQ(files().size(), 1U);
  EXPECT_THROW(write_text(path("absent/a"), "text"), FileError);
  EXPECT_THROW(write_text("/dev/null", "text"), FileError);
}

TEST_F(IoTest, AnInterruptedWriteLeavesTheOldFileAndNoOther) {
  put("a", "old");
  const auto leave = [this] {
    FileWriter writer(path("a"));
    writer.write("new");
    std::_Exit(0);
  };
  EXPECT_EXIT(leave(), testing::ExitedWithCode(0), "");
  EXPECT_EQ(files(), std::vector<std::string>{"a"});
  EXPECT_EQ(get("a"), "old");
}

}  // namespace
}  // namespace tetune::test

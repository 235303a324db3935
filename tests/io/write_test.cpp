// SPDX-License-Identifier: Apache-2.0
// write_mesh leaves a whole new file or the old one, and nothing else.
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "io_fixture.hpp"
#include "system/file.hpp"

namespace tetune::test {
namespace {

mode_t mode_of(const std::string& file) {
  struct stat info {};
  EXPECT_EQ(::stat(file.c_str(), &info), 0);
  return info.st_mode & 0777U;
}

std::string write_error(const std::string& file, const TetMesh& mesh) {
  try {
    write_mesh(file, mesh);
  } catch (const FileError& e) {
    return e.what();
  }
  return "";
}

/// Limits the size of files while it exists, like a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : old_handler_(::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &old_);
    rlimit small = old_;
    small.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &small);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &old_);
    ::signal(SIGXFSZ, old_handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit old_{};
  sighandler_t old_handler_;
};

TEST_F(IoTest, FailingWriteLeavesTheOldFile) {
  const TetMesh mesh = cube(4);
  for (const std::string name : {"a.mesh", "a.meshb"}) {
    put(name, "old");
    std::string error;
    {
      const FullDisk full(1000);
      error = write_error(path(name), mesh);
    }
    EXPECT_TRUE(contains(error, "cannot write " + path(name)));
    EXPECT_EQ(get(name), "old");
    EXPECT_EQ(files(), std::vector<std::string>{name});
    EXPECT_EQ(write_error(path(name), mesh), "");
    EXPECT_EQ(files(), std::vector<std::string>{name});
    expect_same(read_mesh(path(name)), mesh);
    std::filesystem::remove(path(name));
  }
}

TEST_F(IoTest, FailingWriteLeavesNoNewFile) {
  {
    const FullDisk full(1000);
    EXPECT_NE(write_error(path("a.mesh"), cube(4)), "");
  }
  EXPECT_TRUE(files().empty());
}

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
  EXPECT_TRUE(contains(write_error(path("a.mesh"), lengths), "3 tags for 4 vertices"));
  lengths = one_tet();
  lengths.tet_tags.clear();
  EXPECT_TRUE(contains(write_error(path("a.mesh"), lengths), "0 tags for 1 tetrahedra"));
  lengths = one_tet();
  lengths.triangle_tags = {1};
  EXPECT_TRUE(contains(write_error(path("a.mesh"), lengths), "1 tags for 0 triangles"));
  lengths = one_tet();
  lengths.edge_tags = {1};
  EXPECT_TRUE(contains(write_error(path("a.mesh"), lengths), "1 tags for 0 edges"));
  lengths = one_tet();
  lengths.others.push_back({"Prisms", 6, {0, 1, 2}, {0}, {}});
  EXPECT_TRUE(contains(write_error(path("a.mesh"), lengths), "Prisms"));
  TetMesh narrow = one_tet();
  narrow.others.push_back({"Hexahedra", 4, {0, 1, 2, 3}, {0}, {}});
  EXPECT_TRUE(contains(write_error(path("a.mesh"), narrow), "Hexahedra have 8 vertices each, and not 4"));
  EXPECT_TRUE(contains(write_error(path("a.meshb"), narrow), "Hexahedra have 8 vertices each, and not 4"));
  EXPECT_EQ(get("a.mesh"), "old");
  EXPECT_EQ(files(), std::vector<std::string>{"a.mesh"});
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
  if (::geteuid() != 0) {
    std::filesystem::create_directory(path("locked"));
    ASSERT_EQ(::chmod(path("locked").c_str(), 0500), 0);
    refused(path("locked/a.mesh"), "no permission to write");
    ASSERT_EQ(::chmod(path("locked").c_str(), 0700), 0);
  }
}

TEST_F(IoTest, CheckWritableLeavesNothing) {
  check_writable(path("a.mesh"));
  EXPECT_TRUE(files().empty());
}

TEST_F(IoTest, PermissionsOfANewFileFollowTheUmask) {
  const mode_t old = ::umask(027);
  write_mesh(path("a.mesh"), one_tet());
  ::umask(0);
  write_mesh(path("b.meshb"), one_tet());
  ::umask(old);
  EXPECT_EQ(mode_of(path("a.mesh")), 0640U);
  EXPECT_EQ(mode_of(path("b.meshb")), 0666U);
}

TEST_F(IoTest, PermissionsOfAnOldFileAreKept) {
  for (const mode_t mode : {0600U, 0644U, 0664U, 0444U, 0755U}) {
    put("a.mesh", "old");
    ASSERT_EQ(::chmod(path("a.mesh").c_str(), mode), 0);
    write_mesh(path("a.mesh"), one_tet());
    EXPECT_EQ(mode_of(path("a.mesh")), mode);
    expect_same(read_mesh(path("a.mesh")), one_tet());
    std::filesystem::remove(path("a.mesh"));
  }
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

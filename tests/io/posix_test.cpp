// SPDX-License-Identifier: Apache-2.0
// Files as POSIX has them: open descriptors, pipes, permissions, a full disk, and the end of a process during a write.
#include <fcntl.h>
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

TEST_F(IoTest, OnlyRegularFilesAreReplaced) { EXPECT_THROW(write_text("/dev/null", "text"), FileError); }

TEST_F(IoTest, APipeIsNoFile) {
  // Without a writer it would block whoever opens it.
  ASSERT_EQ(::mkfifo(path("pipe.mesh").c_str(), 0600), 0);
  EXPECT_TRUE(contains(read_error(path("pipe.mesh")), "not a regular file"));
}

TEST_F(IoTest, AFolderWithoutPermission) {
  if (::geteuid() == 0) GTEST_SKIP() << "the superuser may write everywhere";
  std::filesystem::create_directory(path("locked"));
  ASSERT_EQ(::chmod(path("locked").c_str(), 0500), 0);
  EXPECT_TRUE(contains(write_error(path("locked/a.mesh"), one_tet()), "no permission to write"));
  ASSERT_EQ(::chmod(path("locked").c_str(), 0700), 0);
}

}  // namespace
}  // namespace tetune::test

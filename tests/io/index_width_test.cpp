// SPDX-License-Identifier: Apache-2.0
// Counts that ids of 32 bits cannot number, in files long enough for them: sparse ones, which take no room on the disk.
#include "io_fixture.hpp"
#include "support/allocation_watch.hpp"
#include "tetune/validate.hpp"

namespace tetune::test {
namespace {

class IndexWidth : public IoTest {
 protected:
  /// A file that starts with these bytes, and holds zeros up to a length.
  std::string sparse(const std::string& name, const std::string& start, std::uintmax_t length) const {
    if (length > std::numeric_limits<std::size_t>::max()) return "";
    const std::string file = put(name, start);
    std::error_code error;
    std::filesystem::resize_file(file, length, error);
    return error ? "" : file;
  }
  static void expect_refused(const std::string& file, const std::string& said) {
    if (file.empty()) GTEST_SKIP() << "no sparse files in this temporary folder, or no addresses for their bytes";
    const AllocationWatch watch;
    const std::string error = read_error(file);
    EXPECT_TRUE(contains(error, file));
    EXPECT_TRUE(contains(error, said));
    EXPECT_LT(watch.largest(), 1U << 20);
  }
};

template <class T>
std::string raw(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

TEST_F(IndexWidth, MeditBinary) {
  struct Case {
    int code;
    std::int64_t entries;
    std::int64_t bytes_each;
    const char* said;
  };
  for (const Case& c :
       {Case{8, 600'000'000, 40, "section Tetrahedra has 600000000 entries; tetune takes at most 400000000"},
        Case{4, 2'400'000'000, 32, "section Vertices has 2400000000 entries"},
        Case{6, 4'294'967'299, 32, "section Triangles has 4294967299 entries"}}) {
    SCOPED_TRACE(c.said);
    // Version 4: integers and positions of 64 bits.
    std::string start = raw<std::int32_t>(1) + raw<std::int32_t>(4);
    const std::int64_t end = 28 + c.entries * c.bytes_each;
    start += raw<std::int32_t>(c.code) + raw(end) + raw(c.entries);
    expect_refused(sparse("a.meshb", start, static_cast<std::uintmax_t>(end) + 12), c.said);
  }
}

TEST_F(IndexWidth, MeditText) {
  expect_refused(sparse("a.mesh", "MeshVersionFormatted 2\nDimension 3\nTetrahedra\n600000000\n", 7'000'000'000),
                 ":4: section Tetrahedra has 600000000 entries");
}

TEST_F(IndexWidth, TetGen) {
  put("a.node", "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n");
  const std::string file = sparse("a.ele", "600000000 4 0\n", 7'000'000'000);
  expect_refused(file, ":1: this file has 600000000 entries; tetune takes at most 400000000");
}

}  // namespace
}  // namespace tetune::test

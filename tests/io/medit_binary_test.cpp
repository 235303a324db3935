// SPDX-License-Identifier: Apache-2.0
// MEDIT binary (libMeshb's published layout), the bytes made here and not by the library's writer.
#include <algorithm>
#include <functional>

#include "io_fixture.hpp"
#include "support/allocation_watch.hpp"

namespace tetune::test {
namespace {

enum class ByteOrder { native, swapped };

/// Writes the layout: keyword codes and the dimension have 32 bits in every version; positions 64 from version 3 on;
/// counts, ids and references 64 in version 4; reals 32 in version 1.
class MeditBytes {
 public:
  explicit MeditBytes(int version, ByteOrder order = ByteOrder::native) : version_(version), order_(order) {
    raw<std::int32_t>(1);
    raw(static_cast<std::int32_t>(version));
    section(3, [this] { raw<std::int32_t>(3); });
  }
  template <class T>
  MeditBytes& raw(T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if (order_ == ByteOrder::swapped) std::reverse(bytes, bytes + sizeof(T));
    out_.append(bytes, sizeof(T));
    return *this;
  }
  MeditBytes& integer(std::int64_t value) { return version_ == 4 ? raw(value) : raw(static_cast<std::int32_t>(value)); }
  MeditBytes& real(double value) { return version_ == 1 ? raw(static_cast<float>(value)) : raw(value); }
  MeditBytes& position(std::int64_t value) {
    return version_ >= 3 ? raw(value) : raw(static_cast<std::int32_t>(value));
  }
  /// `off` misplaces the position of the next section.
  MeditBytes& section(int code, const std::function<void()>& body, std::int64_t off = 0) {
    raw(static_cast<std::int32_t>(code));
    const std::size_t at = out_.size();
    position(0);
    body();
    const std::string whole = std::move(out_);
    out_.clear();
    position(static_cast<std::int64_t>(whole.size()) + off);
    out_ = whole.substr(0, at) + out_ + whole.substr(at + out_.size());
    return *this;
  }
  /// A count and integers.
  MeditBytes& integers(int code, std::int64_t count, const std::vector<std::int64_t>& values, std::int64_t off = 0) {
    return section(
        code,
        [&] {
          integer(count);
          for (const std::int64_t v : values) integer(v);
        },
        off);
  }
  MeditBytes& vertices(const TetMesh& mesh) {
    return section(4, [&] {
      integer(static_cast<std::int64_t>(mesh.points.size()));
      for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        for (const double x : mesh.points[i]) real(x);
        integer(mesh.point_tags[i]);
      }
    });
  }
  std::string end() {
    raw<std::int32_t>(54);
    position(0);
    return out_;
  }
  const std::string& bytes() const { return out_; }

 private:
  int version_;
  ByteOrder order_;
  std::string out_;
};

template <std::size_t N>
std::vector<std::int64_t> listed(const std::vector<std::array<Index, N>>& elements, const std::vector<int>& tags) {
  std::vector<std::int64_t> values;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    for (const Index v : elements[i]) values.push_back(v + 1);
    values.push_back(tags[i]);
  }
  return values;
}

std::vector<std::int64_t> listed(const std::vector<Index>& ids) {
  std::vector<std::int64_t> values;
  for (const Index id : ids) values.push_back(id + 1);
  return values;
}

/// all_sections() with coordinates that a float holds.
TetMesh float_mesh() {
  TetMesh mesh = all_sections();
  for (std::size_t i = 8; i < mesh.points.size(); ++i) mesh.points[i] = {0.25 * static_cast<double>(i), -1.5, 1024};
  return mesh;
}

void put_elements(MeditBytes& out, const TetMesh& m) {
  out.integers(5, static_cast<std::int64_t>(m.edges.size()), listed(m.edges, m.edge_tags));
  out.integers(6, static_cast<std::int64_t>(m.triangles.size()), listed(m.triangles, m.triangle_tags));
  out.integers(8, static_cast<std::int64_t>(m.tets.size()), listed(m.tets, m.tet_tags));
  const int codes[4] = {7, 49, 9, 10};
  for (std::size_t b = 0; b < m.others.size(); ++b) {
    const ElementBlock& block = m.others[b];
    const auto each = static_cast<std::size_t>(block.vertices_per_element);
    std::vector<std::int64_t> values;
    for (std::size_t i = 0; i < block.tags.size(); ++i) {
      for (std::size_t k = 0; k < each; ++k) values.push_back(block.element2vertex[each * i + k] + 1);
      values.push_back(block.tags[i]);
    }
    out.integers(codes[b], static_cast<std::int64_t>(block.tags.size()), values);
  }
  const auto list = [&out](int code, const std::vector<Index>& ids) {
    out.integers(code, static_cast<std::int64_t>(ids.size()), listed(ids));
  };
  list(18, m.others[0].required);
  list(13, m.corners);
  list(15, m.required_vertices);
  list(14, m.ridges);
  list(16, m.required_edges);
  list(17, m.required_triangles);
  list(12, m.required_tets);
}

class MeditVersion : public IoTest, public ::testing::WithParamInterface<std::tuple<int, ByteOrder>> {
 protected:
  MeditBytes head() const { return MeditBytes(std::get<0>(GetParam()), std::get<1>(GetParam())); }
};

INSTANTIATE_TEST_SUITE_P(Layouts, MeditVersion,
                         ::testing::Combine(::testing::Range(1, 5),
                                            ::testing::Values(ByteOrder::native, ByteOrder::swapped)),
                         [](const auto& test) {
                           return "Version" + std::to_string(std::get<0>(test.param)) +
                                  (std::get<1>(test.param) == ByteOrder::swapped ? "Swapped" : "Native");
                         });

TEST_P(MeditVersion, AllSections) {
  const TetMesh mesh = float_mesh();
  MeditBytes out = head();
  out.vertices(mesh);
  put_elements(out, mesh);
  std::vector<std::string> warnings;
  expect_same(read_mesh(put("a.meshb", out.end()), &warnings), mesh);
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

TEST_P(MeditVersion, UnknownSectionsAreSkippedWithAWarning) {
  const TetMesh mesh = float_mesh();
  MeditBytes out = head();
  out.section(60, [&out] { out.integer(1).real(0).real(0).real(1); });  // normals
  out.vertices(mesh);
  out.integers(20, 2, {1, 1, 2, 1});
  std::vector<std::string> warnings;
  const TetMesh read = read_mesh(put("a.meshb", out.end()), &warnings);
  EXPECT_EQ(read.points, mesh.points);
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_TRUE(contains(warnings[0], "code 60 "));
  EXPECT_TRUE(contains(warnings[1], "code 20 "));
}

TEST_P(MeditVersion, WildCountsAreRefusedWithoutMemory) {
  for (const std::int64_t count : {2'000'000'000, 100'000, -1, -2'000'000'000}) {
    for (const int code : {4, 5, 6, 8, 7, 10, 13, 18}) {
      MeditBytes out = head();
      out.integers(code, count, {1, 2, 3, 4, 5});
      const std::string file = put("a.meshb", out.end());
      const AllocationWatch watch;
      EXPECT_TRUE(contains(read_error(file), "claims " + std::to_string(count))) << code;
      EXPECT_LT(watch.largest(), 1U << 20);
    }
  }
}

TEST_P(MeditVersion, PositionsOutsideOrBackwards) {
  const std::int64_t width = std::get<0>(GetParam()) >= 3 ? 8 : 4;
  for (const std::int64_t off : {std::int64_t{1000}, std::int64_t{-30}, -2 - 2 * width}) {
    MeditBytes out = head();
    out.integers(13, 1, {1}, off);
    EXPECT_TRUE(contains(read_error(put("a.meshb", out.end())), "outside the file")) << off;
  }
}

/// A count that disagrees with where the section ends means that one of them is wrong.
TEST_P(MeditVersion, SectionsLongerOrShorterThanTheySay) {
  for (const std::int64_t count : {1, 3}) {
    MeditBytes out = head();
    out.integers(13, count, {1, 2});
    const std::string error = read_error(put("a.meshb", out.end()));
    EXPECT_TRUE(contains(error, count == 1 ? "the section ends at byte" : "Corners claims 3 entries"));
  }
}

TEST_P(MeditVersion, FlatMesh) {
  MeditBytes out = head();
  out.section(3, [&out] { out.raw<std::int32_t>(2); });
  EXPECT_TRUE(contains(read_error(put("a.meshb", out.end())), "dimension 2"));
}

TEST_P(MeditVersion, IdZero) {
  MeditBytes out = head();
  out.integers(8, 1, {0, 1, 2, 3, 0});
  EXPECT_TRUE(contains(read_error(put("a.meshb", out.end())), "id 0 in section Tetrahedra"));
}

/// Long lists are read in parts, on all threads.
TEST_P(MeditVersion, LongLists) {
  const TetMesh mesh = two_materials(12);
  MeditBytes out = head();
  out.vertices(mesh).integers(8, static_cast<std::int64_t>(mesh.tets.size()), listed(mesh.tets, mesh.tet_tags));
  const std::string file = put("a.meshb", out.end());
  for (const int threads : {1, 3}) {
    const TetMesh read = read_mesh(file, nullptr, threads);
    EXPECT_EQ(read.tets, mesh.tets);
    EXPECT_EQ(read.tet_tags, mesh.tet_tags);
    EXPECT_EQ(read.point_tags, mesh.point_tags);
  }
}

/// Long lists are encoded in parts, on all threads, and written in batches of several parts per thread.
TEST_F(IoTest, LongListsOfBinaryMeditAreWrittenOnAllThreads) {
  TetMesh mesh = two_materials(24);
  mesh.required_tets.clear();
  for (Index t = 0; t < 8192; ++t) mesh.required_tets.push_back(t);  // just one part
  const std::string one = path("one.meshb");
  const std::string three = path("three.meshb");
  write_mesh(one, mesh, 1);
  write_mesh(three, mesh, 3);
  EXPECT_EQ(get("one.meshb"), get("three.meshb"));
  const TetMesh read = read_mesh(three);
  EXPECT_EQ(read.points, mesh.points);
  EXPECT_EQ(read.tets, mesh.tets);
  EXPECT_EQ(read.tet_tags, mesh.tet_tags);
  EXPECT_EQ(read.required_tets, mesh.required_tets);
}

TEST_P(MeditVersion, TheFirstOfSeveralErrorsInALongListIsNamed) {
  constexpr std::int64_t kEntries = 40'000;
  for (const std::size_t wrong : {0, 12'345, 30'000}) {
    std::vector<std::int64_t> ids(kEntries, 1);
    ids[wrong] = -5;
    ids.back() = -6;
    MeditBytes out = head();
    const std::size_t begin = out.bytes().size();
    out.integers(13, kEntries, ids);
    const std::size_t integer = std::get<0>(GetParam()) == 4 ? 8 : 4;
    const std::size_t position = std::get<0>(GetParam()) >= 3 ? 8 : 4;
    const std::size_t at = begin + 4 + position + integer * (wrong + 2);
    const std::string error = read_error(put("a.meshb", out.end()), 3);
    EXPECT_TRUE(contains(error, "id -5 in section Corners")) << error;
    EXPECT_TRUE(contains(error, "byte " + std::to_string(at) + ":")) << error;
  }
}

TEST_P(MeditVersion, EveryTruncationIsNoticed) {
  const TetMesh mesh = float_mesh();
  MeditBytes out = head();
  out.vertices(mesh);
  put_elements(out, mesh);
  const std::size_t whole = out.bytes().size() + 4;  // with the code of End; the position after it has no meaning
  const std::string bytes = out.end();
  EXPECT_EQ(silent_cuts("cut.meshb", bytes.substr(0, whole)), std::vector<std::size_t>());
}

/// libMeshb writes the dimension in 32 bits; some writers of version 4 widen it with the other integers.
TEST_F(IoTest, WideDimensionInVersion4) {
  for (const ByteOrder order : {ByteOrder::native, ByteOrder::swapped}) {
    MeditBytes out(4, order);
    out.section(3, [&out] { out.raw<std::int64_t>(3); });
    out.integers(13, 1, {1});
    EXPECT_EQ(read_mesh(put("a.meshb", out.end())).corners, std::vector<Index>{0});
    MeditBytes flat(4, order);
    flat.section(3, [&flat] { flat.raw<std::int64_t>(2); });
    EXPECT_TRUE(contains(read_error(put("a.meshb", flat.end())), "dimension 2"));
  }
}

TEST_F(IoTest, WideNumbersInVersion4) {
  MeditBytes id(4);
  id.integers(13, 1, {(std::int64_t{1} << 32) + 1});
  EXPECT_TRUE(contains(read_error(put("a.meshb", id.end())), "id 4294967297 in section Corners"));
  MeditBytes tag(4);
  tag.integers(5, 1, {1, 2, -3'000'000'000});
  EXPECT_TRUE(contains(read_error(put("a.meshb", tag.end())), "reference -3000000000 does not fit 32 bits"));
  MeditBytes count(4);
  count.integers(8, std::int64_t{1} << 62, {1, 2, 3, 4, 5});
  EXPECT_TRUE(contains(read_error(put("a.meshb", count.end())), "claims 4611686018427387904"));
}

TEST_F(IoTest, BinaryHeads) {
  EXPECT_TRUE(contains(read_error(put("a.meshb", std::string("\1\2\0\0\0\0\0\0", 8))), "neither in text nor binary"));
  for (const int version : {0, 5, -1}) {
    const std::string error = read_error(put("a.meshb", MeditBytes(version).end()));
    EXPECT_TRUE(contains(error, "version " + std::to_string(version)));
    EXPECT_TRUE(contains(error, "byte 8"));
  }
}

TEST_F(IoTest, BinarySectionsTwice) {
  MeditBytes out(2);
  out.integers(8, 1, {1, 2, 3, 4, 0}).integers(8, 1, {1, 2, 3, 4, 0});
  EXPECT_TRUE(contains(read_error(put("a.meshb", out.end())), "Tetrahedra occurs twice"));
}

/// The writer's bytes are those made here.
TEST_F(IoTest, WrittenBytesFollowTheLayout) {
  const TetMesh mesh = two_materials(2);
  MeditBytes out(2);
  out.vertices(mesh).integers(8, static_cast<std::int64_t>(mesh.tets.size()), listed(mesh.tets, mesh.tet_tags));
  write_mesh(path("a.meshb"), mesh);
  EXPECT_EQ(get("a.meshb"), out.end());
}

}  // namespace
}  // namespace tetune::test

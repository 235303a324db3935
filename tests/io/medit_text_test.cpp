// SPDX-License-Identifier: Apache-2.0
// MEDIT text as others write it, and what is said of broken files.

#include <algorithm>
#include <cmath>
#include <limits>

#include "io_fixture.hpp"
#include "support/allocation_watch.hpp"

namespace tetune::test {
namespace {

const std::string kHead = "MeshVersionFormatted 2\nDimension 3\n";
const std::string kVertices = "Vertices\n4\n0 0 0 1\n1 0 0 2\n0 1 0 3\n0 0 1 4\n";
const std::string kTets = "Tetrahedra\n1\n1 2 3 4 9\n";

TEST_F(IoTest, CommentsMayStandAnywhere) {
  const TetMesh mesh = read_mesh(
      put("a.mesh",
          "# Set of Tetrahedra\nMeshVersionFormatted 1 # Vertices 7\n# Dimension 2\nDimension\n3\n"
          "# Set of mesh Vertices\nVertices # 9\n4 # four\n0 0 0 1# here\n1 0 0 2\n# Tetrahedra\n0 1 0 3\n0 0 1 4\n"
          "# Set of Tetrahedra (v1,v2,v3,v4,tag)\nTetrahedra\n#\n1\n1 2 3 4 9\nEnd\n# Triangles\n"));
  EXPECT_EQ(mesh.points.size(), 4U);
  EXPECT_EQ(mesh.point_tags, (std::vector<int>{1, 2, 3, 4}));
  EXPECT_EQ(mesh.tets, (std::vector<std::array<Index, 4>>{{0, 1, 2, 3}}));
  EXPECT_EQ(mesh.tet_tags, std::vector<int>{9});
}

TEST_F(IoTest, LineBreaksAreBlanks) {
  const TetMesh one = read_mesh(put("a.mesh", kHead + kVertices + kTets + "End\n"));
  std::string text = kHead + kVertices + kTets + "End";
  std::string windows, spaced;
  for (const char c : text) {
    windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
    spaced += c == '\n' || c == ' ' ? std::string(" \t\n ") : std::string(1, c);
  }
  expect_same(read_mesh(put("b.mesh", windows)), one);
  expect_same(read_mesh(put("c.mesh", spaced)), one);
}

/// Long sections are read in parts of lines, whatever the lines hold.
TEST_F(IoTest, LongSectionsReadInPartsAreTheSame) {
  write_mesh(path("a.mesh"), two_materials(12, 0.2));
  const TetMesh mesh = read_mesh(path("a.mesh"), nullptr, 1);
  const std::string text = get("a.mesh");
  // In the middle of the tetrahedra: a comment, an empty line, two entries on one line, an entry on two.
  const std::size_t middle = text.find('\n', (text.find("Tetrahedra") + text.size()) / 2);
  const std::size_t next = text.find('\n', middle + 1);
  std::string with_comment = text, with_gap = text, joined = text, split = text;
  with_comment.replace(middle, 1, " # 1 2 3\n# 4 5\n");
  with_gap.replace(middle, 1, "\n\n");
  joined[middle] = ' ';
  split.replace(text.find(' ', middle), 1, "\n");
  for (const int threads : {1, 2, 3}) {
    for (const std::string& same : {text, with_comment, with_gap, joined, split}) {
      expect_same(read_mesh(put("b.mesh", same), nullptr, threads), mesh);
    }
    std::string broken = text;
    broken.replace(middle + 1, next - middle - 1, std::string("1 2 x 4 0"));
    const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(middle) + 1, '\n') + 1;
    const std::string error = read_error(put("c.mesh", broken), threads);
    EXPECT_TRUE(contains(error, "c.mesh:" + std::to_string(line)));
    EXPECT_TRUE(contains(error, "expected an integer (id), found \"x\""));
  }
}

TEST_F(IoTest, UnknownTextSectionsAreSkippedWithAWarning) {
  std::vector<std::string> warnings;
  const std::string file =
      put("a.mesh", kHead + "Normals\n2\n0 0 1\nnan -1.5e-3 inf\n" + kVertices + "NormalAtVertices 1\n1 1\n" + kTets +
                        "SolAtVertices\n1\n1 1\n# Edges\n0.5\nEnd\n");
  const TetMesh mesh = read_mesh(file, &warnings);
  EXPECT_EQ(mesh.points.size(), 4U);
  EXPECT_EQ(mesh.tets.size(), 1U);
  ASSERT_EQ(warnings.size(), 3U);
  EXPECT_TRUE(contains(warnings[0], file));
  EXPECT_TRUE(contains(warnings[0], "section Normals "));
  EXPECT_TRUE(contains(warnings[1], "section NormalAtVertices "));
  EXPECT_TRUE(contains(warnings[2], "section SolAtVertices "));
}

TEST_F(IoTest, NumbersAsOthersWriteThem) {
  const TetMesh mesh = read_mesh(put("a.mesh", kHead + "Vertices\n4\n1.0D-3 -2.5d+2 +1D0 0\n+1.5 .5 1. +7\n"
                                                       "1e-400 -1e-400 0.1E1 -3\n1e9999 -1e400 nan 0\nEnd\n"));
  EXPECT_EQ(mesh.points[0], (Point3{1e-3, -250, 1}));
  EXPECT_EQ(mesh.points[1], (Point3{1.5, 0.5, 1}));
  EXPECT_EQ(mesh.point_tags, (std::vector<int>{0, 7, -3, 0}));
  EXPECT_EQ(mesh.points[2], (Point3{0, 0, 1}));
  EXPECT_TRUE(std::signbit(mesh.points[2][1]));
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(mesh.points[3][0], infinity);
  EXPECT_EQ(mesh.points[3][1], -infinity);
  EXPECT_TRUE(std::isnan(mesh.points[3][2]));
}

TEST_F(IoTest, LongNumbersKeepTheirSize) {
  const std::string zeros(400, '0');
  const TetMesh mesh =
      read_mesh(put("a.mesh", kHead + "Vertices\n1\n1" + zeros + "e-300 0." + zeros + "1 1" + zeros + "e-20 0\nEnd\n"));
  EXPECT_EQ(mesh.points[0][0], 1e100);
  EXPECT_EQ(mesh.points[0][1], 0);
  EXPECT_EQ(mesh.points[0][2], std::numeric_limits<double>::infinity());
}

TEST_F(IoTest, EveryVersionOfText) {
  for (const char* version : {"1", "2", "3", "4"}) {
    const std::string head = "MeshVersionFormatted\n" + std::string(version) + "\nDimension 3\n";
    const TetMesh mesh = read_mesh(put("a.mesh", head + kVertices + "End"));
    EXPECT_EQ(mesh.points.size(), 4U);
  }
  EXPECT_TRUE(contains(read_error(put("a.mesh", "MeshVersionFormatted 5\nDimension 3\nEnd\n")), "version 5"));
}

TEST_F(IoTest, ThingsThatAreNoFile) {
  EXPECT_TRUE(contains(read_error(path("absent.mesh")), "absent.mesh: cannot open: No such file"));
  EXPECT_TRUE(contains(read_error(path("absent")), "absent: there is no such file"));
  std::filesystem::create_directory(path("folder.mesh"));
  EXPECT_TRUE(contains(read_error(path("folder.mesh")), "folder.mesh: not a regular file"));
  EXPECT_TRUE(contains(read_error(put("empty.mesh", "")), "the file is empty"));
  EXPECT_TRUE(contains(read_error(put("empty.meshb", "")), "the file is empty"));
  EXPECT_TRUE(contains(read_error(put("wide.mesh", std::string("\xFF\xFEM\0e\0", 6))), "UTF-16"));
  EXPECT_TRUE(contains(read_error(put("other.mesh", "solid cube\n")), "other.mesh:1: this is not a MEDIT mesh"));
}

/// Text and binary are distinguished by their content, and a byte order mark before a text is skipped.
TEST_F(IoTest, WhatTheFileHoldsDecides) {
  const std::string text = "MeshVersionFormatted 2\nDimension 3\nVertices 1\n0.5 0 0 7\nEnd\n";
  for (const std::string& name : {put("a.mesh", "\xEF\xBB\xBF" + text), put("a.meshb", text)}) {
    EXPECT_EQ(read_mesh(name).point_tags, std::vector<int>{7});
  }
  const TetMesh mesh = read_mesh(path("a.mesh"));
  write_mesh(path("b.meshb"), mesh);
  std::filesystem::rename(path("b.meshb"), path("b.mesh"));
  EXPECT_EQ(read_mesh(path("b.mesh")).points, mesh.points);
}

TEST_F(IoTest, EndingsMayBeInCapitals) {
  const TetMesh mesh = cube(1);
  for (const char* name : {"A.MESH", "a.MeshB", "A.INP", "A.BDF", "A.ELE"}) {
    write_mesh(path(name), mesh);
    EXPECT_EQ(read_mesh(path(name)).tets.size(), mesh.tets.size()) << name;
  }
  EXPECT_FALSE(get("A.NODE").empty());
  EXPECT_NE(get("a.MeshB").substr(0, 4), get("A.MESH").substr(0, 4));
}

TEST_F(IoTest, UnknownEndingsAreRefusedWithTheKnownOnes) {
  for (const char* name : {"a.stl", "a", "mesh"}) {
    const std::string error = read_error(put(name, kHead + "End\n"));
    EXPECT_TRUE(contains(error, std::string(name) + ": tetune does not read files of ending \"")) << name;
    EXPECT_TRUE(contains(error, ".mesh .meshb .ele .node .face")) << name;
  }
}

struct BrokenText {
  const char* name;
  std::string text;
  std::vector<const char*> said;
};

void PrintTo(const BrokenText& broken, std::ostream* out) { *out << broken.name; }

class BrokenTextTest : public IoTest, public ::testing::WithParamInterface<BrokenText> {};

TEST_P(BrokenTextTest, SaysWhatAndWhere) {
  const AllocationWatch watch;
  const std::string error = read_error(put("a.mesh", GetParam().text));
  for (const char* part : GetParam().said) EXPECT_TRUE(contains(error, part));
  EXPECT_LT(watch.largest(), 1U << 20);
}

INSTANTIATE_TEST_SUITE_P(
    Files, BrokenTextTest,
    ::testing::Values(
        BrokenText{"Word", kHead + "Vertices\n2\n0 0 0 1\n0 zero 0 1\nEnd\n", {"a.mesh:6:", "\"zero\"", "coordinate"}},
        BrokenText{"HalfANumber", kHead + "Vertices\n1\n0 1.5x 0 1\nEnd\n", {"a.mesh:5:", "\"1.5x\""}},
        BrokenText{"TwoSigns", kHead + "Vertices\n1\n0 +-1 0 1\nEnd\n", {"a.mesh:5:", "\"+-1\""}},
        BrokenText{"NoExponent", kHead + "Vertices\n1\n0 1D 0 1\nEnd\n", {"a.mesh:5:", "\"1D\""}},
        BrokenText{"RealId", kHead + kVertices + "Tetrahedra\n1\n1 2 3 4.5 0\nEnd\n", {"a.mesh:11:", "\"4.5\"", "id"}},
        BrokenText{"RealTag", kHead + "Vertices\n1\n0 0 0 0.5\nEnd\n", {"a.mesh:5:", "\"0.5\"", "reference"}},
        BrokenText{"LongInteger", kHead + "Vertices\n1\n0 0 0 18446744073709551621\nEnd\n", {"a.mesh:5:", "reference"}},
        BrokenText{"WideTag", kHead + "Vertices\n1\n0 0 0 2147483648\nEnd\n", {"a.mesh:5:", "2147483648", "32 bits"}},
        BrokenText{
            "Flat", "MeshVersionFormatted 2\nDimension 2\nVertices\n1\n0 0 1\nEnd\n", {"a.mesh:2:", "dimension 2"}},
        BrokenText{"IdZero",
                   kHead + kVertices + "Tetrahedra\n1\n0 1 2 3 0\nEnd\n",
                   {"a.mesh:11:", "id 0 ", "section Tetrahedra", "count from 1"}},
        BrokenText{"IdNegative", kHead + "Corners\n1\n-1\nEnd\n", {"a.mesh:5:", "id -1 ", "section Corners"}},
        BrokenText{"IdWide", kHead + "Hexahedra\n1\n1 2 3 4 5 6 7 2147483648 0\nEnd\n", {"a.mesh:5:", "Hexahedra"}},
        BrokenText{"LongerThanItSays",
                   kHead + "Vertices\n3\n0 0 0 1\n1 0 0 2\n0 1 0 3\n0 0 1 4\nEnd\n",
                   {"a.mesh:8:", "expected a section name, found \"0\"", "longer than it says"}},
        BrokenText{
            "ShorterThanItSays", kHead + "Vertices\n2\n0 0 0 1\n" + kTets + "End\n", {"a.mesh:6:", "\"Tetrahedra\""}},
        BrokenText{"CutShort", kHead + "Vertices\n2\n0 0 0 1\n0 0", {"a.mesh:6:", "end of the file"}},
        BrokenText{"NoCount", kHead + "Vertices\n", {"number of entries", "end of the file"}},
        BrokenText{"Twice", kHead + kVertices + kTets + kTets + "End\n", {"a.mesh:12:", "Tetrahedra occurs twice"}},
        BrokenText{"ListTwice", kHead + "Corners 1 1\nCorners 1 2\nEnd\n", {"a.mesh:4:", "Corners occurs twice"}},
        BrokenText{
            "OthersTwice", kHead + "Pyramids 1 1 2 3 4 5 0\nPyramids 1 1 2 3 4 5 0\nEnd\n", {"Pyramids occurs twice"}},
        BrokenText{"NoQuads", kHead + "RequiredQuadrilaterals 1 1\nEnd\n", {"no Quadrilaterals"}},
        BrokenText{"WildVertices", kHead + "Vertices\n999999999999\n0 0 0 1\nEnd\n", {"a.mesh:4:", "999999999999"}},
        BrokenText{"WildList", kHead + "Ridges\n2000000000\n1\nEnd\n", {"a.mesh:4:", "Ridges claims 2000000000"}},
        BrokenText{"WildOthers", kHead + "Prisms\n400000000\n1\nEnd\n", {"a.mesh:4:", "Prisms claims 400000000"}},
        BrokenText{"NegativeCount", kHead + "Triangles\n-1\nEnd\n", {"a.mesh:4:", "Triangles claims -1"}}),
    [](const auto& test) { return std::string(test.param.name); });

/// A file cut short is refused, or, where what is left makes sense by itself, at least warned of.
TEST_F(IoTest, EveryTruncationOfTextIsNoticed) {
  write_mesh(path("whole.mesh"), all_sections());
  std::string text = get("whole.mesh");
  text.pop_back();  // the line break after End
  int silent = 0, refused = 0;
  for (std::size_t n = 0; n < text.size(); ++n) {
    std::vector<std::string> warnings;
    try {
      read_mesh(put("cut.mesh", text.substr(0, n)), &warnings, 1);
      if (warnings.empty() && ++silent < 5) ADD_FAILURE() << "cut after " << n << " of " << text.size() << " bytes";
    } catch (const FileError&) {
      ++refused;
    }
  }
  EXPECT_EQ(silent, 0);
  EXPECT_GT(refused, static_cast<int>(text.size() / 2));
}

}  // namespace
}  // namespace tetune::test

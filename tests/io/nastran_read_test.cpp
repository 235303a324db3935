// SPDX-License-Identifier: Apache-2.0
// Nastran's bulk data as they are read.
#include <cmath>
#include <limits>

#include "io/nastran/nastran_fields.hpp"
#include "io/real_field.hpp"
#include "mesh_contents.hpp"
#include "nastran_fixture.hpp"
#include "support/bits.hpp"

namespace tetune::test {
namespace {

/// A line of fields at the left of columns of a width, after a name of 8 columns.
std::string columns(const std::string& name, std::size_t width, const std::vector<std::string>& fields,
                    const std::string& marker = "") {
  std::string line = name + std::string(8 - name.size(), ' ');
  for (const std::string& field : fields) line += field + std::string(width - field.size(), ' ');
  if (!marker.empty()) line += std::string(72 - line.size(), ' ') + marker;
  return line + "\n";
}

TEST(NastranReal, Notations) {
  for (const auto& [text, value] : std::vector<std::pair<std::string, double>>{{"1.5", 1.5},
                                                                               {"1.5+3", 1500},
                                                                               {"-1.5-3", -0.0015},
                                                                               {"1.5E3", 1500},
                                                                               {"1.5e+3", 1500},
                                                                               {"1.5D3", 1500},
                                                                               {"1.5d-3", 0.0015},
                                                                               {".5", 0.5},
                                                                               {"-.5+1", -5},
                                                                               {"+1.", 1},
                                                                               {"7", 7},
                                                                               {"7+2", 700},
                                                                               {"1.-400", 0}}) {
    const std::optional<double> read = parse_fortran_real(text);
    ASSERT_TRUE(read) << text;
    EXPECT_EQ(bits_of(*read), bits_of(value)) << text;
  }
  for (const char* const text : {"", "+", "-", ".", "x", "1.5x", "1.5 3", "1.5E", "1.5-", "1.5E3+4", "+-1.", "--1.",
                                 "nan", "inf", "-inf", "0x10", "1,5"}) {
    EXPECT_FALSE(parse_fortran_real(text)) << text;
  }
  EXPECT_EQ(parse_fortran_real("1.+400"), std::optional(std::numeric_limits<double>::infinity()));
  EXPECT_EQ(parse_nastran_integer("+12"), std::optional(12));
  EXPECT_EQ(parse_nastran_integer("-12"), std::optional(-12));
  for (const char* const text : {"", "+", "1.", "1 2", "1234567890", "a"}) {
    EXPECT_FALSE(parse_nastran_integer(text)) << text;
  }
}

TEST_F(Nastran, AllNotationsOfAMeshReadAlike) {
  std::string small = "$ comment\nbegin bulk\n";
  std::string large = "BEGIN BULK\n";
  std::string tabs = "BEGIN BULK\n";
  std::string free;
  const std::vector<std::vector<std::string>> coordinates{
      {"0.", "0.", "0."}, {"1.", "0.", "0."}, {"0.", "1.", "0."}, {"0.", "0.", "1.5-1"}, {"1.", "1.", "1.0E0"}};
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const std::vector<std::string>& x = coordinates[i];
    const std::string n = std::to_string(10 * i + 10);
    small += columns("Grid", 8, {n, "", x[0], x[1], x[2]});
    large += columns("GRID*", 16, {n, "", x[0], x[1]}, i % 2 == 0 ? "*" : "*G" + n);
    large += columns(i % 2 == 0 ? "*" : "*G" + n, 16, {x[2]});
    tabs += "grid\t" + n + "\t\t" + x[0] + "\t" + x[1] + "\t" + x[2] + "\t$ trailing, with a comma\r\n";
    free += "grid," + n + ",," + x[0] + ", " + x[1] + " ," + x[2] + "   $ trailing\n";
  }
  small += columns("ctetra", 8, {"1", "5", "10", "20", "30", "40"}) + "$ between\n" +
           columns("CTETRA", 8, {"2", "6", "20", "30", "40", "50"}) +
           columns("CTRIA3", 8, {"3", "8", "10", "20", "30"});
  large += columns("CTETRA*", 16, {"1", "5", "10", "20"}, "*") + columns("*", 16, {"30", "40"}) +
           columns("CTETRA*", 16, {"2", "6", "20", "30"}, "*A") + "$ between\n" + columns("*A", 16, {"40", "50"}) +
           columns("CTRIA3*", 16, {"3", "8", "10", "20"}) + columns("*", 16, {"30"});
  tabs += "CTETRA\t1\t5\t10\t20\t30\t40\nCTETRA\t2\t6\t20\t30\t40\t50\nctria3\t3\t8\t10\t20\t30\n";
  free += "CTETRA,1,5,10,20,30,40\nCTETRA*,2,6,20,30,*\n*,40,50\nCTRIA3,3,8,10,20,30,\n";
  const TetMesh m = read(small + kEnd);
  EXPECT_EQ(m.points, (std::vector<Point3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0.15}, {1, 1, 1}}));
  EXPECT_EQ(m.deck_nodes, (std::vector<std::int64_t>{10, 20, 30, 40, 50}));
  EXPECT_EQ(m.tets, (std::vector<std::array<Index, 4>>{{0, 1, 2, 3}, {1, 2, 3, 4}}));
  EXPECT_EQ(m.tet_tags, (std::vector{5, 6}));
  EXPECT_EQ(m.triangles, (std::vector<std::array<Index, 3>>{{0, 1, 2}}));
  EXPECT_EQ(m.triangle_tags, (std::vector{8}));
  EXPECT_TRUE(warnings_.empty()) << warnings_[0];
  for (const std::string& text : {large, tabs, free}) {
    SCOPED_TRACE(text);
    expect_same(read(text + kEnd), m);
    EXPECT_TRUE(warnings_.empty()) << warnings_[0];
  }
}

TEST_F(Nastran, TenNodesInAllNotations) {
  const std::vector<std::string> cards{
      // Blank markers, old markers, no markers, free fields, large fields over three lines.
      columns("CTETRA", 8, {"1", "7", "1", "2", "3", "4", "5", "6"}) + columns("", 8, {"7", "8", "9", "10"}),
      columns("CTETRA", 8, {"1", "7", "1", "2", "3", "4", "5", "6"}, "+E1") + columns("+E1", 8, {"7", "8", "9", "10"}),
      columns("CTETRA", 8, {"1", "7", "1", "2", "3", "4", "5", "6"}, "+") + columns("+", 8, {"7", "8", "9", "10"}),
      columns("CTETRA", 8, {"1", "7", "1", "2", "3", "4", "5", "6"}, "00000012") +
          columns("+", 8, {"7", "8", "9", "10"}),
      // The first character of a marker, column 73, may be blank; the second may be a plus.
      columns("CTETRA", 8, {"1", "7", "1", "2", "3", "4", "5", "6"}, " ABC1") +
          columns("+ABC1", 8, {"7", "8", "9", "10"}),
      columns("CTETRA", 8, {"1", "7", "1", "2", "3", "4", "5", "6"}, " +00001") +
          columns("++00001", 8, {"7", "8", "9", "10"}),
      "CTETRA,1,7,1,2,3,4,5,6,+A\n+A,7,8,9,10\n",
      "CTETRA,1,7,1,2,3,4,5,6\n,7,8,9,10\n",
      "CTETRA,1,7,1,2,3,4,5,6,+\n$ comment\n\n+,7,8,9,10,,\n",
      "CTETRA_,1,7,1,2,3,4,5,6\n,7,8,9,10\n",
      "ctetra*,1,7,1,2,*\n*,3,4,5,6,*\n*,7,8,9,10\n",
      columns("CTETRA*", 16, {"1", "7", "1", "2"}, "*") + columns("*", 16, {"3", "4", "5", "6"}, "*") +
          columns("*", 16, {"7", "8", "9", "10"}),
  };
  for (const std::string& card : cards) {
    SCOPED_TRACE(card);
    const TetMesh m = read(kTenNodes + card + kEnd);
    EXPECT_TRUE(m.second_order);
    EXPECT_EQ(m.points.size(), 4U);
    EXPECT_EQ(m.deck_nodes, (std::vector<std::int64_t>{1, 2, 3, 4}));
    EXPECT_EQ(m.curved_edges, (std::vector<CurvedEdge>{{{0, 1}, {0.6, 0, 0}}}));
    EXPECT_EQ(m.tet_tags, (std::vector{7}));
    EXPECT_TRUE(warnings_.empty()) << warnings_[0];
  }
}

TEST_F(Nastran, EdgesWithoutMidSideNodesAreStraight) {
  const TetMesh m = read(kTenNodes + "CTETRA,1,7,1,2,3,4,5,,+\n+,7,0,9,10\n" + kEnd);
  EXPECT_TRUE(m.second_order);
  EXPECT_EQ(m.curved_edges, (std::vector<CurvedEdge>{{{0, 1}, {0.6, 0, 0}}}));
  EXPECT_EQ(m.points.size(), 6U);  // with two nodes in no element
  EXPECT_TRUE(
      warned("elements that lack mid-side nodes get them on writing, as other elements have them: 1 of the "
             "tetrahedra"));
  EXPECT_FALSE(read(kTenNodes + "CTETRA,1,7,1,2,3,4\n,,,,\n" + kEnd).second_order);
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(Nastran, RefusalsOfMidSideNodesHaveTheirNumbers) {
  const std::string error =
      read_error(put("a.bdf", kTenNodes + "GRID,70,,.9,.9,.9\nCTETRA,1,7,1,2,3,4,70,6,+\n,70,8,9,10\n" + kEnd));
  EXPECT_TRUE(contains(error, "a.bdf: node 70 is a mid-side node of two edges, or one of two nodes of the same edge;"))
      << error;
}

TEST_F(Nastran, ABlankPropertyShiftsNoField) {
  for (const std::string& card :
       {std::string("CTETRA,12,,1,2,3,4\n"), columns("CTETRA", 8, {"12", "", "1", "2", "3", "4"})}) {
    const TetMesh m = read(kFourNodes + card + kEnd);
    EXPECT_EQ(m.tets, (std::vector<std::array<Index, 4>>{{0, 1, 2, 3}}));
    EXPECT_EQ(m.tet_tags, (std::vector{0}));
    EXPECT_TRUE(warned("1 elements of dimension 3 have no number of a property: they have no tag"));
  }
  // Beside elements with one, it is the number of the element.
  const TetMesh m =
      read(kFourNodes + "GRID,5,,1.,1.,1.\nCTETRA,12,,1,2,3,4\nCTETRA,13,2,2,3,4,5\nCTRIA3,14,,1,2,3\n" + kEnd);
  EXPECT_EQ(m.tet_tags, (std::vector{12, 2}));
  EXPECT_EQ(m.triangle_tags, (std::vector{0}));
  EXPECT_TRUE(warned("1 elements of dimension 3 have no number of a property: it is that of the element"));
}

TEST_F(Nastran, ControlStatementsCommentsAndEnd) {
  const TetMesh m = read("$ a comment\nSOL 101\nCEND\nINCLUDE 'absent.case'\nSET 1 = 5,6,\nGRID,9\nBEGIN BULK\n" +
                         kFourNodes + kTet + "ENDDATA $ done\nGRID,77,,a,b,c\nBEGIN BULK\n$ after\n");
  EXPECT_EQ(m.points.size(), 4U);
  EXPECT_EQ(read_mesh(put("b.bdf", kFourNodes + kTet + kEnd + "BEGIN BULK\n"), nullptr, 1).points.size(), 4U);
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_TRUE(warned("the statements before BEGIN BULK are not kept"));
  read("\xEF\xBB\xBF" + kFourNodes + kTet);
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_TRUE(warned("it does not end with ENDDATA; the file may be cut short"));
}

TEST_F(Nastran, CardsThatAreNotReadAreNamed) {
  read("MAT1,1,2.1+5,,0.3\n+,1.,2.\nPSOLID  1       1\nFORCE*  1\nSPC1,1,123,4\nCELAS2,9,1.,1,1,2,1\nSPCADD,2,1\n" +
       kFourNodes + kTet + kEnd);
  ASSERT_EQ(warnings_.size(), 2U);
  EXPECT_TRUE(warned("the cards MAT1, PSOLID, FORCE, SPC1, CELAS2, SPCADD are not kept"));
  EXPECT_TRUE(warned("of these, FORCE, SPC1, CELAS2 may name nodes or elements by their numbers"));
  read("GRID,1,,0.,0.,0.,,123\nGRID,2,,1.,0.,0.,0\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n" + kTet +
       "CBAR,2,3,1,2,0.,0.,1.\nCTRIA3,3,4,1,2,3,45.\n" + kEnd);
  ASSERT_EQ(warnings_.size(), 2U);
  EXPECT_TRUE(warned("fields after the nodes or coordinates of CBAR, CTRIA3, GRID are not kept"));
  EXPECT_TRUE(warned("CBAR are read as edges, which are written as CROD"));
}

TEST_F(Nastran, IncludedFiles) {
  std::filesystem::create_directory(path("sub"));
  put("sub/nodes.bdf", "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\ninclude \"more nodes.bdf\"\nGRID,4,,0.,0.,1.\n");
  put("sub/more nodes.bdf", "GRID,3,,0.,1.,0.\n");
  put("tets.bdf", kTet);
  put("sub/top.bdf", "");
  const TetMesh m = read("BEGIN BULK\nINCLUDE 'sub/no\n     des.bdf'\nInclude tets.bdf $ the elements\n" + kEnd);
  EXPECT_EQ(m.tets.size(), 1U);
  EXPECT_TRUE(warnings_.empty()) << warnings_[0];
  const std::vector<std::string> files = files_read(path("a.bdf"));
  EXPECT_EQ(files, (std::vector<std::string>{path("a.bdf"), path("sub/nodes.bdf"), path("sub/more nodes.bdf"),
                                             path("tets.bdf")}));
  EXPECT_EQ(read("INCLUDE 'sub\\nodes.bdf'\n" + kTet + kEnd).points.size(), 4U);
  EXPECT_TRUE(contains(error(kFourNodes + "INCLUDE 'absent.bdf'\n"), "a.bdf:5: the included file"));
  EXPECT_TRUE(contains(error("INCLUDE 'a.bdf'\n"), "a.bdf:1: " + path("a.bdf") + " includes itself"));
  EXPECT_TRUE(contains(error("INCLUDE 'a.bdf\n"), "a.bdf:1: the name of the included file has no quotation mark"));
  EXPECT_TRUE(contains(error("INCLUDE\n"), "a.bdf:1: INCLUDE has no name"));
  put("sub/more nodes.bdf", "$ a comment\nGRID,3,,0.,x,0.\n");
  const std::string message = error("INCLUDE 'sub/nodes.bdf'\n");
  EXPECT_TRUE(contains(message, path("sub/more nodes.bdf") + ":2: GRID: field 5 should be a coordinate, and is \"x\""));
}

/// The positions of four nodes whose cards name coordinate systems; rounding errors are removed.
std::vector<Point3> rounded(std::vector<Point3> points) {
  for (Point3& p : points) {
    for (double& x : p) x = std::round(x * 1e9) / 1e9 + 0.0;
  }
  return points;
}

TEST_F(Nastran, NodesInOtherCoordinateSystemsAreMovedToTheBasicOne) {
  // 1: at (1, 2, 3), z along x and x along y. 2: cylindrical, 3: spherical, both at the origin; 4: in 1, moved by 1.
  const std::string systems =
      "CORD2R,1,,1.,2.,3.,2.,2.,3.\n,1.,3.,3.\nCORD2C*,2,0,0.,0.\n*,0.,0.,0.,1.\n*,1.,0.,0.\n"
      "CORD2S,3,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nCORD2R,4,1,1.,0.,0.,1.,0.,1.\n,2.,0.,0.\n";
  const std::string nodes = "GRID,1,1,1.,0.,2.\nGRID,2,2,2.,90.,5.\nGRID,3,3,2.,90.,180.\nGRID,4,4,0.,0.,0.\n";
  for (const std::string& text : {systems + nodes, nodes + systems}) {
    const TetMesh m = read(text + kTet + kEnd);
    EXPECT_EQ(rounded(m.points), (std::vector<Point3>{{3, 3, 3}, {0, 2, 5}, {-2, 0, 0}, {1, 3, 3}}));
    ASSERT_EQ(warnings_.size(), 1U);
    EXPECT_TRUE(warned("4 nodes are in other coordinate systems than the basic one, in which they are written"));
  }
  // By nodes, two in a card, for all nodes without a system of their own.
  const TetMesh m = read(
      "GRID,1,0,1.,1.,1.\nGRID,2,0,1.,1.,2.\nGRID,3,0,2.,1.,1.\nGRID,4,,1.,0.,0.\nGRDSET,,8\n"
      "CORD1R,7,2,1,3,8,1,2,3\n" +
      kTet + kEnd);
  EXPECT_EQ(rounded(m.points), (std::vector<Point3>{{1, 1, 1}, {1, 1, 2}, {2, 1, 1}, {2, 1, 1}}));
}

TEST_F(Nastran, CoordinateSystemsThatDefineNothingAreRefused) {
  const std::string node = "GRID,1,7,0.,0.,0.\n";
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {"", "a.bdf:1: the coordinate system 7 is used here, and no card defines it"},
           {"CORD2R,7,,0.,0.,0.,0.,0.,1.\n,0.,0.,2.\n", "a.bdf:2: the coordinate system 7 has three points on a line"},
           {"CORD2R,7,8,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nCORD2R,8,7,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n",
            "a.bdf:2: the coordinate system 7 is defined by itself"},
           {"CORD1R,7,1,2,3\n", "a.bdf:2: the coordinate system 7 is defined by itself"},
           {"CORD1R,7,9,2,3\n", "a.bdf:2: a coordinate system has node 9, and no GRID card has this number"},
           {"CORD1R,7,1\n", "a.bdf:2: CORD1R: field 4 should be the number of a node"},
           {"CORD2C,7,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nCORD2R,7,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n",
            "a.bdf:4: the coordinate system 7 is defined twice"}}) {
    EXPECT_TRUE(contains(error(node + text + kTet + kEnd), message)) << error(node + text + kTet + kEnd);
  }
}

TEST_F(Nastran, ErrorsNameTheLineAndTheRemedy) {
  const std::string mesh = kFourNodes + kTet;
  put("nodes.bdf", kFourNodes);
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {"GRID,1,x,0.,0.,0.\n", "a.bdf:1: GRID: field 3 should be the number of a coordinate system, and is \"x\""},
           {"GRID,1.,,0.,0.,0.\n", "a.bdf:1: GRID: field 2 should be the number of the node, a positive integer"},
           {"GRID,0,,0.,0.,0.\n", "a.bdf:1: GRID: field 2 should be the number of the node"},
           {"GRID,,,0.,0.,0.\n", "and is blank"},
           {"GRID,1,,0.,nan,0.\n", "a.bdf:1: GRID: field 5 should be a coordinate, and is \"nan\""},
           {"GRID,1,,0.,1.+999,0.\n", "a.bdf:1: GRID: field 5 should be a coordinate"},
           {"GRID 1 0 0. 0. 0.\n",
            "a.bdf:1: the fields of this line are neither 8 columns wide nor separated by commas"},
           {mesh + "GRID,2,,1.,0.,.5\n", "a.bdf:6: GRID 2 is also in " + path("a.bdf") + ":2, at another position"},
           {mesh + "CTRIA3,1,7,1,2,3\n", "a.bdf:6: the element 1 is also in " + path("a.bdf") + ":5"},
           {mesh + "CTRIA3,2,7,1,2,99\n", "a.bdf:6: CTRIA3 2 has node 99, and no GRID card has this number"},
           {mesh + "CTRIA3,2,0,1,2,3\n", "a.bdf:6: CTRIA3: field 3 should be the number of the property"},
           {mesh + "CTRIA3,2,7,1,,3\n", "a.bdf:6: CTRIA3: field 5 should be the number of a node"},
           {mesh + "CQUAD8,2,7,1,2,3,4,1\n", "a.bdf:6: CQUAD8 lacks some of its 4 mid-side nodes"},
           {mesh + "CTETRA,2,7,1,2,3,4,5,6,7,8,9,10\n", "a.bdf:6: this line has more than 8 fields after the first"},
           {mesh + "CTETRA,2,7,1,2,3,4,5,6,+A\n+B,7,8,9,10\n", "a.bdf:7: this line continues a card that ends with +B"},
           {mesh + "CTETRA,2,7,1,2,3,4,5,6,+A\n", "a.bdf:6: the card continues in a line that starts with +A"},
           {mesh + "CTETRA*,2,7,1,2\n,3,4\n", "a.bdf:7: a line of large fields has no second half before this line"},
           {"INCLUDE 'nodes.bdf'\n,5,6\n", "a.bdf:2: this line continues a card, and there is none before it"},
           {mesh + "=,*1,=,=\n", "a.bdf:6: a line that repeats the card before it (=) is not read"},
           {"BEGIN BULK\n" + mesh + "BEGIN SUPER=1\n", "a.bdf:7: a second BEGIN"},
           {"$ nothing\n", "a.bdf:1: the file ends without a GRID card"},
           {"", "a.bdf:1: the file ends without a GRID card"},
           {std::string("GRID\0", 5), "a.bdf:1: this is a binary file"},
           {kTenNodes + "CTETRA,1,7,1,2,3,4,5,6,+A\n+A,7,8,9,10\nCTETRA,2,7,1,2,3,5\n",
            "a.bdf:13: node 5 is a vertex of this element and in the middle of an edge of another one"}}) {
    EXPECT_TRUE(contains(error(text), message)) << text;
  }
}

TEST_F(Nastran, EveryTruncationIsNoticed) {
  const std::string whole = kTenNodes + "CTETRA,1,7,1,2,3,4,5,6,+A\n+A,7,8,9,10\nCTRIA3,2,8,1,2,3\nENDDATA";
  EXPECT_EQ(silent_cuts("a.bdf", whole), std::vector<std::size_t>());
}

TEST_F(Nastran, NodesThatOccurTwiceAtOnePositionAreOne) {
  const TetMesh m =
      read("GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,1,,0.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n" + kTet + kEnd);
  EXPECT_EQ(m.points, one_tet().points);
  EXPECT_EQ(m.deck_nodes, (std::vector<std::int64_t>{1, 2, 3, 4}));
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(Nastran, ADefaultCoordinateSystemIsOverriddenByZero) {
  EXPECT_EQ(
      read("GRDSET,,3\nGRID,1,0,0.,0.,0.\nGRID,2,0,1.,0.,0.\nGRID,3,0,0.,1.,0.\nGRID,4,0,0.,0.,1.\n" + kTet + kEnd)
          .points,
      one_tet().points);
}

}  // namespace
}  // namespace tetune::test

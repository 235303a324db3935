// SPDX-License-Identifier: Apache-2.0
// Nastran's bulk data.
#include <algorithm>
#include <cmath>

#include "io/nastran/nastran_fields.hpp"
#include "io_fixture.hpp"
#include "mesh_contents.hpp"
#include "support/bits.hpp"
#include "tetune/optimize.hpp"

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

/// The vertices of one tetrahedron of ten nodes, and its mid-side nodes, of which the first is not a midpoint.
const std::string kTenNodes =
    "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\nGRID,5,,.6,0.,0.\nGRID,6,,.5,.5,0.\n"
    "GRID,7,,0.,.5,0.\nGRID,8,,0.,0.,.5\nGRID,9,,.5,0.,.5\nGRID,10,,0.,.5,.5\n";
const std::string kFourNodes = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n";
const std::string kTet = "CTETRA,1,7,1,2,3,4\n";
const std::string kEnd = "ENDDATA\n";

class Nastran : public IoTest {
 protected:
  TetMesh read(const std::string& text) {
    warnings_.clear();
    return read_mesh(put("a.bdf", text), &warnings_, 1);
  }
  bool warned(const std::string& part) const {
    return std::any_of(warnings_.begin(), warnings_.end(),
                       [&](const std::string& w) { return w.find(part) != std::string::npos; });
  }
  std::string error(const std::string& text) const { return read_error(put("a.bdf", text)); }
  std::vector<std::string> warnings_;
};

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
    const std::optional<double> read = parse_nastran_real(text);
    ASSERT_TRUE(read) << text;
    EXPECT_EQ(bits_of(*read), bits_of(value)) << text;
  }
  for (const char* const text : {"", "+", "-", ".", "x", "1.5x", "1.5 3", "1.5E", "1.5-", "1.5E3+4", "+-1.", "--1.",
                                 "nan", "inf", "-inf", "0x10", "1,5"}) {
    EXPECT_FALSE(parse_nastran_real(text)) << text;
  }
  EXPECT_EQ(parse_nastran_real("1.+400"), std::optional(std::numeric_limits<double>::infinity()));
  EXPECT_EQ(parse_nastran_integer("+12"), std::optional(12));
  EXPECT_EQ(parse_nastran_integer("-12"), std::optional(-12));
  for (const char* const text : {"", "+", "1.", "1 2", "1234567890", "a"}) {
    EXPECT_FALSE(parse_nastran_integer(text)) << text;
  }
}

TEST(NastranReal, WrittenWithAPointInSixteenCharacters) {
  const auto written = [](double value) {
    std::string text;
    append_nastran_real(text, value);
    return text;
  };
  for (const auto& [value, text] :
       std::vector<std::pair<double, std::string>>{{0, "0."},
                                                   {-0.0, "-0."},
                                                   {1, "1."},
                                                   {-0.5, "-0.5"},
                                                   {1200, "1200."},
                                                   {1e14, "100000000000000."},
                                                   {1e15, "1.E+15"},
                                                   {1e-10, "0.0000000001"},
                                                   {1.5e-20, "1.5E-20"},
                                                   {-1e300, "-1.E+300"},
                                                   {5e-324, "5.E-324"},
                                                   {1.0 / 3, ".333333333333333"},
                                                   {-2.0 / 3, "-.66666666666667"},
                                                   {0.1 + 0.2, "0.3"},
                                                   {12345.678901234567, "12345.6789012346"},
                                                   {1.2345678901234567e-7, "1.234567890123-7"},
                                                   {-1.7976931348623157e308, "-1.797693135+308"}}) {
    EXPECT_EQ(written(value), text);
  }
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const double value = std::ldexp(double(random()) * 1e-19 * (i % 2 == 0 ? 1 : -1), int(random() % 400) - 200);
    std::string text;
    const bool is_exact = append_nastran_real(text, value);
    ASSERT_LE(text.size(), 16U);
    ASSERT_NE(text.find('.'), std::string::npos) << text;
    const std::optional<double> back = parse_nastran_real(text);
    ASSERT_TRUE(back) << text;
    EXPECT_EQ(*back == value, is_exact) << text;
    EXPECT_LE(std::fabs(*back - value), 1e-10 * std::fabs(value)) << text;
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
  EXPECT_TRUE(warned("a.bdf: 1 elements lack mid-side nodes"));
  EXPECT_FALSE(read(kTenNodes + "CTETRA,1,7,1,2,3,4\n,,,,\n" + kEnd).second_order);
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(Nastran, SecondOrderIsWrittenAsItCame) {
  const TetMesh m =
      read(kTenNodes + "CTETRA,1,7,1,2,3,4,5,6,+A\n+A,7,8,9,10\nCTRIA6,2,8,1,2,3,5,6,7\nCROD,3,9,1,2\n" + kEnd);
  write_mesh(path("b.bdf"), m, 1);
  const std::string written = get("b.bdf");
  EXPECT_TRUE(contains(written,
                       "CROD           1       9       1       2\n"
                       "CTRIA6         2       8       1       2       3       5       8       6\n"
                       "CTETRA         3       7       1       2       3       4       5       8+\n"
                       "+              6       7       9      10\nENDDATA\n"));
  const TetMesh back = read_mesh(path("b.bdf"), nullptr, 1);
  expect_same(back, m);
  EXPECT_EQ(back.curved_edges, m.curved_edges);
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

TEST_F(Nastran, ErrorsNameTheLineAndTheRemedy) {
  const std::string mesh = kFourNodes + kTet;
  put("nodes.bdf", kFourNodes);
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {"GRID,1,7,0.,0.,0.\n", "a.bdf:1: a node is in the coordinate system 7; only the basic one is read"},
           {columns("GRID", 8, {"1", "7", "0.", "0.", "0."}), "a.bdf:1: a node is in the coordinate system 7"},
           {"GRID,9,0,0.,0.,0.\nGRID,1,,0.,0.,0.\nGRDSET,,3\n", "a.bdf:2: a node is in the coordinate system 3"},
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
           {mesh + "CQUAD8,2,7,1,2,3,4,1\n", "a.bdf:6: CQUAD8 has mid-side nodes; of second order tetune reads CTETRA"},
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

TEST_F(Nastran, TheWrittenFile) {
  TetMesh m = one_tet();
  m.points[1] = {1.0 / 3, -2.5e-9, 1e20};
  m.tet_tags = {7};
  m.triangles = {{0, 1, 2}};
  m.triangle_tags = {8};
  m.deck_nodes = {100, 3, 0, 50};
  write_mesh(path("a.bdf"), m, 1, &warnings_);
  EXPECT_EQ(get("a.bdf"),
            "$ pyNastran: punch=True\n$ tetune\n"
            "GRID*                100                              0.              0.*\n"
            "*                     0.\n"
            "GRID*                  3                .333333333333333   -0.0000000025*\n"
            "*                 1.E+20\n"
            "GRID*                101                              0.              1.*\n"
            "*                     0.\n"
            "GRID*                 50                              0.              0.*\n"
            "*                     1.\n"
            "CTRIA3         1       8     100       3     101\n"
            "CTETRA         2       7     100       3     101      50\n"
            "ENDDATA\n");
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_TRUE(warned("a.bdf: 1 coordinates are rounded to the 16 characters of Nastran's large fields"));
}

TEST_F(Nastran, RoundTripOfAllKinds) {
  TetMesh m = rich();
  m.others.erase(m.others.begin());  // points
  m.point_data.clear();
  m.tet_data.clear();
  m.groups.clear();
  write_mesh(path("a.nas"), m, 2);
  warnings_.clear();
  const TetMesh back = read_mesh(path("a.nas"), &warnings_, 1);
  EXPECT_TRUE(warnings_.empty()) << warnings_[0];
  EXPECT_LT(farthest(m, back), 1e-14);
  EXPECT_EQ(back.tets, m.tets);
  EXPECT_EQ(back.tet_tags, m.tet_tags);
  EXPECT_EQ(back.triangles, m.triangles);
  EXPECT_EQ(back.triangle_tags, m.triangle_tags);
  EXPECT_EQ(back.edges, m.edges);
  EXPECT_EQ(back.edge_tags, m.edge_tags);
  EXPECT_TRUE(same_others(m, back));
  write_mesh(path("b.nas"), back, 1);
  EXPECT_EQ(get("b.nas"), get("a.nas"));
}

TEST_F(Nastran, InsideOutMeshesAreWrittenAsTheyAre) {
  const TetMesh m = read(kFourNodes + "CTETRA,1,7,1,2,4,3\n" + kEnd);
  EXPECT_TRUE(m.listed_inside_out);
  write_mesh(path("b.bdf"), m, 1);
  EXPECT_TRUE(contains(get("b.bdf"), "CTETRA         1       7       1       2       4       3\n"));
}

TEST_F(Nastran, NumbersOfNodesStayWithTheVertices) {
  TetMesh m = cube(4, 0.24);
  std::map<std::int64_t, Point3> number2corner;
  for (std::size_t v = 0; v < m.points.size(); ++v) m.deck_nodes.push_back(static_cast<std::int64_t>(7 * v + 5));
  const auto is_corner = [](const Point3& p) {
    return std::all_of(p.begin(), p.end(), [](double x) { return x == 0 || x == 1; });
  };
  for (std::size_t v = 0; v < m.points.size(); ++v) {
    if (is_corner(m.points[v])) number2corner[m.deck_nodes[v]] = m.points[v];
  }
  ASSERT_EQ(number2corner.size(), 8U);
  write_mesh(path("a.bdf"), m, 1);
  TetMesh optimized = read_mesh(path("a.bdf"), &warnings_, 1);
  EXPECT_TRUE(warnings_.empty()) << warnings_[0];
  ASSERT_EQ(optimized.deck_nodes, m.deck_nodes);
  Options options;
  options.effort = Effort::best;
  options.threads = 1;
  const Report report = optimize(optimized, options);
  ASSERT_FALSE(report.vertex2original.empty()) << "no vertex was inserted or removed";
  ASSERT_EQ(optimized.deck_nodes.size(), optimized.points.size());
  for (std::size_t v = 0; v < optimized.points.size(); ++v) {
    const Index old = report.vertex2original[v];
    EXPECT_EQ(optimized.deck_nodes[v], old < 0 ? 0 : m.deck_nodes[static_cast<std::size_t>(old)]);
  }
  write_mesh(path("b.bdf"), optimized, 1);
  const TetMesh back = read_mesh(path("b.bdf"), nullptr, 1);
  std::size_t found = 0;
  for (std::size_t v = 0; v < back.points.size(); ++v) {
    const auto corner = number2corner.find(back.deck_nodes[v]);
    if (corner == number2corner.end()) continue;
    EXPECT_EQ(back.points[v], corner->second);
    ++found;
  }
  EXPECT_EQ(found, 8U);
  EXPECT_EQ(distinct({back.deck_nodes.begin(), back.deck_nodes.end()}).size(), back.points.size());
  // Other formats number nodes by position.
  warnings_.clear();
  write_mesh(path("b.mesh"), optimized, 1, &warnings_);
  EXPECT_TRUE(warned("the format cannot hold the numbers of nodes"));
}

TEST_F(Nastran, NumbersThatNastranCannotHaveAreReplaced) {
  TetMesh m = one_tet();
  for (const std::vector<std::int64_t>& numbers :
       {std::vector<std::int64_t>{1, 2, 3, 100'000'000}, {1, 2, 3, 3}, {99'999'999, 0, 1, 2}}) {
    m.deck_nodes = numbers;
    warnings_.clear();
    write_mesh(path("a.bdf"), m, 1, &warnings_);
    EXPECT_TRUE(warned("the nodes are numbered from 1"));
    EXPECT_EQ(read_mesh(path("a.bdf"), nullptr, 1).deck_nodes, (std::vector<std::int64_t>{1, 2, 3, 4}));
  }
  m.deck_nodes = {};
  m.points[0][0] = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(contains(write_error(path("a.bdf"), m), "a coordinate is not finite"));
}

TEST_F(Nastran, ElementsAreRenumberedWithAWarning) {
  read(kFourNodes + "CTETRA,5,7,1,2,3,4\nCTRIA3,1,8,1,2,3\n" + kEnd);
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_TRUE(warned("the elements are not numbered from 1 to 2: they get these numbers"));
  read(kFourNodes + "CTETRA,2,7,1,2,3,4\nCTRIA3,1,8,1,2,3\n" + kEnd);
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(Nastran, TagsBecomeNumbersOfProperties) {
  TetMesh m = with_tags({0, 3, -7, -3}, {3});
  write_mesh(path("a.bdf"), m, 1, &warnings_);
  EXPECT_TRUE(warned("of elements of dimension 3 the tag -7 is written as 7, and 2 more"));
  EXPECT_TRUE(warned("elements of different dimensions have the property 3"));
  EXPECT_EQ(distinct(read_mesh(path("a.bdf"), nullptr, 1).tet_tags), (std::set{1, 2, 3, 7}));
}

}  // namespace
}  // namespace tetune::test

// SPDX-License-Identifier: Apache-2.0
// SU2's native meshes.
#include "io_fixture.hpp"

namespace tetune::test {
namespace {

using Su2 = IoTest;

const std::string kTwoSu2 =
    "% two tetrahedra and a pyramid\nNDIME=3\nNELEM= 3\n10 0 1 2 3 0\n% between\n10\t1 2 3 4 1\n14 0 1 2 3 4\n"
    "NPOIN= 5 5\r\n0 0 0 0\n1 0 0 1\n0 1 0 2\n0 0 1 3\n1.5e0 1 1 4\nNMARK= 2\nMARKER_TAG= wall\nMARKER_ELEMS= 2\n"
    "5 0 1 2\n9 0 1 2 3 0\nMARKER_TAG=far_field\nMARKER_ELEMS=1\n5 0 1 3\nNPERIODIC= 1\nPERIODIC_INDEX= 0\n"
    "PERIODIC_CENTER= 0 0 0\nFFD_NBOX= 1\n1 2 3\n";

TEST_F(Su2, ElementsPointsAndMarkers) {
  std::vector<std::string> warnings;
  const TetMesh m = read_mesh(put("a.su2", kTwoSu2), &warnings, 1);
  EXPECT_EQ(m.points, (std::vector<Point3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1.5, 1, 1}}));
  EXPECT_EQ(m.tets, (std::vector<std::array<Index, 4>>{{0, 1, 2, 3}, {1, 2, 3, 4}}));
  EXPECT_EQ(m.triangles, (std::vector<std::array<Index, 3>>{{0, 1, 2}, {0, 1, 3}}));
  EXPECT_EQ(m.triangle_tags, (std::vector{1, 2}));
  ASSERT_EQ(m.groups.size(), 2U);
  EXPECT_EQ(m.groups[0].name, "wall");
  EXPECT_EQ(m.groups[1].name, "far_field");
  ASSERT_EQ(m.others.size(), 2U);
  EXPECT_EQ(m.others[0].kind, "Pyramids");
  EXPECT_EQ(m.others[1].kind, "Quadrilaterals");
  EXPECT_EQ(m.others[1].tags, (std::vector{1}));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "FFD_NBOX"));
}

TEST_F(Su2, PartsOfAPartitionedMeshAreRefused) {
  std::string part = kTwoSu2;
  const std::string marker = "MARKER_ELEMS=1\n";
  part.insert(part.find(marker) + marker.size(), "SEND_TO= 1\n");
  EXPECT_TRUE(contains(read_error(put("a.su2", part)), "use the whole mesh"));
}

TEST_F(Su2, RegionsOfOtherSolidsAreLostWithAWarning) {
  TetMesh m = cube(2, 0.1);
  m.others = {{"Prisms", 6, {0, 1, 2, 3, 4, 5}, {m.tet_tags[0] + 1}, {}}};
  std::vector<std::string> warnings;
  write_mesh(path("a.su2"), m, 1, &warnings);
  EXPECT_TRUE(contains(warnings, "regions"));
}

TEST_F(Su2, RoundTripKeepsBitsMarkersAndOrder) {
  TetMesh m = cube(3, 0.2);
  m.triangles = {{0, 1, 5}, {0, 5, 4}, {1, 2, 6}};
  m.triangle_tags = {7, 8, 9};
  m.groups = {{2, 7, "inlet", {7}}, {2, 8, "no slip", {8}}};
  m.others = {{"Prisms", 6, {0, 1, 2, 3, 4, 5}, {0}, {}}};
  std::vector<std::string> warnings;
  write_mesh(path("a.su2"), m, 1, &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "the group \"no slip\" is written as no_slip"));
  warnings.clear();
  const TetMesh back = read_mesh(path("a.su2"), &warnings, 1);
  EXPECT_TRUE(warnings.empty());
  EXPECT_EQ(back.points, m.points);
  EXPECT_EQ(back.tets, m.tets);
  EXPECT_EQ(back.triangles, m.triangles);
  EXPECT_EQ(back.triangle_tags, (std::vector{1, 2, 3}));
  EXPECT_EQ(back.groups[0].name, "inlet");
  EXPECT_EQ(back.groups[1].name, "no_slip");
  EXPECT_EQ(back.groups[2].name, "patch9");
  EXPECT_EQ(back.others[0].element2vertex, m.others[0].element2vertex);
  write_mesh(path("b.su2"), back, 1);
  EXPECT_EQ(get("a.su2"), get("b.su2"));
}

TEST_F(Su2, NamesOfMarkersMayHoldNumberSigns) {
  std::string text = kTwoSu2;
  text.replace(text.find("wall"), 4, "wall#1  % of the inlet");
  const TetMesh m = read_mesh(put("a.su2", text), nullptr, 1);
  EXPECT_EQ(m.groups[0].name, "wall#1");
}

TEST_F(Su2, DifferentGroupsAreDifferentMarkers) {
  TetMesh m = cube(2, 0.1);
  m.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
  m.triangle_tags = {1, 2, 5, 6};
  m.groups = {{2, 1, "a b", {1}}, {2, 2, "a_b", {2}}, {2, 6, "patch5", {6}}, {3, 7, "steel", {}}};
  std::vector<std::string> warnings;
  write_mesh(path("a.su2"), m, 1, &warnings);
  EXPECT_TRUE(contains(warnings, "the group \"a b\" is written as a_b, the group \"a_b\" is written as a_b_2"));
  EXPECT_TRUE(contains(warnings, "names of groups"));
  const TetMesh back = read_mesh(path("a.su2"), nullptr, 1);
  const std::set<int> tags(back.triangle_tags.begin(), back.triangle_tags.end());
  EXPECT_EQ(tags.size(), 4U);
}

TEST_F(Su2, LossesAreNamed) {
  TetMesh m = cube(2, 0.2);
  m.tet_tags[0] = 5;
  m.point_data = {{"heat", 1, std::vector<double>(m.points.size())}};
  std::vector<std::string> warnings;
  write_mesh(path("a.su2"), m, 1, &warnings);
  ASSERT_EQ(warnings.size(), 3U);
  EXPECT_TRUE(contains(warnings[0], "regions"));
  EXPECT_TRUE(contains(warnings[1], "\"heat\""));
  EXPECT_TRUE(contains(warnings[2], "marker"));
}

TEST_F(Su2, DamageIsNamedWithItsLine) {
  const auto error = [this](const std::string& from, const std::string& to) {
    std::string text = kTwoSu2;
    text.replace(text.find(from), from.size(), to);
    return read_error(put("a.su2", text));
  };
  EXPECT_TRUE(contains(error("NDIME=3", "NDIME= 2"), "a.su2:2: the dimension must be 3"));
  EXPECT_TRUE(contains(error("10 0 1", "11 0 1"), "a.su2:4: elements of type 11"));
  EXPECT_TRUE(contains(error("5 0 1 2", "10 0 1 2 3"), "a.su2:17: elements of type 10 cannot be in a marker"));
  EXPECT_TRUE(contains(error("NELEM= 3", "NELEM= 300000000"), "more than the rest of the file can hold"));
  EXPECT_TRUE(
      contains(error("NELEM= 3", "NELEM= 2"), "a.su2:7: expected a section such as NELEM=, found \"14 0 1 2 3 4\""));
  EXPECT_TRUE(contains(error("NMARK= 2", "NELEM= 0"), "a.su2:14: a second NELEM= section"));
  EXPECT_TRUE(contains(error("MARKER_ELEMS= 2", "MARKER_ELEM= 2"), "MARKER_ELEMS= is expected"));
  EXPECT_TRUE(contains(error("MARKER_TAG= wall", "MARKER_TAG= % wall"), "a.su2:15: MARKER_TAG= has no name"));
  EXPECT_TRUE(contains(error("NPOIN= 5 5", "NPOINTS= 5"), "NPOIN="));
}

TEST_F(Su2, ATruncationIsNoticedButAfterThePointsAndTheLastMarker) {
  const std::string whole = kTwoSu2.substr(0, kTwoSu2.find("\nNPERIODIC"));
  const std::size_t points = whole.find("\nNMARK");
  // A point or an element may lack its number.
  EXPECT_EQ(silent_cuts("a.su2", whole), (std::vector<std::size_t>{points - 2, points - 1, points, points + 1}));
}

}  // namespace
}  // namespace tetune::test

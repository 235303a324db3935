// SPDX-License-Identifier: Apache-2.0
// Universal files of I-deas as they are written.
#include <limits>

#include "mesh_contents.hpp"
#include "support/bits.hpp"
#include "tetune/optimize.hpp"
#include "unv_fixture.hpp"

namespace tetune::test {
namespace {

TEST_F(Unv, TheWrittenFile) {
  TetMesh m = one_tet();
  m.points[1] = {1.0 / 3, -2.5e-9, 1e100};
  m.tet_tags = {7};
  m.triangles = {{0, 1, 2}, {0, 1, 3}};
  m.triangle_tags = {8, 0};
  m.edges = {{0, 1}};
  m.edge_tags = {7};
  m.deck_nodes = {100, 3, 0, 50};
  m.groups = {{2, 5, "hot wall", {8}}};
  m.point_data = {{"node_set:5:hot wall", 1, std::vector<std::uint8_t>{1, 0, 0, 1}}};
  write_mesh(path("a.unv"), m, 1, &warnings_);
  EXPECT_EQ(get("a.unv"),
            "    -1\n"
            "   164\n"
            "         1  SI: Meter (newton)         2\n"
            "   1.0000000000000000D+00   1.0000000000000000D+00   1.0000000000000000D+00\n"
            "   2.7314999999999998D+02\n"
            "    -1\n"
            "    -1\n"
            "  2411\n"
            "       100         1         1        11\n"
            "   0.0000000000000000D+00   0.0000000000000000D+00   0.0000000000000000D+00\n"
            "         3         1         1        11\n"
            "   3.3333333333333331D-01  -2.5000000000000001D-09  1.0000000000000000D+100\n"
            "       101         1         1        11\n"
            "   0.0000000000000000D+00   1.0000000000000000D+00   0.0000000000000000D+00\n"
            "        50         1         1        11\n"
            "   0.0000000000000000D+00   0.0000000000000000D+00   1.0000000000000000D+00\n"
            "    -1\n"
            "    -1\n"
            "  2412\n"
            "         1        11         7         7         7         2\n"
            "         0         1         1\n"
            "       100         3\n"
            "         2        91         8         8         7         3\n"
            "       100         3       101\n"
            "         3        91         0         0         7         3\n"
            "       100         3        50\n"
            "         4       111         7         7         7         4\n"
            "       100         3       101        50\n"
            "    -1\n"
            "    -1\n"
            "  2467\n"
            "         5         0         0         0         0         0         0         3\n"
            "hot wall\n"
            "         7       100         0         0         7        50         0         0\n"
            "         8         2         0         0\n"
            "         7         0         0         0         0         0         0         1\n"
            "Volume7\n"
            "         8         4         0         0\n"
            "         1         0         0         0         0         0         0         1\n"
            "Edge7\n"
            "         8         1         0         0\n"
            "    -1\n");
  EXPECT_TRUE(warnings_.empty()) << warnings_[0];
  const TetMesh back = read_mesh(path("a.unv"), &warnings_, 1);
  EXPECT_TRUE(warnings_.empty()) << warnings_[0];
  EXPECT_EQ(back.points, m.points);
  EXPECT_EQ(back.triangle_tags, m.triangle_tags);
  EXPECT_EQ(back.deck_nodes, (std::vector<std::int64_t>{100, 3, 101, 50}));
  ASSERT_EQ(back.groups.size(), 3U);
  EXPECT_EQ(back.groups[0].name, "hot wall");
  // The number of such a group is the tag, so that other formats keep it.
  EXPECT_EQ(back.groups[2].name, "Edge7");
  EXPECT_EQ(back.groups[2].number, 7);
  ASSERT_EQ(back.point_data.size(), 1U);
  EXPECT_EQ(back.point_data[0].name, m.point_data[0].name);
  EXPECT_EQ(back.point_data[0].values, m.point_data[0].values);
  write_mesh(path("b.unv"), back, 1);
  EXPECT_EQ(get("b.unv"), get("a.unv"));
}

TEST_F(Unv, RoundTripOfAllKinds) {
  for (const bool second : {false, true}) {
    TetMesh m = second ? two_materials(2) : rich();
    m.second_order = second;
    if (second) {
      m.edges = {{m.tets[0][0], m.tets[0][1]}};
      m.edge_tags = {4};
    } else {
      m.others.erase(m.others.begin());  // points
    }
    m.point_data.clear();
    m.tet_data.clear();
    for (ElementBlock& block : m.others) block.data.clear();
    write_mesh(path("a.unv"), m, 2);
    warnings_.clear();
    const TetMesh back = read_mesh(path("a.unv"), &warnings_, 1);
    EXPECT_TRUE(warnings_.empty()) << warnings_[0];
    EXPECT_EQ(back.points, m.points);
    EXPECT_EQ(back.second_order, second);
    EXPECT_TRUE(back.curved_edges.empty());
    EXPECT_EQ(back.tets, m.tets);
    EXPECT_EQ(back.tet_tags, m.tet_tags);
    EXPECT_EQ(back.triangles, m.triangles);
    EXPECT_EQ(back.triangle_tags, m.triangle_tags);
    EXPECT_EQ(back.edges, m.edges);
    EXPECT_EQ(back.edge_tags, m.edge_tags);
    EXPECT_TRUE(same_others(m, back));
    write_mesh(path("b.unv"), back, 1);
    EXPECT_EQ(get("b.unv"), get("a.unv"));
  }
}

TEST_F(Unv, CurvedEdgesKeepTheirNodes) {
  TetMesh m = one_tet();
  m.tet_tags = {1};
  m.second_order = true;
  m.triangles = {{0, 1, 2}};
  m.triangle_tags = {2};
  m.curved_edges = {{{0, 1}, {.6, .1, 0}}, {{2, 3}, {0, .6, .7}}};
  m.point_data = {{"node_set:3:line", 1, std::vector<std::uint8_t>{1, 1, 0, 0}},
                  {"node_set:4:none", 1, std::vector<std::uint8_t>(4, 0)}};
  write_mesh(path("a.unv"), m, 1);
  EXPECT_TRUE(contains(get("a.unv"),
                       "         2       118         1         1         7        10\n"
                       "         1         5         2         8         3         6         7         9\n"
                       "        10         4\n"));
  const TetMesh back = read_mesh(path("a.unv"), &warnings_, 1);
  EXPECT_TRUE(warnings_.empty()) << warnings_[0];
  EXPECT_EQ(back.curved_edges, m.curved_edges);
  ASSERT_EQ(back.point_data.size(), 1U);
  EXPECT_EQ(back.point_data[0].values, m.point_data[0].values);
}

TEST_F(Unv, UnitsStayWithTheFile) {
  const std::string units =
      "         5mm (milli-newton)            2\n  1.00000000000000000D+03  1.00000000000000000D+03  "
      "1.00000000000000000D+00\n  2.73149999999999977D+02\n";
  const TetMesh m = read(unv_set("164", units) + kUnvNodes + unv_set("2412", kUnvTet));
  EXPECT_TRUE(warnings_.empty()) << warnings_[0];
  EXPECT_EQ(m.points, one_tet().points);
  TetMesh optimized = m;
  optimize(optimized);
  write_mesh(path("b.unv"), optimized, 1, &warnings_);
  EXPECT_TRUE(warnings_.empty()) << warnings_[0];
  EXPECT_TRUE(get("b.unv").starts_with(unv_set("164", units)));
  write_mesh(path("b.mesh"), m, 1, &warnings_);
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_TRUE(warned("coordinates are in that of the input, the millimeter"));
  EXPECT_TRUE(contains(error(unv_set("164", "         5mm\n1. x 1.\n") + kUnvNodes), "a factor of units"));
}

TEST_F(Unv, NumbersOfGroupsDiffer) {
  TetMesh m = with_tags({1, 2}, {4});
  m.groups = {{3, 1, "left", {1}}, {2, 1, "wall", {4}}, {3, 2, "all", {1, 2}}};
  write_mesh(path("a.unv"), m, 1, &warnings_);
  EXPECT_TRUE(warned("1 groups get other numbers"));
  const TetMesh back = read_mesh(path("a.unv"), nullptr, 1);
  EXPECT_TRUE(same_tags(m, back));
  ASSERT_EQ(back.groups.size(), 3U);
  for (const Group& group : m.groups) {
    const auto at = std::find_if(back.groups.begin(), back.groups.end(),
                                 [&](const Group& g) { return g.name == group.name && g.tags == group.tags; });
    EXPECT_NE(at, back.groups.end()) << group.name;
  }
  m.groups = {{3, 1, "two\nlines ", {1}}};
  warnings_.clear();
  write_mesh(path("a.unv"), m, 1, &warnings_);
  EXPECT_TRUE(warned("the group \"two?lines \" is written as two?lines"));
  // Ten digits can be beyond 32 bits.
  const std::string zeros = "         0         0         0         0         0         0";
  const std::string set = "5000000000" + zeros +
                          "         2\nload\n         7         1         0         0         7" +
                          "         2         0         0\n";
  m = read(kUnvNodes + unv_set("2412", kUnvTet) + unv_set("2467", set));
  ASSERT_EQ(m.point_data.size(), 1U);
  EXPECT_EQ(m.point_data[0].name, "node_set:5000000000:load");
  write_mesh(path("a.unv"), m, 1, &warnings_);
  EXPECT_TRUE(warned("1 groups get other numbers"));
  EXPECT_EQ(read_mesh(path("a.unv"), nullptr, 1).point_data[0].name, "node_set:1:load");
}

TEST_F(Unv, GroupsThatAreNamedLikeThoseOfTagsKeepTheirNumbers) {
  const std::string elements =
      "         1        91         7         7         7         3\n         1         2         3\n"
      "         2        91         8         8         7         3\n         1         2         4\n"
      "         3       111         7         7         7         4\n         1         2         3         4\n";
  const auto group = [](const std::string& number, const std::string& name, const std::string& element) {
    return std::string(10 - number.size(), ' ') + number +
           "         0         0         0         0         0         0         1\n" + name + "\n         8         " +
           element + "         0         0\n";
  };
  for (const std::vector<std::string>& groups : {std::vector{group("12", "Volume7", "3"), group("9", "Surface8", "2")},
                                                 std::vector{group("7", "inlet", "2"), group("1", "Surface7", "1")},
                                                 std::vector{group("7", "inlet", "2"), group("12", "Volume7", "3")}}) {
    const TetMesh m = read(kUnvNodes + unv_set("2412", elements) + unv_set("2467", groups[0] + groups[1]));
    EXPECT_EQ(m.tet_tags, std::vector<int>{7});
    EXPECT_EQ(m.triangle_tags, (std::vector<int>{7, 8}));
    write_mesh(path("b.unv"), m, 1);
    const std::string written = get("b.unv");
    for (const std::string& record : groups) EXPECT_TRUE(contains(written, record)) << record << written;
    write_mesh(path("c.unv"), read_mesh(path("b.unv"), nullptr, 1), 1);
    EXPECT_EQ(get("c.unv"), written);
  }
}

TEST_F(Unv, NumbersThatTheFormatCannotHave) {
  TetMesh m = one_tet();
  m.deck_nodes = {1, 2, 3, 1'000'000'000};
  write_mesh(path("a.unv"), m, 1, &warnings_);
  EXPECT_TRUE(warned("the nodes are numbered from 1"));
  m.points[0][0] = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(contains(write_error(path("a.unv"), m), "a coordinate is not finite"));
  m = one_tet();
  m.others = {{"Heptahedra", 7, {0, 1, 2, 3, 0, 1, 2}, {1}, {}}};
  EXPECT_TRUE(contains(write_error(path("a.unv"), m), "universal files have no elements of kind Heptahedra"));
}

}  // namespace
}  // namespace tetune::test

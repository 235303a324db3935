// SPDX-License-Identifier: Apache-2.0
// Nastran's bulk data as they are written.
#include <algorithm>
#include <cmath>

#include "io/nastran/nastran_fields.hpp"
#include "io/real_field.hpp"
#include "mesh_contents.hpp"
#include "nastran_fixture.hpp"
#include "support/bits.hpp"
#include "tetune/optimize.hpp"

namespace tetune::test {
namespace {

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
    const std::optional<double> back = parse_fortran_real(text);
    ASSERT_TRUE(back) << text;
    EXPECT_EQ(*back == value, is_exact) << text;
    EXPECT_LE(std::fabs(*back - value), 1e-10 * std::fabs(value)) << text;
  }
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

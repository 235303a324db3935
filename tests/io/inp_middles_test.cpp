// SPDX-License-Identifier: Apache-2.0
// Decks of second-order tetrahedra.
#include <algorithm>

#include "inp_fixture.hpp"

namespace tetune::test {
namespace {

using InpMiddles = IoTest;

TEST_F(InpMiddles, AMiddleThatACardNamesHoldsItsEdge) {
  TetMesh m = read_mesh(put("a.inp", kTwoQuadratic + "*CLOAD\n13, 1, 5.\n"), nullptr, 1);
  EXPECT_TRUE(m.second_order);
  EXPECT_TRUE(m.curved_edges.empty());
  EXPECT_EQ(m.points.size(), 5U);
  EXPECT_EQ(m.edges, (std::vector<std::array<Index, 2>>{{2, 3}}));
  EXPECT_EQ(m.required_edges, std::vector<Index>{0});
  EXPECT_EQ(m.required_vertices, (std::vector<Index>{2, 3}));
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), get("a.inp"));
  // Three tetrahedra around the edge between 1 and 5 take the place of the two: their edges are those of before.
  m.tets = {{0, 1, 2, 4}, {0, 2, 3, 4}, {0, 3, 1, 4}};
  m.tet_tags = std::vector<int>(3, m.tet_tags[0]);
  write_mesh(path("b.inp"), m, 1);
  EXPECT_TRUE(contains(get("b.inp"), "34, 0.5, 0.5, 0.5\n"));
  // Without the tetrahedron at it the edge is gone.
  m.tets.erase(m.tets.begin() + 1);
  m.tet_tags.pop_back();
  m.tets[0] = {0, 1, 2, 4};
  m.tets[1] = {0, 3, 1, 4};
  EXPECT_TRUE(
      contains(write_error(path("b.inp"), m), "the edge of the mid-side node 13, which the deck names, is gone"));
}

/// As after a computation of temperatures, whose results are by number.
TEST_F(InpMiddles, ValuesOfAFieldHoldNoEdge) {
  const std::string of_vertices = "*TEMPERATURE\n1, 0.\n2, 10.\n3, 20.\n4, 30.\n5, 40.\n";
  const std::string cards = of_vertices + "** of middles\n12, 15.\n13, 25.\n14, 20.\n";
  TetMesh m = read_mesh(put("a.inp", kTwoQuadratic + cards), nullptr, 1);
  EXPECT_TRUE(m.edges.empty());
  EXPECT_EQ(m.required_vertices.size(), 5U);
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), get("a.inp"));
  m.tets = {{0, 1, 2, 4}, {0, 3, 1, 4}};
  write_mesh(path("b.inp"), m, 1);
  EXPECT_TRUE(get("b.inp").ends_with(of_vertices + "** of middles\n12, 15.\n14, 20.\n34, 20\n")) << get("b.inp");

  // Where an end has none, a new middle could have none; and other cards hold nodes as before.
  const TetMesh partly = read_mesh(put("c.inp", kTwoQuadratic + "*TEMPERATURE\n3, 20.\n13, 25.\n"), nullptr, 1);
  EXPECT_EQ(partly.required_edges.size(), 1U);
  const TetMesh loaded = read_mesh(put("d.inp", kTwoQuadratic + cards + "*CLOAD\n12, 1, 5.\n"), nullptr, 1);
  EXPECT_EQ(loaded.required_edges.size(), 1U);
  const TetMesh continued =
      read_mesh(put("e.inp", kTwoQuadratic + cards + "1, 0., 1., 2., 3., 4., 5., 6.\n"), nullptr, 1);
  EXPECT_EQ(continued.required_edges.size(), 3U);
}

TEST_F(InpMiddles, NewOnesJoinTheSetsThatHaveAllOfThem) {
  const std::string cards =
      "*NSET, NSET=VERTICES, GENERATE\n1, 5, 1\n*NSET, NSET=EACH, GENERATE\n1, 33, 1\n"
      "*NSET, NSET=SOME\n1, 2, 3, 4, 5, 13\n";
  TetMesh m = read_mesh(put("a.inp", kTwoQuadratic + cards), nullptr, 1);
  // SOME has one of nine, which can only be held.
  EXPECT_EQ(m.edges, (std::vector<std::array<Index, 2>>{{2, 3}}));
  m.tets = {{0, 1, 2, 4}, {0, 2, 3, 4}, {0, 3, 1, 4}};
  m.tet_tags = std::vector<int>(3, m.tet_tags[0]);
  write_mesh(path("b.inp"), m, 1);
  const std::string text = get("b.inp");
  EXPECT_TRUE(contains(text, "*NSET, NSET=VERTICES, GENERATE\n1, 5, 1\n"));
  EXPECT_TRUE(contains(text, "*NSET, NSET=SOME\n1, 2, 3, 4, 5, 13\n"));
  EXPECT_TRUE(contains(text, "*NSET, NSET=EACH\n"));
  EXPECT_TRUE(contains(text, "33, 34\n"));
}

TEST_F(InpMiddles, CurvedOnesKeepTheirBits) {
  std::string text = kTwoQuadratic;
  text.replace(text.find("33, 0.5, 0.5, 1."), 16, "33, 0.5, 0.5, 1.1234567890123");
  const TetMesh m = read_mesh(put("a.inp", text), nullptr, 1);
  ASSERT_EQ(m.curved_edges.size(), 1U);
  EXPECT_EQ(m.curved_edges[0].vertices, (std::array<Index, 2>{3, 4}));
  EXPECT_EQ(m.curved_edges[0].middle, (Point3{0.5, 0.5, 1.1234567890123}));
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), text);
}

TEST_F(InpMiddles, DamagedElementsAreRefused) {
  const auto refused = [this](const std::string& of, const std::string& to, const char* said) {
    std::string text = kTwoQuadratic;
    text.replace(text.find(of), of.size(), to);
    EXPECT_TRUE(contains(read_error(put("a.inp", text)), said));
  };
  refused("5, 12, 13, 14, 31", "5, 12, 13, 14, 32", "node 32 is a mid-side node of the edge");
  refused("5, 12, 13, 14, 31", "5, 31, 13, 14, 12", "the edge between node 2 and node 3, which has another one");
  refused("1, 1, 2, 3, 4, 21", "1, 1, 2, 3, 4, 5", "and also a vertex or on another edge");
  refused("31, 32, 33\n", "31, 32\n", "a.inp:19: element 2 has 9 nodes instead of 10");
  refused("*ELEMENT", "*ELEMENT, TYPE=B31\n9, 1, 21\n*ELEMENT", "node 21 is a mid-side node and a vertex of another");
}

}  // namespace
}  // namespace tetune::test

// SPDX-License-Identifier: Apache-2.0
// Inserted nodes in the sets and conditions of decks.
#include "io_fixture.hpp"

namespace tetune::test {
namespace {

/// Two tetrahedra with the common face 20, 30, 40.
const std::string kPair =
    "*NODE\n10, 0., 0., 0.\n20, 1., 0., 0.\n30, 0., 1., 0.\n40, 0., 0., 1.\n50, 1., 1., 1.\n"
    "*ELEMENT, TYPE=C3D4\n7, 10, 20, 30, 40\n8, 20, 30, 40, 50\n";

class InpInsertedNodes : public IoTest {
 protected:
  TetMesh read(const std::string& text) { return read_mesh(put("a.inp", text), nullptr, 1); }
  /// Writes the mesh with a vertex more, which gets the number after the largest, and other tetrahedra.
  std::string with_vertex(TetMesh m, const Point3& p, const std::vector<std::array<Index, 4>>& tets) {
    m.points.push_back(p);
    m.point_tags.push_back(0);
    m.deck_nodes.push_back(0);
    m.tets = tets;
    m.tet_tags.assign(tets.size(), m.tet_tags[0]);
    m.required_tets.clear();
    warnings_.clear();
    write_mesh(path("b.inp"), m, 1, &warnings_);
    return get("b.inp");
  }
  /// Likewise with the vertex on the edge between the first two.
  std::string on_edge(const TetMesh& m, const Point3& p) {
    return with_vertex(m, p, {{5, 1, 2, 3}, {0, 5, 2, 3}, {1, 2, 3, 4}});
  }
  /// Likewise inside of the first tetrahedron.
  std::string inside(const TetMesh& m, const Point3& p) {
    return with_vertex(m, p, {{5, 1, 2, 3}, {0, 5, 2, 3}, {0, 1, 5, 3}, {0, 1, 2, 5}, {1, 2, 3, 4}});
  }
  std::vector<std::string> warnings_;
};

TEST_F(InpInsertedNodes, JoinTheSetsOfTheNodesBetweenWhichTheyAre) {
  const TetMesh m = read(kPair + "*NSET, NSET=LINE\n10, 20\n*NSET, NSET=ENDS\n10, 50\n*NSET, NSET=BOTH\nLINE, ENDS\n");
  const std::string text = on_edge(m, {0.25, 0, 0});
  EXPECT_TRUE(contains(text, "*NSET, NSET=LINE\n10, 20, 51\n*NSET, NSET=ENDS\n10, 50\n*NSET, NSET=BOTH\nLINE, ENDS\n"));
  EXPECT_TRUE(contains(inside(m, {0.25, 0.25, 0.25}), "*NSET, NSET=LINE\n10, 20\n"));
  // After a motion.
  TetMesh moved = m;
  for (Point3& p : moved.points) p[0] += 3;
  EXPECT_TRUE(contains(on_edge(moved, {3.25, 0, 0}), "*NSET, NSET=LINE\n10, 20, 51\n"));
  // Also inside, where the nodes of the line have a value by a set alone.
  moved = read(kPair + "*NSET, NSET=LINE\n10, 20\n*TEMPERATURE\nLINE, 5.\n10, 5.\n");
  for (Point3& p : moved.points) p[0] += 3;
  EXPECT_TRUE(contains(on_edge(moved, {3.25, 0, 0}), "*NSET, NSET=LINE\n10, 20, 51\n"));
  // The load would act on the node too.
  const TetMesh loaded = read(kPair + "*NSET, NSET=LINE\n10, 20\n*CLOAD\nLINE, 1, 3.\n");
  EXPECT_TRUE(contains(on_edge(loaded, {0.25, 0, 0}), "*NSET, NSET=LINE\n10, 20\n"));
}

TEST_F(InpInsertedNodes, HaveTheConditionsThatAllOfTheseHave) {
  const TetMesh m = read(kPair +
                         "*NSET, NSET=SIDE\n20, 40\n"
                         "*BOUNDARY\n10, 1, 3\n20, 1\n** a comment\n20, 2, 2, 0.5\n30, 1, 3\n"
                         "*INITIAL CONDITIONS, TYPE=TEMPERATURE\n10, 20.\n20, 30.\n*STEP\n*BOUNDARY\n10, 3\n"
                         "*BOUNDARY, FIXED\n10, ENCASTRE\n20, Encastre\n*CLOAD\n10, 1, 4.\n20, 1, 4.\n"
                         "*SURFACE, NAME=S, TYPE=NODE\n10\n20,\n*TEMPERATURE\nSIDE, 5.\n10, 7.0, 8");
  const std::string text = on_edge(m, {0.25, 0, 0});
  EXPECT_TRUE(contains(text, "30, 1, 3\n51, 1, 1\n51, 2, 2, 0.125\n*INITIAL"));
  EXPECT_TRUE(contains(text,
                       "20, 30.\n51, 22.5\n*STEP\n*BOUNDARY\n10, 3\n*BOUNDARY, FIXED\n10, ENCASTRE\n20, Encastre\n"
                       "51, ENCASTRE\n*CLOAD\n10, 1, 4.\n20, 1, 4.\n*SURFACE, NAME=S, TYPE=NODE\n10\n20,\n51\n"));
  EXPECT_TRUE(text.ends_with("*TEMPERATURE\nSIDE, 5.\n10, 7.0, 8\n51, 6.5, 6\n")) << text;
  EXPECT_TRUE(warnings_.empty());
  // Between nodes of which not all have a value.
  EXPECT_FALSE(contains(inside(m, {0.25, 0.25, 0.25}), "\n51, 1, "));
  ASSERT_EQ(warnings_.size(), 2U);
  EXPECT_TRUE(contains(warnings_[0], "1 inserted node has no value in *INITIAL CONDITIONS, as they are not between"));
  EXPECT_TRUE(contains(warnings_[1], "*TEMPERATURE"));
}

TEST_F(InpInsertedNodes, OfTheInsideHaveFieldsOfTheSurfaceAndNotItsSupports) {
  std::string text = kPair + "*BOUNDARY\n10, 1\n20, 1\n30, 1\n40, 1\n*TEMPERATURE\n10, 1.\n20, 2.\n30, 1.\n40, 1.\n";
  EXPECT_TRUE(inside(read(text), {0.5, 0.25, 0.125})
                  .ends_with("40, 1\n*TEMPERATURE\n10, 1.\n20, 2.\n30, 1.\n40, 1.\n51, 1.5\n"));
  // A set has its value by its name alone, unless a line after it names a node.
  text = kPair + "*NSET, NSET=ALL, GENERATE\n10, 50\n*TEMPERATURE\n10, 4.\nALL, 2.\n";
  EXPECT_TRUE(inside(read(text), {0.25, 0.25, 0.25}).ends_with("*TEMPERATURE\n10, 4.\nALL, 2.\n"));
  text += "20, 4.\n";
  EXPECT_TRUE(inside(read(text), {0.25, 0.25, 0.25}).ends_with("20, 4.\n51, 2.5\n"));
}

TEST_F(InpInsertedNodes, BetweenDifferentSetsHaveFieldsAndNoSupports) {
  const std::string sets = kPair + "*NSET, NSET=A\n10, 30\n*NSET, NSET=B\n20, 50\n";
  EXPECT_TRUE(on_edge(read(sets + "*TEMPERATURE\nA, 10.\nB, 20.\n"), {0.25, 0, 0}).ends_with("B, 20.\n51, 12.5\n"));
  EXPECT_TRUE(warnings_.empty());
  EXPECT_TRUE(on_edge(read(sets + "*BOUNDARY\nA, 1\nB, 1\n"), {0.25, 0, 0}).ends_with("A, 1\nB, 1\n"));
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_TRUE(
      contains(warnings_[0], "1 inserted node has no value in *BOUNDARY, as they are between nodes of different"));
}

TEST_F(InpInsertedNodes, HaveNoLinesWhereTheValueIsInDoubt) {
  for (const std::string card :
       {"*SURFACE, NAME=S, TYPE=NODE\n10, 2.\n20, 2.\n", "*TEMPERATURE\n10, 1.e400\n20, 3.\n",
        "*INITIAL CONDITIONS, TYPE=FIELD, VARIABLE=9\n10, 1., 1., 1., 1., 1., 1., 1.\n20, 5.\n20, 1.\n"}) {
    EXPECT_TRUE(on_edge(read(kPair + card), {0.25, 0, 0}).ends_with(card)) << get("b.inp");
  }
}

TEST_F(InpInsertedNodes, InSecondOrderDecks) {
  const std::string nodes =
      "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n4, 0., 0., 1.\n"
      "12, 0.5, 0.5, 0.\n13, 0., 0.5, 0.5\n14, 0.5, 0., 0.5\n21, 0.5, 0., 0.\n22, 0., 0.5, 0.\n23, 0., 0., 0.5\n"
      "*ELEMENT, TYPE=C3D10\n1, 1, 2, 3, 4, 21, 12, 22, 23,\n14, 13\n";
  const std::string vertices = "*TEMPERATURE\n1, 0.\n2, 10.\n3, 0.\n4, 0.\n";
  const std::vector<std::array<Index, 4>> split{{4, 1, 2, 3}, {0, 4, 2, 3}, {0, 1, 4, 3}, {0, 1, 2, 4}};
  const Point3 p{0.5, 0.25, 0.125};
  const TetMesh all = read(nodes + vertices + "12, 5.\n13, 0.\n14, 5.\n21, 5.\n22, 0.\n23, 0.\n");
  // The vertex, and the mid-side nodes of its edges to the others.
  EXPECT_TRUE(with_vertex(all, p, split).ends_with("\n23, 0.\n24, 5\n25, 2.5\n26, 7.5\n27, 2.5\n28, 2.5\n"))
      << get("b.inp");
  EXPECT_TRUE(with_vertex(read(nodes + vertices), p, split).ends_with("\n4, 0.\n24, 5\n"));
  // Supports of a face.
  const TetMesh held = read(nodes + "*NSET, NSET=N\n2, 3\n*BOUNDARY\n1, 3\n2, 3\n3, 3\n12, 3\n21, 3\n22, 3\n");
  const std::string text = with_vertex(held, {0.25, 0.25, 0}, {{4, 1, 2, 3}, {0, 4, 2, 3}, {0, 1, 4, 3}});
  EXPECT_TRUE(
      text.ends_with("*NSET, NSET=N\n2, 3\n*BOUNDARY\n1, 3\n2, 3\n3, 3\n12, 3\n21, 3\n22, 3\n"
                     "24, 3, 3\n25, 3, 3\n26, 3, 3\n27, 3, 3\n"))
      << text;
  // Not of the edge through the solid, though both of its ends have them.
  const std::string supports = "*BOUNDARY\n1, 3\n2, 3\n3, 3\n4, 3\n12, 3\n13, 3\n14, 3\n21, 3\n22, 3\n23, 3\n";
  EXPECT_TRUE(with_vertex(read(nodes + supports), {0.25, 0.25, 0}, {{4, 1, 2, 3}, {0, 4, 2, 3}, {0, 1, 4, 3}})
                  .ends_with("\n23, 3\n24, 3, 3\n25, 3, 3\n26, 3, 3\n27, 3, 3\n"))
      << get("b.inp");
  // The value of the vertex is by a set, in which it is.
  const TetMesh by_set = read(nodes +
                              "*NSET, NSET=V\n1, 2, 3, 4\n*TEMPERATURE\nV, 5.\n12, 5.\n13, 5.\n14, 5.\n"
                              "21, 5.\n22, 5.\n23, 5.\n");
  EXPECT_TRUE(with_vertex(by_set, {0.25, 0.25, 0}, {{4, 1, 2, 3}, {0, 4, 2, 3}, {0, 1, 4, 3}})
                  .ends_with("\n23, 5.\n25, 5.\n26, 5.\n27, 5.\n28, 5.\n"))
      << get("b.inp");
}

}  // namespace
}  // namespace tetune::test

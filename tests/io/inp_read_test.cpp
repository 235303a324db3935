// SPDX-License-Identifier: Apache-2.0
// Decks of Abaqus and CalculiX that are read: numbers, sets, surfaces, and what other cards hold.
#include "inp_fixture.hpp"

namespace tetune::test {
namespace {

const std::string kNodes =
    "*NODE\n10, 0., 0., 0.\n20, 1., 0., 0.\n30, 0., 1., 0.\n40, 0., 0., 1.\n9000000000000000050, 1., 1., 1.\n";

TEST_F(Inp, NumbersOf64BitsMayHaveGaps) {
  const TetMesh m = read_mesh(put("a.inp", kTwoTets), nullptr, 1);
  EXPECT_EQ(m.points, (std::vector<Point3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}));
  EXPECT_EQ(m.tets, (std::vector<std::array<Index, 4>>{{0, 1, 2, 3}, {1, 2, 3, 4}}));
  EXPECT_EQ(m.tet_tags, (std::vector{0, 0}));
  EXPECT_EQ(m.deck_nodes, (std::vector<std::int64_t>{10, 20, 30, 40, 900000000000000050}));
  EXPECT_TRUE(contains(read_error(put("b.inp", kNodes)), "b.inp:6: expected the number of a node"));  // of 19 digits
}

TEST_F(Inp, EachCombinationOfSetsIsATag) {
  const std::string sets =
      "*ELSET, ELSET=A\n7\n*elset, elset=\"b c\"\na, 800000000000000000\n*ELSET, ELSET=none\n*ELSET, ELSET=Volume12\n"
      "800000000000000000\n";
  const TetMesh m = read_mesh(put("a.inp", kTwoTets + sets), nullptr, 1);
  EXPECT_EQ(m.tet_tags, (std::vector{1, 12}));
  const std::map<std::string, std::vector<int>> expected{{"A", {1}}, {"b c", {1, 12}}};
  EXPECT_EQ(groups_of(m, 3), expected);
}

TEST_F(Inp, SurfacesAndSetsOfNodesAreTriangles) {
  const std::string cards =
      "*SURFACE, NAME=OUT\n7, S1\n7, S2\n*SURFACE, NAME=IN, TYPE=ELEMENT\n7, S3\n*NSET, NSET=N\n10, 20, 30\n"
      "*NSET, NSET=SIDE\n10, 30, 40\n*NSET, NSET=POINT\n900000000000000050\n*NSET, NSET=ALL, GENERATE\n"
      "10, 900000000000000050, 10\n*NSET, NSET=OF, ELSET=NONE\n";
  const TetMesh m = read_mesh(put("a.inp", kTwoTets + cards), nullptr, 1);
  // The faces of OUT and IN, with their normals outwards of element 7, and that of SIDE.
  EXPECT_EQ(m.triangles, (std::vector<std::array<Index, 3>>{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}));
  const std::map<std::string, std::vector<int>> expected{{"OUT", {1, 3}}, {"IN", {2}}, {"N", {3}}, {"SIDE", {4}}};
  EXPECT_EQ(groups_of(m, 2), expected);
  EXPECT_EQ(m.triangle_tags, (std::vector{3, 1, 2, 4}));
  EXPECT_EQ(groups_of(m, 2)["IN"].size(), 1U);
  EXPECT_EQ(groups_of(m, 2)["OUT"].size(), 2U);
  EXPECT_EQ(m.triangle_tags[0], groups_of(m, 2)["N"].at(0));
  EXPECT_EQ(m.triangle_tags[3], groups_of(m, 2)["SIDE"].at(0));
  EXPECT_EQ(m.required_vertices, std::vector<Index>{4});
}

TEST_F(Inp, SetsOfSetsHaveEachMemberOnce) {
  std::string cards = "*NSET, NSET=S0\n10, 20, 30\n";
  for (int i = 1; i <= 60; ++i) {
    const std::string inner = "S" + std::to_string(i - 1);
    cards += "*NSET, NSET=S" + std::to_string(i) + "\n" + inner + ", " + inner + "\n";
  }
  const TetMesh m = read_mesh(put("a.inp", kTwoTets + cards), nullptr, 1);
  EXPECT_EQ(m.triangles.size(), 1U);
}

TEST_F(Inp, LinesOfGenerateAreNumbers) {
  for (const char* line : {"first, 10, 1", "10, , 10", "10, 20, 0", "10", "10, 20, 10, 5"}) {
    EXPECT_THROW(read_mesh(put("a.inp", kTwoTets + "*NSET, NSET=A, GENERATE\n" + line + "\n"), nullptr, 1), FileError)
        << line;
  }
  const std::string second = kTwoTets + "*NSET, NSET=A, GENERATE\n10, 20, 10\n10, 20, 0\n";
  EXPECT_TRUE(contains(read_error(put("a.inp", second)), "a.inp:12: this line of a set should be FIRST, LAST, STEP"));
}

TEST_F(Inp, WhatOtherCardsNameByNumberIsHeld) {
  const std::string cards =
      "*BOUNDARY\n10, 1, 3\n*EQUATION\n2\n20, 1, 1., 30, 1, -1.\n*INITIAL CONDITIONS, TYPE=STRESS\n7, 1., 1., 1.\n"
      "*RIGID BODY, REF NODE=40\n*AMPLITUDE, NAME=X\n900000000000000050, 1.\n";
  const TetMesh m = read_mesh(put("a.inp", kTwoTets + cards), nullptr, 1);
  EXPECT_EQ(m.required_vertices, (std::vector<Index>{0, 1, 2, 3}));
  EXPECT_EQ(m.required_tets, std::vector<Index>{0});
}

TEST_F(Inp, CardsThatAreNotKnownHoldTheFirstFields) {
  const std::string cards =
      "*KINEMATIC COUPLING, REF NODE=40\n10, 1, 3\n*CFILM\n20, 1., 300., 10.\n*MODEL CHANGE, REMOVE\nX, 7\n"
      "*NEW CARD\n800000000000000000, 30\n*ELASTIC\n30, 0.3\n*HEADING\n30\n*ELSET, ELSET=X\n7\n";
  const TetMesh m = read_mesh(put("a.inp", kTwoTets + cards), nullptr, 1);
  EXPECT_EQ(m.required_vertices, (std::vector<Index>{0, 1, 3}));
  EXPECT_EQ(m.required_tets, (std::vector<Index>{0, 1}));
}

TEST_F(Inp, FlowsAndChargesOnFacesAreTriangles) {
  for (const char* card : {"*FLOW\n7, Q1, 0., 1.\n", "*DFLOW\n7, s1, 1.\n", "*DECHARGE\n7, ES1, 1.\n",
                           "*DECURRENT\n7, CS1, 1.\n", "*DLOAD\n7, TRVEC1NU, 1.\n"}) {
    const TetMesh m = read_mesh(put("a.inp", kTwoTets + card), nullptr, 1);
    EXPECT_EQ(m.triangles.size(), 1U) << card;
    EXPECT_TRUE(m.required_tets.empty()) << card;
  }
  for (const char* card : {"*DLOAD\n7, GRAV, 1., 0., 0., 1.\n", "*DLOAD\n7, P5, 1.\n", "*SURFACE, NAME=S\n7,\n"}) {
    const TetMesh m = read_mesh(put("a.inp", kTwoTets + card), nullptr, 1);
    EXPECT_EQ(m.triangles.size(), 0U) << card;
    EXPECT_EQ(m.required_tets, std::vector<Index>{0}) << card;
  }
}

TEST_F(Inp, LinesOfSurfacesWithoutAnElementAreNoFaces) {
  for (const char* card : {"*SURFACE, NAME=S\n, S1\n", "*SURFACE, NAME=S\n , S1\n7, S2\n", "*DLOAD\n,P1,1.\n"}) {
    const std::string text = kTwoTets + card;
    const TetMesh m = read_mesh(put("a.inp", text), nullptr, 1);
    EXPECT_EQ(m.triangles.size(), contains(card, "S2") ? 1U : 0U) << card;
    write_mesh(path("b.inp"), m, 1);
    EXPECT_EQ(get("b.inp"), text) << card;
  }
}

TEST_F(Inp, LinesAreCountedOverContinuedOnes) {
  const std::string cards =
      "*NSET,\n NSET=A\n10\n*SOLID SECTION, ELSET=E,\n1.\n*ELEMENT, TYPE=C3D4\n9, 10, 20,\n30, 40\n";
  EXPECT_TRUE(contains(read_error(put("a.inp", kTwoTets + cards + "*NSET\n")), "a.inp:18: *NSET has no name"));
  EXPECT_TRUE(contains(read_error(put("a.inp", kTwoTets + cards + "10, x\n")), "a.inp:18: "));
}

TEST_F(Inp, AnElementWithANodeTooFewIsNamedWithItsLine) {
  const std::string hexes = "*ELEMENT, TYPE=C3D8\n7, 10, 20, 30, 40, 10, 20, 30";
  const std::string next = "\n8, 10, 20, 30, 40, 10, 20, 30, 40\n";
  const std::string head = kTwoTets.substr(0, kTwoTets.find("*ELEMENT"));
  for (const auto& [elements, said] : std::vector<std::pair<std::string, std::string>>{
           {"*ELEMENT, TYPE=C3D4\n7, 10, 20, 30\n8, 10, 20, 30, 40\n", "a.inp:8: element 7 has 3 nodes instead of 4"},
           {"*ELEMENT, TYPE=C3D4\n7, 10, 20, 30,\n8, 10, 20, 30, 40\n",
            "a.inp:8: element 7 has fewer than 4 nodes before line 9, which has more numbers than it lacks"},
           {"*ELEMENT, TYPE=C3D4\n7, 10, 20, 30,\n** c\n*STEP\n", "a.inp:8: element 7 has 3 nodes instead of 4"},
           {"*ELEMENT, TYPE=C3D4\n7, 10, 20, 30,\n", "a.inp:8: element 7 has 3 nodes instead of 4"},
           // Without a comma, too: elements of many nodes may continue without one.
           {hexes + next, "a.inp:8: element 7 has fewer than 8 nodes before line 9"},
           {hexes + "," + next, "a.inp:8: element 7 has fewer than 8 nodes before line 9"},
           {hexes + "\n** c\n*STEP\n", "a.inp:8: element 7 has 7 nodes instead of 8"},
           {hexes, "a.inp:8: element 7 has 7 nodes instead of 8"}}) {
    const std::string error = read_error(put("a.inp", head + elements));
    EXPECT_TRUE(contains(error, said)) << error;
  }
  // More numbers in the line of an element are ignored.
  const TetMesh m = read_mesh(put("a.inp", kTwoTets + "*ELEMENT, TYPE=S3\n9, 10, 20, 30, 5, 6\n"), nullptr, 1);
  EXPECT_EQ(m.triangles, (std::vector<std::array<Index, 3>>{{0, 1, 2}}));
}

TEST_F(Inp, AnAuxiliarySetMayHaveTwoCards) {
  const std::string cards = "*ELSET, ELSET=F\n7\n*ELSET, ELSET=F\n800000000000000000\n*SURFACE, NAME=S\nF, S2\n";
  const TetMesh m = read_mesh(put("a.inp", kTwoTets + cards), nullptr, 1);
  EXPECT_EQ(m.triangles.size(), 2U);
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), get("a.inp"));
}

/// After a 2-3 flip all faces of the surface are the first ones of their elements.
TEST_F(Inp, AnAuxiliarySetWithoutElementsIsNotNamed) {
  const std::string cards =
      "*ELSET, ELSET=F1\n7\n*ELSET, ELSET=F2\n7\n*ELSET, ELSET=F4\n7\n*SURFACE, NAME=S\nF1, S1\nF2, S2\nF4, S4\n";
  for (const bool of_load : {false, true}) {
    std::string text = kTwoTets + cards;
    if (of_load) text.replace(text.find("*SURFACE"), text.npos, "*DLOAD\nF1, P1, 2.\nF2, P2, 2.\nF4, P4, 2.\n");
    TetMesh m = read_mesh(put("a.inp", text), nullptr, 1);
    ASSERT_EQ(m.triangles.size(), 3U);
    m.tets = {{0, 1, 2, 4}, {0, 2, 3, 4}, {0, 3, 1, 4}};
    m.tet_tags = std::vector<int>(3, m.tet_tags[0]);
    write_mesh(path("b.inp"), m, 1);
    EXPECT_TRUE(contains(get("b.inp"), of_load ? "F1, P1, 2.\n" : "F1, S1\n"));
    EXPECT_FALSE(contains(get("b.inp"), "F2"));
    EXPECT_FALSE(contains(get("b.inp"), "F4"));
    EXPECT_EQ(read_mesh(path("b.inp"), nullptr, 1).triangles.size(), 3U);
  }
}

/// A set with such a name is held where a load acts on each of its nodes, and a region where a section names it.
TEST_F(Inp, NamesOfSetsStartWithAnyCharacter) {
  for (const std::string name : {"TOP", "1TOP", "+TOP", "2E5",
                                 "\xC3\x96"
                                 "BEN"}) {
    const std::string set = "*NSET, NSET=" + name + "\n10, 20\n*STEP\n*CLOAD\n" + name + ", 3, 1.\n*END STEP\n";
    EXPECT_EQ(read_mesh(put("a.inp", kTwoTets + set), nullptr, 1).required_vertices.size(), 2U) << name;
    const std::string section =
        "*ELSET, ELSET=" + name + "\n7\n*SOLID SECTION, ELSET=" + name + ", MATERIAL=M\n*DLOAD\n" + name + ", P1, 2.\n";
    const TetMesh m = read_mesh(put("b.inp", kTwoTets + section), nullptr, 1);
    EXPECT_NE(m.tet_tags[0], m.tet_tags[1]) << name;
  }
}

TEST_F(Inp, ARegionOfHexahedraAloneHasNoSetsOfNodes) {
  const std::string cards =
      "*NODE\n1, 0., 0., 0.\n2, -1., 0., 0.\n3, -1., -1., 0.\n4, 0., -1., 0.\n5, 0., 0., -1.\n6, -1., 0., -1.\n"
      "7, -1., -1., -1.\n8, 0., -1., -1.\n*ELEMENT, TYPE=C3D8, ELSET=HEX\n1, 1, 2, 3, 4, 5, 6, 7, 8\n"
      "*NSET, NSET=SIDE\n10, 30, 40\n";
  const TetMesh m = read_mesh(put("a.inp", kTwoTets + cards), nullptr, 1);
  EXPECT_EQ(groups_of(m, 2).count("SIDE"), 1U);
}

TEST_F(Inp, CommentsMayBeBetweenContinuedLines) {
  const std::string text =
      "\xEF\xBB\xBF" + kTwoTets.substr(0, kTwoTets.find("*ELEMENT")) +
      "*ELEMENT,\n** of type\n TYPE=C3D4\n7, 10, 20,\n** c\n30, 40\n*ELEMENT, TYPE=S8\n103, 10, 20, 30, 40,\n**\n"
      "10, 20, 30, 40\n** after\n*NSET, NSET=A,\n** b, GENERATE\n GENERATE\n10, 40, 10\n";
  TetMesh m = read_mesh(put("a.inp", text), nullptr, 1);
  EXPECT_EQ(m.tets.size(), 1U);
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), text);
  // A further node of the region: the set lists its nodes, and the comment stays.
  m.points.push_back({0.2, 0.2, 0.2});
  m.point_tags.push_back(0);
  m.deck_nodes.push_back(0);
  m.tets = {{0, 1, 2, 5}, {0, 3, 1, 5}, {0, 2, 3, 5}, {1, 3, 2, 5}};
  m.tet_tags = std::vector<int>(4, m.tet_tags[0]);
  write_mesh(path("b.inp"), m, 1);
  EXPECT_TRUE(contains(get("b.inp"), "** b, GENERATE\n*NSET, NSET=A\n10, 20, 30, 40, 900000000000000051\n"))
      << get("b.inp");
  EXPECT_TRUE(contains(read_error(put("c.inp", kTwoTets.substr(0, kTwoTets.find("*ELEMENT")))), "no *ELEMENT card"));
  EXPECT_TRUE(contains(read_error(put("c.inp", kTwoTets.substr(kTwoTets.find("*ELEMENT")))), "no *NODE card"));
}

TEST_F(Inp, FacesOfElementsThatDoNotExistAreCounted) {
  std::vector<std::string> warnings;
  const std::string cards = "*SURFACE, NAME=S\n7, S1\n8, S1\nNONE, S2\n";
  const TetMesh m = read_mesh(put("a.inp", kTwoTets + cards), &warnings, 1);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "a.inp:10: 2 lines of this card have elements or sets that do not exist"));
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), kTwoTets + cards);
}

TEST_F(Inp, SetsInPairedSetsAreHeld) {
  const std::string inner = "*NSET, NSET=A\n10, 30, 40\n*NSET, NSET=B\nA,\n*NSET, NSET=C\nB,\n";
  const std::string pairs = "*EQUATION\n2\nC, 1, 1., 20, 1, -1.\n";
  EXPECT_EQ(read_mesh(put("a.inp", kTwoTets + inner), nullptr, 1).triangles.size(), 1U);
  const TetMesh m = read_mesh(put("a.inp", kTwoTets + inner + pairs), nullptr, 1);
  EXPECT_TRUE(m.triangles.empty());
  EXPECT_EQ(m.required_vertices, (std::vector<Index>{0, 1, 2, 3}));
  const std::string of_elements = "*ELSET, ELSET=E\n7\n*NSET, NSET=C, ELSET=E\n";
  EXPECT_TRUE(contains(read_error(put("a.inp", kTwoTets + of_elements + pairs)), "a.inp:12: the order of the set C"));
}

TEST_F(Inp, SetsWithALoadOnEachNodeAreHeld) {
  const std::string face = kTwoTets + "*NSET, NSET=FACE\n10, 20, 30\n";
  EXPECT_TRUE(read_mesh(put("a.inp", face + "*BOUNDARY\nFACE, 1, 3\n"), nullptr, 1).required_vertices.empty());
  for (const char* card : {"*CLOAD\nface, 3, -1.\n", "*CFLUX, OP=NEW\nFACE, 11, 1.\n"}) {
    const TetMesh m = read_mesh(put("a.inp", face + card), nullptr, 1);
    EXPECT_EQ(m.required_vertices, (std::vector<Index>{0, 1, 2})) << card;
    EXPECT_TRUE(m.triangles.empty());
  }
  const std::string all = kTwoTets + "*ELSET, ELSET=E\n7\n*NSET, NSET=ALL, ELSET=E\n*CLOAD\nALL, 3, 1.\n";
  EXPECT_TRUE(contains(read_error(put("b.inp", all)), "b.inp:12: a load acts on each node of the set ALL"));
}

TEST_F(Inp, NamesInQuotationMarksAreThoseOfTheirSets) {
  const std::string nodes = "*NSET, NSET=\"Load nodes\"\n10, 20, 30\n*CLOAD\n\"Load nodes\", 3, -1.\n";
  const TetMesh loaded = read_mesh(put("a.inp", kTwoTets + nodes), nullptr, 1);
  EXPECT_EQ(loaded.required_vertices, (std::vector<Index>{0, 1, 2}));
  EXPECT_TRUE(loaded.triangles.empty());
  // A section needs the set as a region, whatever its surface.
  const std::string cards =
      "*ELSET, ELSET=\"Bolt head\"\n7\n*SOLID SECTION, ELSET=\"Bolt head\", MATERIAL=M\n"
      "*SURFACE, NAME=\"Top face\"\n\"Bolt head\", S1\n*NSET, NSET=\"Top face\"\n10, 20, 30\n";
  const TetMesh m = read_mesh(put("b.inp", kTwoTets + cards), nullptr, 1);
  EXPECT_EQ(m.tet_tags, (std::vector{1, 0}));
  EXPECT_EQ(groups_of(m, 3), (std::map<std::string, std::vector<int>>{{"Bolt head", {1}}}));
  EXPECT_EQ(groups_of(m, 2), (std::map<std::string, std::vector<int>>{{"Top face", {1}}}));
  write_mesh(path("c.inp"), m, 1);
  EXPECT_EQ(get("c.inp"), kTwoTets + cards);
}

TEST_F(Inp, OtherElementsAreHeld) {
  const std::string cards =
      "*ELEMENT, TYPE=S3R\n100, 10, 20, 900000000000000050\n*ELEMENT, TYPE=B31\n101, 10, 900000000000000050\n"
      "*ELEMENT, TYPE=S4\n102, 10, 20, 30, 40\n"
      "*ELEMENT, TYPE=S8R\n103, 10, 20, 30, 40,\n10, 20, 30, 40\n*ELEMENT, TYPE=D\n104, 0, 40, 0\n";
  const TetMesh m = read_mesh(put("a.inp", kTwoTets + cards), nullptr, 1);
  EXPECT_EQ(m.triangles, (std::vector<std::array<Index, 3>>{{0, 1, 4}}));
  EXPECT_EQ(m.required_triangles, std::vector<Index>{0});
  EXPECT_EQ(m.required_edges, std::vector<Index>{0});
  ASSERT_EQ(m.others.size(), 1U);
  EXPECT_EQ(m.others[0].kind, "Quadrilaterals");
  EXPECT_TRUE(groups_of(m, 2).empty());
  EXPECT_EQ(m.required_vertices, (std::vector<Index>{0, 1, 2, 3}));
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), kTwoTets + cards);
}

TEST_F(Inp, SetsOfShellsAreGroupsWhereNoPatchHasTheirTag) {
  const std::string shells = "*ELEMENT, TYPE=S4, ELSET=PLATE\n102, 10, 20, 30, 40\n";
  const TetMesh m = read_mesh(put("a.inp", kTwoTets + shells), nullptr, 1);
  EXPECT_EQ(groups_of(m, 2), (std::map<std::string, std::vector<int>>{{"PLATE", m.others.at(0).tags}}));
  const TetMesh with_patch = read_mesh(put("a.inp", kTwoTets + shells + "*SURFACE, NAME=OUT\n7, S1\n"), nullptr, 1);
  EXPECT_EQ(with_patch.triangle_tags, with_patch.others.at(0).tags);
  EXPECT_EQ(groups_of(with_patch, 2).size(), 1U);
  EXPECT_EQ(groups_of(with_patch, 2).count("OUT"), 1U);
}

}  // namespace
}  // namespace tetune::test

// SPDX-License-Identifier: Apache-2.0
// Decks of Abaqus and CalculiX.
#include <algorithm>
#include <cstdlib>
#include <map>

#include "io/inp/inp_format.hpp"
#include "io_fixture.hpp"
#include "tetune/optimize.hpp"
#include "tetune/validate.hpp"

namespace tetune::test {
namespace {

using Inp = IoTest;

const std::string kNodes =
    "*NODE\n10, 0., 0., 0.\n20, 1., 0., 0.\n30, 0., 1., 0.\n40, 0., 0., 1.\n9000000000000000050, 1., 1., 1.\n";
/// Two tetrahedra with the common face 20, 30, 40.
const std::string kTwo =
    "*NODE\n10, 0., 0., 0.\n20, 1., 0., 0.\n30, 0., 1., 0.\n40, 0., 0., 1.\n900000000000000050, 1., 1., 1.\n"
    "*ELEMENT, TYPE=C3D4\n7, 10, 20, 30, 40\n800000000000000000, 20, 30, 40, 900000000000000050\n";

std::map<std::string, std::vector<int>> groups_of(const TetMesh& m, int dimension) {
  std::map<std::string, std::vector<int>> groups;
  for (const Group& g : m.groups) {
    if (g.dimension == dimension) groups[g.name] = g.tags;
  }
  return groups;
}

std::string written(double value) {
  std::string text;
  append_inp_real(text, value);
  return text;
}

TEST_F(Inp, NumbersOf64BitsMayHaveGaps) {
  const TetMesh m = read_mesh(put("a.inp", kTwo), nullptr, 1);
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
  const TetMesh m = read_mesh(put("a.inp", kTwo + sets), nullptr, 1);
  EXPECT_EQ(m.tet_tags, (std::vector{1, 12}));
  const std::map<std::string, std::vector<int>> expected{{"A", {1}}, {"b c", {1, 12}}};
  EXPECT_EQ(groups_of(m, 3), expected);
}

TEST_F(Inp, SurfacesAndSetsOfNodesAreTriangles) {
  const std::string cards =
      "*SURFACE, NAME=OUT\n7, S1\n7, S2\n*SURFACE, NAME=IN, TYPE=ELEMENT\n7, S3\n*NSET, NSET=N\n10, 20, 30\n"
      "*NSET, NSET=SIDE\n10, 30, 40\n*NSET, NSET=POINT\n900000000000000050\n*NSET, NSET=ALL, GENERATE\n"
      "10, 900000000000000050, 10\n*NSET, NSET=OF, ELSET=NONE\n";
  const TetMesh m = read_mesh(put("a.inp", kTwo + cards), nullptr, 1);
  // The faces of OUT and IN, with their normals outwards of element 7, and that of SIDE.
  EXPECT_EQ(m.triangles, (std::vector<std::array<Index, 3>>{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}));
  const std::map<std::string, std::vector<int>> expected{{"OUT", {1, 3}}, {"IN", {2}}, {"N", {3}}, {"SIDE", {4}}};
  EXPECT_EQ(groups_of(m, 2).size(), expected.size());
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
  const TetMesh m = read_mesh(put("a.inp", kTwo + cards), nullptr, 1);
  EXPECT_EQ(m.triangles.size(), 1U);
}

TEST_F(Inp, LinesOfGenerateAreNumbers) {
  for (const char* line : {"first, 10, 1", "10, , 10", "10, 20, 0", "10", "10, 20, 10, 5"}) {
    EXPECT_THROW(read_mesh(put("a.inp", kTwo + "*NSET, NSET=A, GENERATE\n" + line + "\n"), nullptr, 1), FileError)
        << line;
  }
}

TEST_F(Inp, WhatOtherCardsNameByNumberIsHeld) {
  const std::string cards =
      "*BOUNDARY\n10, 1, 3\n*EQUATION\n2\n20, 1, 1., 30, 1, -1.\n*INITIAL CONDITIONS, TYPE=STRESS\n7, 1., 1., 1.\n"
      "*RIGID BODY, REF NODE=40\n*AMPLITUDE, NAME=X\n900000000000000050, 1.\n";
  const TetMesh m = read_mesh(put("a.inp", kTwo + cards), nullptr, 1);
  EXPECT_EQ(m.required_vertices, (std::vector<Index>{0, 1, 2, 3}));
  EXPECT_EQ(m.required_tets, std::vector<Index>{0});
}

TEST_F(Inp, CardsThatAreNotKnownHoldTheFirstFields) {
  const std::string cards =
      "*KINEMATIC COUPLING, REF NODE=40\n10, 1, 3\n*CFILM\n20, 1., 300., 10.\n*MODEL CHANGE, REMOVE\nX, 7\n"
      "*NEW CARD\n800000000000000000, 30\n*ELASTIC\n30, 0.3\n*HEADING\n30\n*ELSET, ELSET=X\n7\n";
  const TetMesh m = read_mesh(put("a.inp", kTwo + cards), nullptr, 1);
  EXPECT_EQ(m.required_vertices, (std::vector<Index>{0, 1, 3}));
  EXPECT_EQ(m.required_tets, (std::vector<Index>{0, 1}));
}

TEST_F(Inp, FlowsAndChargesOnFacesAreTriangles) {
  for (const char* card : {"*FLOW\n7, Q1, 0., 1.\n", "*DFLOW\n7, s1, 1.\n", "*DECHARGE\n7, ES1, 1.\n",
                           "*DECURRENT\n7, CS1, 1.\n", "*DLOAD\n7, TRVEC1NU, 1.\n"}) {
    const TetMesh m = read_mesh(put("a.inp", kTwo + card), nullptr, 1);
    EXPECT_EQ(m.triangles.size(), 1U) << card;
    EXPECT_TRUE(m.required_tets.empty()) << card;
  }
  for (const char* card : {"*DLOAD\n7, GRAV, 1., 0., 0., 1.\n", "*DLOAD\n7, P5, 1.\n", "*SURFACE, NAME=S\n7,\n"}) {
    const TetMesh m = read_mesh(put("a.inp", kTwo + card), nullptr, 1);
    EXPECT_EQ(m.triangles.size(), 0U) << card;
    EXPECT_EQ(m.required_tets, std::vector<Index>{0}) << card;
  }
}

TEST_F(Inp, LinesAreCountedOverContinuedOnes) {
  const std::string cards =
      "*NSET,\n NSET=A\n10\n*SOLID SECTION, ELSET=E,\n1.\n*ELEMENT, TYPE=C3D4\n9, 10, 20,\n30, 40\n";
  EXPECT_TRUE(contains(read_error(put("a.inp", kTwo + cards + "*NSET\n")), "a.inp:18: *NSET has no name"));
  EXPECT_TRUE(contains(read_error(put("a.inp", kTwo + cards + "10, x\n")), "a.inp:18: "));
}

TEST_F(Inp, AnAuxiliarySetMayHaveTwoCards) {
  const std::string cards = "*ELSET, ELSET=F\n7\n*ELSET, ELSET=F\n800000000000000000\n*SURFACE, NAME=S\nF, S2\n";
  const TetMesh m = read_mesh(put("a.inp", kTwo + cards), nullptr, 1);
  EXPECT_EQ(m.triangles.size(), 2U);
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), get("a.inp"));
}

TEST_F(Inp, ARegionOfHexahedraAloneHasNoSetsOfNodes) {
  const std::string cards =
      "*NODE\n1, 0., 0., 0.\n2, -1., 0., 0.\n3, -1., -1., 0.\n4, 0., -1., 0.\n5, 0., 0., -1.\n6, -1., 0., -1.\n"
      "7, -1., -1., -1.\n8, 0., -1., -1.\n*ELEMENT, TYPE=C3D8, ELSET=HEX\n1, 1, 2, 3, 4, 5, 6, 7, 8\n"
      "*NSET, NSET=SIDE\n10, 30, 40\n";
  const TetMesh m = read_mesh(put("a.inp", kTwo + cards), nullptr, 1);
  EXPECT_EQ(groups_of(m, 2).count("SIDE"), 1U);
}

TEST_F(Inp, CommentsMayBeBetweenContinuedLines) {
  const std::string text =
      "\xEF\xBB\xBF" + kTwo.substr(0, kTwo.find("*ELEMENT")) +
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
  EXPECT_TRUE(contains(read_error(put("c.inp", kTwo.substr(0, kTwo.find("*ELEMENT")))), "no *ELEMENT card"));
  EXPECT_TRUE(contains(read_error(put("c.inp", kTwo.substr(kTwo.find("*ELEMENT")))), "no *NODE card"));
}

TEST_F(Inp, FacesOfElementsThatDoNotExistAreCounted) {
  std::vector<std::string> warnings;
  const std::string cards = "*SURFACE, NAME=S\n7, S1\n8, S1\nNONE, S2\n";
  const TetMesh m = read_mesh(put("a.inp", kTwo + cards), &warnings, 1);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "a.inp:10: 2 lines of this card have elements or sets that do not exist"));
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), kTwo + cards);
}

TEST_F(Inp, SetsInPairedSetsAreHeld) {
  const std::string inner = "*NSET, NSET=A\n10, 30, 40\n*NSET, NSET=B\nA,\n*NSET, NSET=C\nB,\n";
  const std::string pairs = "*EQUATION\n2\nC, 1, 1., 20, 1, -1.\n";
  EXPECT_EQ(read_mesh(put("a.inp", kTwo + inner), nullptr, 1).triangles.size(), 1U);
  const TetMesh m = read_mesh(put("a.inp", kTwo + inner + pairs), nullptr, 1);
  EXPECT_TRUE(m.triangles.empty());
  EXPECT_EQ(m.required_vertices, (std::vector<Index>{0, 1, 2, 3}));
  const std::string of_elements = "*ELSET, ELSET=E\n7\n*NSET, NSET=C, ELSET=E\n";
  EXPECT_TRUE(contains(read_error(put("a.inp", kTwo + of_elements + pairs)), "a.inp:12: the order of the set C"));
}

TEST_F(Inp, OtherElementsAreHeld) {
  const std::string cards =
      "*ELEMENT, TYPE=S3R\n100, 10, 20, 30\n*ELEMENT, TYPE=B31\n101, 10, 20\n*ELEMENT, TYPE=S4\n102, 10, 20, 30, 40\n"
      "*ELEMENT, TYPE=S8R\n103, 10, 20, 30, 40,\n10, 20, 30, 40\n*ELEMENT, TYPE=D\n104, 0, 40, 0\n";
  const TetMesh m = read_mesh(put("a.inp", kTwo + cards), nullptr, 1);
  EXPECT_EQ(m.triangles, (std::vector<std::array<Index, 3>>{{0, 1, 2}}));
  EXPECT_EQ(m.required_triangles, std::vector<Index>{0});
  EXPECT_EQ(m.required_edges, std::vector<Index>{0});
  ASSERT_EQ(m.others.size(), 1U);
  EXPECT_EQ(m.others[0].kind, "Quadrilaterals");
  EXPECT_TRUE(groups_of(m, 2).empty());
  EXPECT_EQ(m.required_vertices, (std::vector<Index>{0, 1, 2, 3}));
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), kTwo + cards);
}

TEST_F(Inp, SetsOfShellsAreGroupsWhereNoPatchHasTheirTag) {
  const std::string shells = "*ELEMENT, TYPE=S4, ELSET=PLATE\n102, 10, 20, 30, 40\n";
  const TetMesh m = read_mesh(put("a.inp", kTwo + shells), nullptr, 1);
  EXPECT_EQ(groups_of(m, 2), (std::map<std::string, std::vector<int>>{{"PLATE", m.others.at(0).tags}}));
  const TetMesh with_patch = read_mesh(put("a.inp", kTwo + shells + "*SURFACE, NAME=OUT\n7, S1\n"), nullptr, 1);
  EXPECT_EQ(with_patch.triangle_tags, with_patch.others.at(0).tags);
  EXPECT_EQ(groups_of(with_patch, 2).size(), 1U);
  EXPECT_EQ(groups_of(with_patch, 2).count("OUT"), 1U);
}

TEST_F(Inp, PartsAndAssembliesAreRefused) {
  for (const char* card : {"*Part, name=P", "*Assembly, name=A", "*Instance, name=P-1, part=P"}) {
    const std::string said = read_error(put("a.inp", std::string("*HEADING\n") + card + "\n" + kTwo));
    EXPECT_TRUE(contains(said, "a.inp:2: *")) << said;
    EXPECT_TRUE(contains(said, "decks of parts and assemblies are not supported; write a flat deck")) << said;
  }
}

TEST_F(Inp, NumbersOfChangedEntitiesStayInTheirSets) {
  TetMesh m = read_mesh(put("a.inp", kTwo + "*ELSET, ELSET=A\n7\n*ELSET, ELSET=B\n800000000000000000\n*NSET, NSET=N\n"
                                            "20, 30, 40\n*SURFACE, NAME=S\n800000000000000000, S1\n*SURFACE, NAME=T\n"
                                            "7, S1\n"),
                        nullptr, 1);
  // The upper tetrahedron as three around a new vertex.
  m.points.push_back({0.5, 0.5, 0.5});
  m.point_tags.push_back(0);
  m.deck_nodes.push_back(0);
  m.tets = {{1, 2, 3, 0}, {1, 2, 4, 5}, {2, 3, 4, 5}, {1, 3, 4, 5}, {1, 2, 3, 5}};
  std::swap(m.tets[0][2], m.tets[0][3]);
  std::swap(m.tets[1][2], m.tets[1][3]);
  std::swap(m.tets[2][2], m.tets[2][3]);
  m.tet_tags = {m.tet_tags[0], m.tet_tags[1], m.tet_tags[1], m.tet_tags[1], m.tet_tags[1]};
  write_mesh(path("b.inp"), m, 1);
  EXPECT_TRUE(contains(get("b.inp"), "\n7, 10, 20, 30, 40\n"));
  EXPECT_TRUE(contains(get("b.inp"), "900000000000000050, 1., 1., 1.\n900000000000000051, 0.5, 0.5, 0.5\n"));
  EXPECT_TRUE(contains(get("b.inp"),
                       "*ELSET, ELSET=A\n7\n*ELSET, ELSET=B\n800000000000000000, 800000000000000001, "
                       "800000000000000002, 800000000000000003\n*NSET, NSET=N\n20, 30, 40\n"));
  EXPECT_TRUE(contains(get("b.inp"), "*SURFACE, NAME=S\n800000000000000003, S"));
  EXPECT_TRUE(contains(get("b.inp"), "*SURFACE, NAME=T\n7, S1\n"));
  const TetMesh back = read_mesh(path("b.inp"), nullptr, 1);
  EXPECT_EQ(back.tets.size(), 5U);
  EXPECT_EQ(groups_of(back, 3), groups_of(m, 3));
  EXPECT_EQ(back.triangles.size(), m.triangles.size());
}

TEST_F(Inp, WhatCannotFollowIsRefused) {
  const TetMesh m = read_mesh(put("a.inp", kTwo + "*SURFACE, NAME=S\n7, S1\n"), nullptr, 1);
  const auto refused = [this](const TetMesh& changed, const char* said) {
    try {
      write_mesh(path("b.inp"), changed, 1);
    } catch (const FileError& e) {
      EXPECT_TRUE(contains(e.what(), said));
      return;
    }
    ADD_FAILURE() << said;
  };
  TetMesh changed = m;
  changed.triangles.clear();
  changed.triangle_tags.clear();
  refused(changed, "tag 1, of which the surface S of the deck consists");
  changed = m;
  changed.triangles[0] = {0, 1, 4};
  refused(changed, "no faces of tetrahedra");
  changed = m;
  std::swap(changed.triangles[0][0], changed.triangles[0][1]);
  write_mesh(path("b.inp"), changed, 1);  // the face of the boundary has one side
  EXPECT_EQ(get("b.inp"), get("a.inp"));
  changed = m;
  changed.tet_tags[0] = 5;
  refused(changed, "the tag 5");
  changed = m;
  changed.triangle_tags[0] = 5;
  refused(changed, "the tag 5");
  changed = m;
  changed.points.push_back({2, 2, 2});
  changed.point_tags.push_back(0);
  refused(changed, "the mesh has 6 vertices, but the deck 5 node numbers; write another format");
  changed.deck = nullptr;
  write_mesh(path("b.inp"), changed, 1);
  EXPECT_TRUE(contains(get("b.inp"), "*SURFACE, TYPE=ELEMENT, NAME=Surface1\n1, S1\n"));
}

TEST_F(Inp, CoordinatesHaveAtMost20Characters) {
  for (const double x : {0.1, -0.1, 1e-300, 5e-324, -1.7976931348623157e308, 1.0 / 3, -1.0 / 3, 123456.78901234567,
                         -1.2345678901234567e-5, 1e22, -0.0, 100.0}) {
    const std::string text = written(x);
    EXPECT_LE(text.size(), 20U) << text;
    EXPECT_NEAR(std::strtod(text.c_str(), nullptr) / (x == 0 ? 1 : x), x == 0 ? 0 : 1, 1e-12) << text;
  }
  EXPECT_EQ(written(0.1), "0.1");
  EXPECT_EQ(written(-1.0 / 3), "-0.3333333333333333");
  EXPECT_EQ(written(0.0012345678901234567), ".0012345678901234567");
  EXPECT_EQ(written(-1.2345678901234567e-5), "-1.23456789012346e-5");
}

TEST_F(Inp, RoundedCoordinatesOfOtherFormatsAreCounted) {
  TetMesh m = cube(2);
  std::vector<std::string> warnings;
  write_mesh(path("a.inp"), m, 1, &warnings);
  EXPECT_TRUE(warnings.empty());
  m.points[0] = {-1.2345678901234567e-5, -1.2345678901234567e-5, 0};
  write_mesh(path("a.inp"), m, 1, &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "2 coordinates are rounded"));
}

TEST_F(Inp, GroupsOfOtherSolidsAndQuadrilateralsKeepTheirNames) {
  TetMesh m;
  m.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}, {0.5, -1, 0.5}};
  m.point_tags.assign(6, 0);
  m.tets = {{0, 5, 1, 4}};
  m.tet_tags = {1};
  m.triangles = {{0, 5, 1}};
  m.triangle_tags = {3};
  m.others = {{"Pyramids", 5, {0, 1, 2, 3, 4}, {2}, {}}, {"Quadrilaterals", 4, {0, 1, 2, 3}, {4}, {}}};
  m.groups = {{3, 1, "body", {1, 2}}, {3, 2, "base", {2}}, {2, 1, "floor", {3, 4}}, {2, 2, "square", {4}}};
  std::vector<std::string> warnings;
  write_mesh(path("a.inp"), m, 1, &warnings);
  EXPECT_TRUE(warnings.empty());
  EXPECT_TRUE(contains(get("a.inp"), "*ELSET, ELSET=body\nVolume1,\nVolume2,\n*ELSET, ELSET=base\nVolume2,\n"));
  EXPECT_TRUE(contains(get("a.inp"), "*ELSET, ELSET=floor\nSurface4,\n*ELSET, ELSET=square\nSurface4,\n"));
  EXPECT_TRUE(contains(get("a.inp"), "*SURFACE, TYPE=ELEMENT, NAME=floor\n1, S"));
  const TetMesh back = read_mesh(path("a.inp"), nullptr, 1);
  EXPECT_EQ(groups_of(back, 3), groups_of(m, 3));
  EXPECT_EQ(groups_of(back, 2), groups_of(m, 2));
  ASSERT_EQ(back.others.size(), 2U);
}

TEST_F(Inp, OptimizationKeepsTheDeck) {
  TetMesh source = two_materials(4, 0.2);
  source.groups = {{3, 1, "steel bar", {1}}};
  std::vector<std::string> warnings;
  write_mesh(path("a.inp"), source, 1, &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "\"steel bar\" is written as steel_bar"));
  std::string text = get("a.inp") + "*SOLID SECTION, ELSET=steel_bar, MATERIAL=M\n** the end";
  TetMesh m = read_mesh(put("a.inp", text), nullptr, 1);
  EXPECT_EQ(std::count(m.tet_tags.begin(), m.tet_tags.end(), 1), 192);
  Options options;
  options.effort = Effort::best;
  options.device = Device::cpu;
  const Report report = optimize(m, options);
  EXPECT_EQ(m.deck_nodes.size(), m.points.size());
  EXPECT_GT(report.vertices_inserted + report.vertices_removed, 0);
  write_mesh(path("b.inp"), m, 1);
  EXPECT_TRUE(get("b.inp").ends_with("*SOLID SECTION, ELSET=steel_bar, MATERIAL=M\n** the end"));
  const TetMesh back = read_mesh(path("b.inp"), nullptr, 1);
  EXPECT_TRUE(validate(back, 1).ok());
  EXPECT_EQ(back.points.size(), m.points.size());
  EXPECT_EQ(back.tets.size(), m.tets.size());
  EXPECT_EQ(std::count(back.tet_tags.begin(), back.tet_tags.end(), 1),
            std::count(m.tet_tags.begin(), m.tet_tags.end(), 1));
}

TEST_F(Inp, TheLastLineNeedsNoEnd) {
  const std::string tets = kTwo.substr(kTwo.find("*ELEMENT"));
  for (const std::string& text : {kTwo.substr(0, kTwo.size() - 1), tets + kTwo.substr(0, kTwo.find("*ELEMENT") - 1),
                                  kTwo + "*NSET, NSET=A\n10", kTwo + "*SURFACE, NAME=S\n7, S1"}) {
    TetMesh m = read_mesh(put("a.inp", text), nullptr, 1);
    write_mesh(path("b.inp"), m, 1);
    EXPECT_EQ(get("b.inp"), text);
    m.points.push_back({5, 5, 5});  // in no element
    m.point_tags.push_back(0);
    m.deck_nodes.push_back(0);
    write_mesh(path("b.inp"), m, 1);
    EXPECT_EQ(read_mesh(path("b.inp"), nullptr, 1).points.size(), 6U);
  }
}

TEST_F(Inp, ASurfaceAtAnInvertedTetrahedronKeepsItsSide) {
  // The middle tetrahedron of three is inverted: the node 50 is below the face 20, 30, 40.
  const std::string text =
      "*NODE\n10, 0., 0., 0.\n20, 1., 0., 0.\n30, 0., 1., 0.\n40, 0., 0., 1.\n50, .2, .2, .2\n60, 2., 2., 2.\n"
      "*ELEMENT, TYPE=C3D4\n1, 10, 20, 30, 40\n2, 20, 30, 40, 50\n3, 30, 40, 50, 60\n4, 20, 50, 40, 60\n";
  for (const char* surface : {"1, S3", "2, S1"}) {
    TetMesh m = read_mesh(put("a.inp", text + "*SURFACE, NAME=S\n" + surface + "\n"), nullptr, 1);
    EXPECT_EQ(m.tets[1], (std::array<Index, 4>{1, 2, 3, 4}));
    write_mesh(path("b.inp"), m, 1);
    EXPECT_EQ(get("b.inp"), get("a.inp"));
    m.points[4] = {1, 1, 1};  // as it is untangled
    write_mesh(path("c.inp"), m, 1);
    EXPECT_TRUE(get("c.inp").ends_with(std::string("*SURFACE, NAME=S\n") + surface + "\n")) << get("c.inp");
  }
}

TEST_F(Inp, TetrahedraInsideOutAreWrittenAsTheyWere) {
  std::string text = kTwo;
  text.replace(text.find("10, 20, 30, 40"), 14, "10, 20, 40, 30");
  text.replace(text.find("20, 30, 40, 9"), 13, "20, 40, 30, 9");
  TetMesh m = read_mesh(put("a.inp", text + "*SURFACE, NAME=S\n7, S1\n7, S4\n"), nullptr, 1);
  EXPECT_TRUE(m.listed_inside_out);
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), get("a.inp"));
}

TEST_F(Inp, TrianglesWithoutATagAreNamed) {
  TetMesh m = cube(1);
  m.tet_tags.assign(m.tets.size(), 1);
  m.triangles = {{0, 1, 4}, {0, 4, 3}};
  m.triangle_tags = {0, 0};
  std::vector<std::string> warnings;
  write_mesh(path("a.inp"), m, 1, &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "2 triangles without a tag are not written"));
}

}  // namespace
}  // namespace tetune::test

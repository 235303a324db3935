// SPDX-License-Identifier: Apache-2.0
// Decks of Abaqus and CalculiX that are written: of a changed mesh, and of a mesh of another format.
#include <algorithm>
#include <cstdlib>

#include "inp_fixture.hpp"
#include "io/inp/inp_format.hpp"
#include "tetune/optimize.hpp"
#include "tetune/validate.hpp"

namespace tetune::test {
namespace {

std::string written(double value) {
  std::string text;
  append_inp_real(text, value);
  return text;
}

TEST_F(Inp, NumbersOfChangedEntitiesStayInTheirSets) {
  TetMesh m =
      read_mesh(put("a.inp", kTwoTets + "*ELSET, ELSET=A\n7\n*ELSET, ELSET=B\n800000000000000000\n*NSET, NSET=N\n"
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
  const TetMesh m = read_mesh(put("a.inp", kTwoTets + "*SURFACE, NAME=S\n7, S1\n"), nullptr, 1);
  const auto refused = [this](const TetMesh& changed, const char* said) {
    EXPECT_TRUE(contains(write_error(path("b.inp"), changed), said));
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
  const std::string tets = kTwoTets.substr(kTwoTets.find("*ELEMENT"));
  for (const std::string& text :
       {kTwoTets.substr(0, kTwoTets.size() - 1), tets + kTwoTets.substr(0, kTwoTets.find("*ELEMENT") - 1),
        kTwoTets + "*NSET, NSET=A\n10", kTwoTets + "*SURFACE, NAME=S\n7, S1"}) {
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
  std::string text = kTwoTets;
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

// SPDX-License-Identifier: Apache-2.0
// Elements of decks that are triangles and edges of tetrahedra: shells, membranes, beams and the elements that Gmsh
// writes on surfaces and curves.
#include <algorithm>
#include <map>

#include "inp_fixture.hpp"
#include "mesh/tet_orientation.hpp"
#include "tetune/optimize.hpp"

namespace tetune::test {
namespace {

using InpSides = IoTest;

TEST_F(InpSides, ThoseOnFacesArePatchesByTheirSetsAndCards) {
  const std::string cards =
      "*ELEMENT, TYPE=CPS3, ELSET=OUT\n100, 10, 20, 30\n101, 10, 40, 20\n** a shell\n102, 20, 30, 40\n"
      "*ELEMENT, TYPE=S3\n103, 10, 30, 40\n104, 10, 20, 900000000000000050\n105, 30, 20, 10\n"
      "*ELSET, ELSET=HALF\n101, 103\n*SURFACE, NAME=S\n7, S1\n";
  const TetMesh m = read_mesh(put("a.inp", kTwoTets + cards), nullptr, 1);
  // 104 is no face, and 105 has the vertices of 100.
  EXPECT_EQ(m.triangles,
            (std::vector<std::array<Index, 3>>{{0, 1, 4}, {2, 1, 0}, {0, 1, 2}, {0, 3, 1}, {1, 2, 3}, {0, 2, 3}}));
  EXPECT_EQ(m.required_triangles, (std::vector<Index>{0, 1}));
  std::vector<int> tags = m.triangle_tags;
  EXPECT_EQ(tags[0], 0);
  EXPECT_EQ(tags[1], 0);
  std::sort(tags.begin() + 2, tags.end());
  EXPECT_EQ(tags, (std::vector<int>{0, 0, 1, 2, 3, 4}));
  const auto groups = groups_of(m, 2);
  EXPECT_EQ(groups.at("OUT").size(), 3U);
  EXPECT_EQ(groups.at("HALF"), (std::vector<int>{m.triangle_tags[3], m.triangle_tags[5]}));
  EXPECT_EQ(groups.at("S"), std::vector<int>{m.triangle_tags[2]});
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), get("a.inp"));
}

TEST_F(InpSides, NormalsKeepTheirSides) {
  const auto tags = [this](const char* second) {
    return read_mesh(put("a.inp", kTwoTets + "*ELEMENT, TYPE=S3, ELSET=OUT\n100, 10, 30, 20\n101, " + second + "\n"),
                     nullptr, 1)
        .triangle_tags;
  };
  EXPECT_EQ(tags("10, 20, 40"), (std::vector<int>{1, 1}));
  EXPECT_EQ(tags("10, 40, 20"), (std::vector<int>{1, 2}));
}

TEST_F(InpSides, ThoseThatCardsNameByNumberAreHeld) {
  const std::string elements = "*ELEMENT, TYPE=S3, ELSET=OUT\n100, 10, 20, 30\n101, 10, 40, 20\n";
  for (const char* card : {"*SURFACE, NAME=S\n101, SPOS\n", "*DLOAD\n101, P, 2.\n", "*DLOAD\n101, P3, 2.\n",
                           "*ELSET, ELSET=E\n101\n*DLOAD\nE, P3, 2.\n", "*NEW CARD\n101, 1.\n"}) {
    const TetMesh m = read_mesh(put("a.inp", kTwoTets + elements + card), nullptr, 1);
    ASSERT_EQ(m.required_triangles, std::vector<Index>{0}) << card;
    EXPECT_EQ(m.triangles, (std::vector<std::array<Index, 3>>{{0, 3, 1}, {0, 1, 2}})) << card;
    EXPECT_EQ(m.triangle_tags, (std::vector<int>{0, 1})) << card;
  }
}

TEST_F(InpSides, QuadraticOnesHaveTheMiddlesOfTheirTetrahedra) {
  const std::string cards =
      "*ELEMENT, TYPE=CPS6, ELSET=OUT\n100, 1, 2, 3, 21, 12, 22\n*ELEMENT, TYPE=STRI65\n101, 1, 2, 4, 21, 14, 22\n";
  TetMesh m = read_mesh(put("a.inp", kTwoQuadratic + cards), nullptr, 1);
  EXPECT_EQ(m.triangles, (std::vector<std::array<Index, 3>>{{0, 1, 2}}));
  EXPECT_EQ(groups_of(m, 2), (std::map<std::string, std::vector<int>>{{"OUT", m.triangle_tags}}));
  // The nodes of 101, which has another one on the edge of 1 and 4, keep their place.
  EXPECT_EQ(m.required_vertices, (std::vector<Index>{0, 1, 2, 3}));
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), get("a.inp"));
  m.triangles[0] = {0, 2, 1};
  write_mesh(path("b.inp"), m, 1);
  EXPECT_TRUE(contains(get("b.inp"), "ELSET=OUT\n100, 1, 3, 2, 22, 12, 21\n*ELEMENT"));
  const std::string error =
      read_error(put("a.inp", kTwoQuadratic + "*ELEMENT, TYPE=S6\n100, 1, 2, 3, 21, 12\n*STEP\n"));
  EXPECT_TRUE(contains(error, "element 100 has 5 nodes instead of 6")) << error;
}

TEST_F(InpSides, EdgesOfTetrahedraAreRidges) {
  const std::string cards =
      "*ELEMENT, TYPE=T3D2, ELSET=RIM\n100, 10, 20\n101, 20, 30\n*ELEMENT, TYPE=B31\n102, 40, 30\n"
      "103, 10, 900000000000000050\n104, 10, 30\n*ELSET, ELSET=FIRST\n100\n*DLOAD\n104, P1, 2.\n";
  const TetMesh m = read_mesh(put("a.inp", kTwoTets + cards), nullptr, 1);
  EXPECT_EQ(m.edges, (std::vector<std::array<Index, 2>>{{0, 1}, {1, 2}, {3, 2}, {0, 4}, {0, 2}}));
  EXPECT_EQ(m.ridges, (std::vector<Index>{0, 1, 2}));
  EXPECT_EQ(m.required_edges, (std::vector<Index>{3, 4}));
  const auto groups = groups_of(m, 1);
  EXPECT_EQ(groups.at("RIM"), (std::vector<int>{1, 2}));
  EXPECT_EQ(groups.at("FIRST"), std::vector<int>{m.edge_tags[0]});
  EXPECT_EQ(m.edge_tags[2], 0);
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), get("a.inp"));
}

TEST_F(InpSides, QuadraticEdgesHaveTheMiddlesOfTheirTetrahedra) {
  // In the order of Abaqus and in that of Gmsh; with a node of another edge, and without one.
  const std::string cards =
      "*ELEMENT, TYPE=B32\n100, 1, 21, 2\n101, 1, 13, 3\n102, 1, 4\n*ELEMENT, TYPE=T3D3\n103, 2, 3, 12\n";
  const TetMesh m = read_mesh(put("a.inp", kTwoQuadratic + cards), nullptr, 1);
  ASSERT_GE(m.edges.size(), 2U);
  EXPECT_EQ(m.ridges, (std::vector<Index>{0, 1}));
  EXPECT_EQ(m.edges[0], (std::array<Index, 2>{0, 1}));
  EXPECT_EQ(m.edges[1], (std::array<Index, 2>{1, 2}));
  // The nodes of the two others are held, the mid-side node with its edge.
  EXPECT_EQ(m.required_vertices, (std::vector<Index>{0, 2, 3}));
  ASSERT_EQ(m.required_edges, std::vector<Index>{2});
  EXPECT_EQ(m.edges[2], (std::array<Index, 2>{2, 3}));
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), get("a.inp"));
}

/// The total area of the triangles of each tag.
std::map<int, double> areas(const TetMesh& m) {
  std::map<int, double> sums;
  for (std::size_t i = 0; i < m.triangles.size(); ++i) {
    const auto& [a, b, c] = m.triangles[i];
    const Vec3 x = vec(span_of(m.points)[a]);
    sums[m.triangle_tags[i]] += norm(cross(vec(span_of(m.points)[b]) - x, vec(span_of(m.points)[c]) - x)) / 2;
  }
  return sums;
}

TEST_F(InpSides, TheyFollowTheFacesOfTheMesh) {
  const TetMesh source = two_materials(4, 0.2);
  write_mesh(path("a.inp"), source, 1);
  std::string elements = "*ELEMENT, TYPE=CPS3, ELSET=SKIN\n";
  std::string top = "*ELSET, ELSET=TOP\n";
  int label = 5000;
  for (const auto& [a, b, c] : find_surface_faces(source)) {
    elements += std::to_string(++label) + ", " + std::to_string(a + 1) + ", " + std::to_string(b + 1) + ", " +
                std::to_string(c + 1) + "\n";
    const auto z = [&](Index v) { return span_of(source.points)[v][2]; };
    if (z(a) == 1 && z(b) == 1 && z(c) == 1) top += std::to_string(label) + "\n";
  }
  TetMesh m = read_mesh(put("a.inp", get("a.inp") + elements + top), nullptr, 1);
  EXPECT_TRUE(m.required_triangles.empty());
  ASSERT_EQ(groups_of(m, 2).count("TOP"), 1U);
  const auto before = areas(m);
  const auto triangles = m.triangles;
  Options options;
  options.effort = Effort::best;
  options.device = Device::cpu;
  optimize(m, options);
  EXPECT_NE(m.triangles, triangles);
  write_mesh(path("b.inp"), m, 1);
  const TetMesh back = read_mesh(path("b.inp"), nullptr, 1);
  EXPECT_TRUE(back.required_triangles.empty());
  EXPECT_EQ(back.triangles.size(), m.triangles.size());
  EXPECT_EQ(groups_of(back, 2), groups_of(m, 2));
  const auto after = areas(back);
  ASSERT_EQ(after.size(), before.size());
  for (const auto& [tag, area] : before) EXPECT_NEAR(after.at(tag), area, 1e-9) << tag;
}

}  // namespace
}  // namespace tetune::test

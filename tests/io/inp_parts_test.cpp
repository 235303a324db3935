// SPDX-License-Identifier: Apache-2.0
// Decks of parts and an assembly, as Abaqus/CAE writes them.
#include <algorithm>

#include "inp_fixture.hpp"
#include "tetune/optimize.hpp"
#include "tetune/validate.hpp"

namespace tetune::test {
namespace {

const std::string kPart = "*Part, name=Part-1\n" + kTwoTets +
                          "*Nset, nset=Set-1\n 20, 30, 40\n*Elset, elset=Set-1\n 7\n"
                          "*Solid Section, elset=Set-1, material=Steel\n,\n*End Part\n";
const std::string kInstance =
    "*Instance, name=Part-1-1, part=Part-1\n 0., 0., 5.\n 0., 0., 5., 1., 0., 5., 90.\n*End Instance\n";

/// A deck with a part of two tetrahedra; `assembly` and `steps` follow its instance.
std::string deck(const std::string& assembly, const std::string& steps = "", const std::string& parts = kPart) {
  return "*Heading\n** a deck\n" + parts + "*Assembly, name=Assembly\n" + kInstance + assembly +
         "*End Assembly\n*Material, name=Steel\n*Elastic\n 210000., 0.3\n*Step, name=Step-1\n*Static\n" + steps +
         "*End Step\n";
}

TEST_F(Inp, APartWithItsInstanceIsAMesh) {
  const std::string text = deck(
      "*Nset, nset=Fixed, instance=Part-1-1\n 10, 20, 30\n*Elset, elset=_Top_S2, internal, instance=Part-1-1\n 7,\n"
      "*Surface, type=ELEMENT, name=Top\n_Top_S2, S2\n",
      "*Boundary\nFixed, ENCASTRE\n*Boundary\nPart-1-1.900000000000000050, 1, 3\n");
  const TetMesh m = read_mesh(put("a.inp", text), nullptr, 1);
  EXPECT_EQ(m.tets, (std::vector<std::array<Index, 4>>{{0, 1, 2, 3}, {1, 2, 3, 4}}));
  EXPECT_EQ(groups_of(m, 3).count("Part-1-1.Set-1"), 1U);
  EXPECT_EQ(groups_of(m, 2).count("Fixed"), 1U);
  EXPECT_EQ(groups_of(m, 2).count("Top"), 1U);
  EXPECT_EQ(m.required_vertices, std::vector<Index>{4});
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), text);
}

TEST_F(Inp, NumbersOfTheAssemblyAreNotThoseOfThePart) {
  const std::string reference_point =
      "*Node\n 10, 9., 9., 9.\n*Nset, nset=RP\n 10,\n*Nset, nset=Both\n RP, Part-1-1.Set-1\n"
      "*Element, type=MASS, elset=M\n7, 10\n*Mass, elset=M\n1.,\n";
  const std::string text =
      deck(reference_point, "*Cload\n10, 3, 1.\n*Boundary\nRP, 1, 2\n10, 3, 3\n*Dload\n7, P1, 2.\n");
  std::vector<std::string> warnings;
  const TetMesh m = read_mesh(put("a.inp", text), &warnings, 1);
  EXPECT_TRUE(warnings.empty());
  EXPECT_EQ(m.points.size(), 5U);
  EXPECT_TRUE(m.required_vertices.empty());
  EXPECT_TRUE(m.required_tets.empty());
  EXPECT_EQ(m.triangles.size(), 1U);  // of Set-1 of the part
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), text);
}

TEST_F(Inp, SetsOfThePartAndOfTheAssemblyMayHaveOneName) {
  const std::string text =
      deck("*Nset, nset=Set-1, instance=Part-1-1\n 10, 20, 40\n*Nset, nset=All, instance=Part-1-1\n Set-1, 10\n",
           "*Cload\nPart-1-1.Set-1, 1, 1.\n");
  const TetMesh m = read_mesh(put("a.inp", text), nullptr, 1);
  // The load acts on the nodes of the part's set, which keep their positions; the other sets are a patch.
  EXPECT_EQ(m.required_vertices, (std::vector<Index>{1, 2, 3}));
  EXPECT_EQ(m.triangles, (std::vector<std::array<Index, 3>>{{0, 1, 3}}));
}

TEST_F(Inp, OtherPartsAreText) {
  const std::string shell =
      "*Part, name=Tool\n*Node\n10, 0., 0., 9.\n20, 1., 0., 9.\n30, 0., 1., 9.\n*Element, type=R3D3\n7, 10, 20, 30\n"
      "*Nset, nset=Set-1\n10\n*Ngen\n10, 30\n*End Part\n";
  const std::string uses =
      "*Instance, name=Tool-1, part=Tool\n*End Instance\n*Elset, elset=T, instance=Tool-1\n 7\n"
      "*Surface, type=ELEMENT, name=Lower\nT, SPOS\nTool-1.T, S1\n*Surface, type=ELEMENT, name=Top\nPart-1-1.Set-1, "
      "S1\n"
      "*Tie, name=Glue\nTop, Lower\n";
  for (const std::string& parts : {shell + kPart, kPart + shell}) {
    const std::string text = deck(uses, "", parts);
    std::vector<std::string> warnings;
    const TetMesh m = read_mesh(put("a.inp", text), &warnings, 1);
    EXPECT_TRUE(warnings.empty());
    EXPECT_EQ(m.points.size(), 5U);
    EXPECT_EQ(m.triangles.size(), 2U);
    write_mesh(path("b.inp"), m, 1);
    EXPECT_EQ(get("b.inp"), text);
  }
}

TEST_F(Inp, TheMeshMayBeInTheInstanceOrInAPartWithoutOne) {
  const std::string in_instance = "*Part, name=P\n*End Part\n*Assembly, name=A\n*Instance, name=P-1, part=P\n" +
                                  kTwoTets + "*End Instance\n*Nset, nset=N, instance=P-1\n10, 20, 30\n*End Assembly\n";
  const std::string alone = "*Part, name=P\n" + kTwoTets + "*End Part\n*Nset, nset=N\n10, 20, 30\n";
  for (const std::string& text : {in_instance, alone}) {
    const TetMesh m = read_mesh(put("a.inp", text), nullptr, 1);
    EXPECT_EQ(m.tets.size(), 2U);
    EXPECT_EQ(m.triangles.size(), 1U);
    write_mesh(path("b.inp"), m, 1);
    EXPECT_EQ(get("b.inp"), text);
  }
}

TEST_F(Inp, NamesOfInstancesMayBeInQuotationMarks) {
  const std::string text = "*Part, name=\"my part\"\n" + kTwoTets +
                           "*End Part\n*Assembly, name=A\n*Instance, name=\"my part-1\", part=\"my part\"\n"
                           "*End Instance\n*Nset, nset=N, instance=\"my part-1\"\n10, 20, 30\n*End Assembly\n"
                           "*Boundary\n\"my part-1\".900000000000000050, 1, 3\n";
  const TetMesh m = read_mesh(put("a.inp", text), nullptr, 1);
  EXPECT_EQ(m.required_vertices, std::vector<Index>{4});
  EXPECT_EQ(m.triangles.size(), 1U);
  write_mesh(path("b.inp"), m, 1);
  EXPECT_EQ(get("b.inp"), text);
}

TEST_F(Inp, AnAssemblyWithoutPartsIsAFlatDeck) {
  const std::string text = "*Assembly, name=A\n" + kTwoTets + "*End Assembly\n*Boundary\n10, 1, 3\n";
  const TetMesh m = read_mesh(put("a.inp", text), nullptr, 1);
  EXPECT_EQ(m.tets.size(), 2U);
  EXPECT_EQ(m.required_vertices, std::vector<Index>{0});
}

TEST_F(Inp, APartMayBeIncluded) {
  put("mesh.inp", kTwoTets);
  const std::string text =
      "*Part, name=P\n*Include, input=mesh.inp\n*End Part\n*Assembly, name=A\n"
      "*Instance, name=P-1, part=P\n*End Instance\n*End Assembly\n*Boundary\nP-1.10, 1, 3\n";
  const TetMesh m = read_mesh(put("a.inp", text), nullptr, 1);
  EXPECT_EQ(m.tets.size(), 2U);
  EXPECT_EQ(m.required_vertices, std::vector<Index>{0});
}

TEST_F(Inp, SeveralMeshesInOneDeckAreRefused) {
  std::string second = kPart;
  second.replace(second.find("Part-1"), 6, "Part-2");
  const std::string two = read_error(put("a.inp", deck("", "", kPart + second)));
  EXPECT_TRUE(contains(two, "the parts Part-1 and Part-2 both have tetrahedra; write each")) << two;
  const std::string again = "*Instance, name=Part-1-2, part=Part-1\n*End Instance\n";
  const std::string twice = read_error(put("a.inp", deck(again)));
  EXPECT_TRUE(contains(twice, "the part Part-1 has several instances, Part-1-1 and Part-1-2; write")) << twice;
  EXPECT_TRUE(contains(read_error(put("a.inp", kTwoTets + kPart)), "a.inp:10: nodes precede the parts")) << twice;
  EXPECT_TRUE(contains(read_error(put("a.inp", "*Part\n" + kTwoTets)), "a.inp:1: *PART has no NAME"));
}

TEST_F(Inp, OptimizationKeepsADeckOfParts) {
  write_mesh(path("mesh.inp"), cube(4, 0.2), 1);
  // The side at z = 0: 25 nodes, and elements with a face there.
  std::string mesh = get("mesh.inp");
  const TetMesh plain = read_mesh(path("mesh.inp"), nullptr, 1);
  std::string side;
  for (std::size_t v = 0; v < plain.points.size(); ++v) {
    if (plain.points[v][2] == 0) side += std::to_string(plain.deck_nodes[v]) + "\n";
  }
  const std::string text =
      "*Part, name=P\n" + mesh + "*End Part\n*Assembly, name=A\n*Instance, name=P-1, part=P\n*End Instance\n" +
      "*Nset, nset=Side, instance=P-1\n" + side + "*End Assembly\n*Initial Conditions, type=TEMPERATURE\nSide, 20.\n";
  TetMesh m = read_mesh(put("a.inp", text), nullptr, 1);
  Options options;
  options.effort = Effort::best;
  options.device = Device::cpu;
  const Report report = optimize(m, options);
  EXPECT_GT(report.vertices_inserted + report.vertices_removed, 0);
  write_mesh(path("b.inp"), m, 1);
  const TetMesh back = read_mesh(path("b.inp"), nullptr, 1);
  EXPECT_TRUE(validate(back, 1).ok());
  EXPECT_EQ(back.points, m.points);
  EXPECT_EQ(groups_of(back, 2), groups_of(m, 2));
  EXPECT_EQ(back.triangles.size(), m.triangles.size());
  const std::string result = get("b.inp");
  EXPECT_LT(result.find("*End Part"), result.find("*Nset, nset=Side, instance=P-1\n"));
}

TEST_F(Inp, LinesOfInsertedNodesNameTheInstance) {
  const std::string text = deck("", "*Boundary\nPart-1-1.20, 1, 3\nPart-1-1.30, 1, 3\nPart-1-1.40, 1, 3\n");
  TetMesh m = read_mesh(put("a.inp", text), nullptr, 1);
  // The face 20, 30, 40 divided at its middle.
  m.points.push_back({1. / 3, 1. / 3, 1. / 3});
  m.point_tags.push_back(0);
  m.deck_nodes.push_back(0);
  m.tets = {{0, 1, 2, 5}, {0, 2, 3, 5}, {0, 3, 1, 5}, {1, 2, 5, 4}, {2, 3, 5, 4}, {3, 1, 5, 4}};
  const int upper = m.tet_tags[1];
  m.tet_tags = {m.tet_tags[0], m.tet_tags[0], m.tet_tags[0], upper, upper, upper};
  m.triangles = {{1, 2, 5}, {2, 3, 5}, {3, 1, 5}};
  m.triangle_tags.assign(3, m.triangle_tags.at(0));
  write_mesh(path("b.inp"), m, 1);
  EXPECT_TRUE(contains(get("b.inp"), "\nPart-1-1.900000000000000051, 1, 3")) << get("b.inp");
}

}  // namespace
}  // namespace tetune::test

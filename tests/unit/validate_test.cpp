// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mesh/validate_arrays.hpp"
#include "support/meshes.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// Expects exactly one finding, and that optimize() rejects the mesh without changing it.
void expect_refused(TetMesh mesh, Defect defect, std::int64_t count, const std::vector<Index>& first) {
  const ValidationReport report = validate(mesh);
  ASSERT_EQ(report.findings.size(), 1U) << report.message(false);
  EXPECT_EQ(report.findings[0].defect, defect) << to_string(report.findings[0].defect);
  EXPECT_EQ(report.findings[0].count, count);
  EXPECT_EQ(report.findings[0].first, first);
  const auto tets = mesh.tets;
  try {
    optimize(mesh);
    ADD_FAILURE() << "accepted";
  } catch (const MeshError& e) {
    const std::string finding = report.message(false);
    const std::string line = finding.substr(0, finding.find(", the first near"));
    EXPECT_NE(std::string(e.what()).find(line), std::string::npos) << e.what();
  }
  EXPECT_EQ(mesh.tets, tets);
}

TEST(Validate, FindingsAreSentences) {
  const auto message = [](Finding finding) { return ValidationReport{{std::move(finding)}}.message(true); };
  EXPECT_EQ(
      message({Defect::inverted_tet, 282, {0, 4}, "tetrahedra", Point3{1, 2, 3}}),
      "the mesh is not valid:\n  282 of the tetrahedra are inverted (negative volume) (first, counted from 1: 1, "
      "5), the first near 1 2 3\n  untangle them (untangle=true), or repair the mesh in the program that made it.");
  const std::string end = "\n  repair or remove these in the program that made the mesh.";
  EXPECT_EQ(message({Defect::index_out_of_range, 1, {6}, "corners"}),
            "the mesh is not valid:\n  1 of the corners has an index out of range (first, counted from 1: 7)" + end);
  TetMesh mesh = test::cube(1);
  mesh.point_tags.push_back(0);
  EXPECT_EQ(validate(mesh).message(true),
            "the mesh is not valid:\n  vertex tags have 9 entries, and not 8\n  in the program that fills these "
            "arrays, give them that many entries.");
  mesh.corners = {8};
  EXPECT_TRUE(validate(mesh).message(true).ends_with(end));
  mesh.corners.clear();
  mesh.point_tags.pop_back();
  mesh.point_data = {{"heat", 0, std::vector<double>(8)}};
  EXPECT_EQ(validate(mesh).message(true),
            "the mesh is not valid:\n  values of \"heat\" on vertices, of 0 components, have 8 entries" + end);
}

TEST(Validate, IndicesOutOfRangeAreNamedInTheNumberingOfTheCaller) {
  TetMesh mesh = test::one_tet();
  const auto line = [&mesh](bool one_based) {
    const std::string text = validate(mesh).message(one_based);
    const std::size_t begin = text.find("): ") + 3;
    return text.substr(begin, text.find('\n', begin) - begin);
  };
  for (Index& v : mesh.tets[0]) ++v;
  EXPECT_EQ(line(false), "index 4, but there are 4 vertices (0 to 3); if the ids count from 1, subtract 1");
  EXPECT_EQ(line(true), "index 5, but there are 4 vertices (1 to 4)");
  mesh.tets = {{0, 1, 2, -1}};
  EXPECT_EQ(line(false), "index -1, but there are 4 vertices (0 to 3)");
  EXPECT_EQ(line(true), "index 0, but there are 4 vertices (1 to 4)");
  mesh = test::one_tet();
  mesh.ridges = {2};
  EXPECT_EQ(line(false), "index 2, but there are no edges");
  mesh.ridges.clear();
  mesh.second_order = true;
  mesh.curved_edges = {{{0, 7}, {0, 0, 0}}};
  EXPECT_EQ(line(false), "index 7, but there are 4 vertices (0 to 3)");
}

TEST(Validate, CurvedEdgesAreEdgesInOrder) {
  TetMesh m = test::cube(1);
  m.second_order = true;
  const std::array<Index, 4> tet = m.tets[0];
  const Index a = *std::min_element(tet.begin(), tet.end());
  const Index b = *std::max_element(tet.begin(), tet.end());
  m.curved_edges = {{{a, b}, {0, 0, 0}}};
  EXPECT_TRUE(validate(m).ok());
  const auto refused = [&m](Defect defect) {
    const ValidationReport report = validate(m);
    return report.findings.size() == 1 && report.findings[0].defect == defect &&
           report.findings[0].where == "curved edges";
  };
  m.curved_edges = {{{b, a}, {0, 0, 0}}};
  EXPECT_TRUE(refused(Defect::bad_curved_edge));
  m.curved_edges = {{{a, b}, {0, 0, 0}}, {{a, b}, {0, 0, 0}}};
  EXPECT_TRUE(refused(Defect::bad_curved_edge));
  m.curved_edges = {{{a, b}, {0, std::nan(""), 0}}};
  EXPECT_TRUE(refused(Defect::not_finite));
  m.curved_edges = {{{a, 99}, {0, 0, 0}}};
  EXPECT_FALSE(validate(m).ok());
  EXPECT_EQ(validate(m).findings[0].defect, Defect::index_out_of_range);
  m.points.push_back({9, 9, 9});
  m.point_tags.push_back(0);
  m.curved_edges = {{{a, Index(m.points.size() - 1)}, {0, 0, 0}}};
  EXPECT_TRUE(refused(Defect::bad_curved_edge));
}

TEST(Validate, AcceptsGoodMeshes) {
  EXPECT_TRUE(validate(test::one_tet()).ok());
  EXPECT_TRUE(validate(test::cube(3, 0.2)).ok());
  EXPECT_TRUE(validate(test::two_materials(4, 0.1)).ok());
  EXPECT_TRUE(validate(TetMesh{}).ok());
}

TEST(Validate, InvertedAndFlat) {
  TetMesh m = test::cube(2);
  std::swap(m.tets[7][0], m.tets[7][1]);
  // An inverted tetrahedron lies on the wrong side of its faces as well.
  const ValidationReport report = validate(m);
  ASSERT_EQ(report.findings.size(), 2U);
  EXPECT_EQ(report.findings[0].defect, Defect::inverted_tet);
  EXPECT_EQ(report.findings[0].first, std::vector<Index>{7});
  EXPECT_EQ(report.findings[1].defect, Defect::same_side_of_face);
  EXPECT_THROW(optimize(m), MeshError);

  TetMesh flat = test::one_tet();
  flat.points[3] = {0.25, 0.25, 0};
  expect_refused(flat, Defect::flat_tet, 1, {0});
  TetMesh inverted = test::one_tet();
  inverted.points[3] = {0.25, 0.25, -1};
  expect_refused(inverted, Defect::inverted_tet, 1, {0});
}

TEST(Validate, RefusesMoreEntriesThanIdsHave) {
  EXPECT_TRUE(validate_counts({kMaxEntries, kMaxTets, kMaxEntries, kMaxEntries, kMaxEntries}).ok());
  // 600 million tetrahedra have 2.4e9 corners.
  const ValidationReport many = validate_counts({5'000'000'000, 600'000'000, 2'400'000'000, 1LL << 31, 1LL << 32});
  ASSERT_EQ(many.findings.size(), 5U);
  for (const Finding& f : many.findings) EXPECT_EQ(f.defect, Defect::bad_array_length);
  EXPECT_EQ(many.findings[0].count, 5'000'000'000);
  EXPECT_NE(many.message(true).find("tetrahedra, of which there can be 400000000, have 600000000 entries"),
            std::string::npos)
      << many.message(true);
}

TEST(Validate, DecidesByExactArithmetic) {
  // Off the plane by less than the rounding error of the volume; the differences of coordinates are exact.
  TetMesh m = test::one_tet();
  m.points = {{0, 0, 0}, {1, 0, 0.3}, {0, 1, 0.7}, {0.5, 0.5, std::nextafter(0.5, 1.0)}};
  EXPECT_TRUE(validate(m).ok());
  m.points[3][2] = std::nextafter(0.5, 0.0);
  EXPECT_EQ(validate(m).findings[0].defect, Defect::inverted_tet);
}

TEST(Validate, AcceptsAnyUnitButNotTinyTetrahedra) {
  TetMesh m = test::one_tet();
  m.points.push_back({1e170, 0, 0});
  m.point_tags.push_back(0);
  expect_refused(m, Defect::tiny_tet, 1, {0});
  EXPECT_NE(validate(m).message(true).find("; the largest coordinate is 1e+170, of vertex 5, which may be wrong\n"),
            std::string::npos);
  for (const double unit : {1e307, 1e-300}) {
    TetMesh scaled = test::scaled(test::scrambled(test::cube(4, 0.2), 1), unit);
    ASSERT_TRUE(validate(scaled).ok());
    const auto points = scaled.points;
    optimize(scaled);
    EXPECT_TRUE(validate(scaled).ok()) << unit;
    EXPECT_NE(scaled.points, points);
  }
}

TEST(Validate, IndicesLengthsAndNumbers) {
  TetMesh m = test::cube(2);
  m.tets[3][2] = 27;
  m.tets[5][1] = -1;
  expect_refused(m, Defect::index_out_of_range, 2, {3, 5});
  m = test::cube(2);
  m.tet_tags.pop_back();
  expect_refused(m, Defect::bad_array_length, 47, {});
  m = test::cube(2);
  m.points[4][1] = std::nan("");
  expect_refused(m, Defect::not_finite, 1, {4});
  m = test::cube(2);
  m.required_tets = {48};
  expect_refused(m, Defect::index_out_of_range, 1, {0});
  m = test::one_tet();
  m.tets[0][1] = 0;
  expect_refused(m, Defect::repeated_vertex, 1, {0});
}

TEST(Validate, RepeatedVertexWithADenormalCoordinate) {
  TetMesh m = test::one_tet();
  m.points = {{1, 0, 5}, {1, 1, 1.9999999999999993e-308}, {0, 2, 0}, {0, 0, 10.5}};
  m.tets = {{0, 1, 2, 1}};
  expect_refused(m, Defect::repeated_vertex, 1, {0});
}

TEST(Validate, ManyTetrahedraAtOneFace) {
  TetMesh m = test::two_tets(0.5);
  const std::array<Index, 4> tet = m.tets[0];
  for (int i = 0; i < 100'000; ++i) m.tets.push_back(tet);
  m.tets.push_back({0, 0, 0, 0});
  m.tet_tags.assign(m.tets.size(), 0);
  const ValidationReport report = validate(m);
  ASSERT_EQ(report.findings.size(), 2U);
  EXPECT_EQ(report.findings[0].defect, Defect::repeated_vertex);
  EXPECT_EQ(report.findings[1].defect, Defect::duplicate_tet);
  EXPECT_EQ(report.findings[1].count, 100'000);
  EXPECT_EQ(report.findings[1].first, (std::vector<Index>{2, 3, 4, 5, 6}));
}

TEST(Validate, DuplicateNonManifoldAndMisoriented) {
  TetMesh m = test::one_tet();
  m.tets.push_back({1, 2, 0, 3});
  m.tet_tags.push_back(0);
  expect_refused(m, Defect::duplicate_tet, 1, {1});

  m = test::two_tets(1);
  m.points.push_back({0, 0, 2});
  m.point_tags.push_back(0);
  m.tets.push_back({5, 2, 4, 3});
  m.tet_tags.push_back(0);
  expect_refused(m, Defect::face_on_three_tets, 3, {0, 1, 2});
  m.tets = {{0, 2, 4, 3}, {5, 2, 4, 3}};
  m.tet_tags = {0, 0};
  expect_refused(m, Defect::same_side_of_face, 1, {1});
}

TEST(Validate, ADuplicateIsOneFinding) {
  TetMesh m = test::cube(2);
  // One with faces on the boundary, and one in another order of vertices, twice.
  const std::array<Index, 4> tet = m.tets[11];
  m.tets.push_back(m.tets[0]);
  m.tets.push_back({tet[1], tet[2], tet[0], tet[3]});
  m.tets.push_back({tet[2], tet[0], tet[1], tet[3]});
  m.tet_tags.resize(m.tets.size(), 0);
  expect_refused(m, Defect::duplicate_tet, 3, {48, 49, 50});
  // A duplicate with the other orientation is inverted, and a defect beside it is found too.
  m = test::cube(2);
  m.tets.push_back({m.tets[11][1], m.tets[11][0], m.tets[11][2], m.tets[11][3]});
  std::swap(m.tets[30][0], m.tets[30][1]);
  m.tet_tags.resize(m.tets.size(), 0);
  const ValidationReport report = validate(m);
  ASSERT_EQ(report.findings.size(), 3U);
  EXPECT_EQ(report.findings[0].defect, Defect::inverted_tet);
  EXPECT_EQ(report.findings[0].first, (std::vector<Index>{30, 48}));
  EXPECT_EQ(report.findings[1].defect, Defect::duplicate_tet);
  EXPECT_EQ(report.findings[1].first, std::vector<Index>{48});
  EXPECT_EQ(report.findings[2].defect, Defect::same_side_of_face);
}

TEST(Validate, ListsTheFirstIdsOnly) {
  TetMesh m = test::cube(3);
  for (auto& p : m.points) p[2] = 0;
  const ValidationReport report = validate(m);
  EXPECT_EQ(report.findings[0].count, 162);
  EXPECT_EQ(report.findings[0].first.size(), 5U);
  EXPECT_NE(report.message(true).find("counted from 1: 1, 2, 3, 4, 5"), std::string::npos) << report.message(true);
}

void turn(TetMesh& m, std::size_t tet) { std::swap(m.tets[tet][2], m.tets[tet][3]); }

TEST(OrientUniformly, TurnsAllInvertedTetrahedra) {
  TetMesh m = test::cube(2);
  const auto good = m.tets;
  EXPECT_EQ(orient_uniformly(m), 0);
  for (std::size_t t = 0; t < m.tets.size(); ++t) turn(m, t);
  EXPECT_EQ(orient_uniformly(m), static_cast<std::int64_t>(m.tets.size()));
  EXPECT_EQ(m.tets, good);
  EXPECT_TRUE(m.listed_inside_out);
}

TEST(OrientUniformly, TurnsTetrahedraThatDisagreeWithTheirNeighbors) {
  TetMesh m = test::cube(4, 0.2);
  const auto good = m.tets;
  for (std::size_t t = 0; t < m.tets.size(); t += 3) turn(m, t);
  EXPECT_EQ(validate(m).ok(), false);
  EXPECT_EQ(orient_uniformly(m), static_cast<std::int64_t>((good.size() + 2) / 3));
  EXPECT_EQ(m.tets, good);
  EXPECT_FALSE(m.listed_inside_out);
}

TEST(OrientUniformly, TurnsAnInvertedPart) {
  TetMesh m = test::cube(2);
  const auto one = static_cast<Index>(m.points.size());
  const std::size_t tets = m.tets.size();
  for (Index v = 0; v < one; ++v) {
    const Point3& p = m.points[static_cast<std::size_t>(v)];
    m.points.push_back({p[0] + 2, p[1], p[2]});
  }
  for (std::size_t t = 0; t < tets; ++t) {
    auto tet = m.tets[t];
    for (Index& v : tet) v += one;
    m.tets.push_back(tet);
  }
  m = test::with_tags(m);
  const auto good = m.tets;
  for (std::size_t t = tets; t < 2 * tets; ++t) turn(m, t);
  EXPECT_EQ(orient_uniformly(m), static_cast<std::int64_t>(tets));
  EXPECT_EQ(m.tets, good);
}

TEST(OrientUniformly, TurnsPartsInAnyUnit) {
  // Volumes underflow in one unit and overflow in the other.
  for (const double unit : {1e-110, 1e105}) {
    TetMesh m = test::scaled(test::cube(3, 0.2), unit);
    const auto good = m.tets;
    std::int64_t turned = 0;
    for (std::size_t t = 0; t < m.tets.size(); t += 2, ++turned) turn(m, t);
    EXPECT_EQ(orient_uniformly(m), turned);
    EXPECT_EQ(m.tets, good);
  }
}

TEST(OrientUniformly, KeepsInvertedTetrahedraThatAgreeWithTheirNeighbors) {
  TetMesh m = test::cube(4);
  m.points[62] = {2, 2, 2};  // the middle vertex, moved far outside
  const auto tangled = m.tets;
  ASSERT_FALSE(validate(m).ok());
  EXPECT_EQ(orient_uniformly(m), 0);
  EXPECT_EQ(m.tets, tangled);
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
// Vertices inserted and removed on the surface: it keeps its shape, its patches and the lists of the caller.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <ranges>
#include <set>
#include <span>
#include <utility>

#include "mesh/tet.hpp"
#include "support/constrained.hpp"
#include "support/curved.hpp"
#include "support/entities.hpp"
#include "support/meshes.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

using Face = std::array<Index, 3>;

/// The area of a triangle times its normal.
Vec3 area_vector(const TetMesh& m, const Face& f) {
  return 0.5 * cross(test::at(m, f[1]) - test::at(m, f[0]), test::at(m, f[2]) - test::at(m, f[0]));
}

std::map<int, double> area_by_tag(const TetMesh& m) {
  std::map<int, double> areas;
  for (std::size_t i = 0; i < m.triangles.size(); ++i) {
    areas[m.triangle_tags[i]] += norm(area_vector(m, m.triangles[i]));
  }
  return areas;
}

Options editing() {
  Options options;
  options.effort = Effort::best;
  options.surface_vertices = SurfaceVertices::edit;
  return options;
}

std::set<Index> surface_vertices(const TetMesh& m) {
  std::set<Index> vertices;
  for (const test::SkinFace& f : test::skin(m)) vertices.insert(f.v.begin(), f.v.end());
  return vertices;
}

/// Inserted vertices of the surface, and vertices of the surface that are gone.
std::pair<int, int> surface_changes(const TetMesh& before, const TetMesh& after, const Report& report) {
  if (report.vertex2original.empty()) return {0, 0};
  int inserted = 0;
  for (const Index v : surface_vertices(after)) {
    inserted += report.vertex2original[static_cast<std::size_t>(v)] < 0 ? 1 : 0;
  }
  const std::set<Index> present(report.vertex2original.begin(), report.vertex2original.end());
  int removed = 0;
  for (const Index v : surface_vertices(before)) removed += present.count(v) == 0 ? 1 : 0;
  return {inserted, removed};
}

TEST(SurfaceEdit, KeepsPatchesInterfacesAndLists) {
  std::pair<int, int> total{0, 0};
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const TetMesh before = test::with_listed_sides(
        test::scrambled(seed % 2 == 0 ? test::two_materials(6, 0.3) : test::cube(5, 0.3, seed), 3, seed));
    TetMesh after = before;
    const Report report = optimize(after, editing());
    ASSERT_TRUE(validate(after).ok());
    test::expect_present(after);
    test::expect_near_by_tag(area_by_tag(after), area_by_tag(before), 1e-11);
    test::expect_near_by_tag(test::region_volumes(after), test::region_volumes(before), 1e-11);
    // The list has each face of the surface once: listing again finds each a second time.
    std::multiset<Face> faces;
    for (const Face& f : test::with_listed_sides(after).triangles) faces.insert(ascending(f));
    for (const Face& f : after.triangles) EXPECT_EQ(faces.count(ascending(f)), 2U);
    EXPECT_EQ(faces.size(), 2 * after.triangles.size());
    EXPECT_GE(quality(after).dihedral_min, quality(before).dihedral_min);
    EXPECT_LE(static_cast<double>(after.tets.size()), 1.1 * static_cast<double>(before.tets.size()));
    const auto changes = surface_changes(before, after, report);
    total.first += changes.first;
    total.second += changes.second;
  }
  EXPECT_GT(total.first, 5) << "vertices inserted on the surface";
  EXPECT_GT(total.second, 5) << "vertices removed from the surface";
}

TEST(SurfaceEdit, TrianglesDescendFromTheirPatch) {
  const TetMesh before = test::with_listed_sides(test::scrambled(test::cube(5, 0.3), 3, 1));
  TetMesh after = before;
  const Report report = optimize(after, editing());
  ASSERT_EQ(report.triangle2original.size(), after.triangles.size());
  for (std::size_t i = 0; i < after.triangles.size(); ++i) {
    const auto original = static_cast<std::size_t>(report.triangle2original[i]);
    EXPECT_EQ(after.triangle_tags[i], before.triangle_tags[original]);
    EXPECT_GT(dot(area_vector(after, after.triangles[i]), area_vector(before, before.triangles[original])), 0);
  }
}

/// Two cubes that share the vertices of one edge and no face.
TetMesh touching_cubes() {
  TetMesh m = test::scrambled(test::cube(4, 0.3), 3, 7);
  std::vector<Index> copy(m.points.size());
  const std::size_t n = m.points.size();
  for (std::size_t v = 0; v < n; ++v) {
    const Point3 p = m.points[v];
    const bool is_shared = p[0] == 0 && p[1] == 0;
    copy[v] = is_shared ? static_cast<Index>(v) : static_cast<Index>(m.points.size());
    if (!is_shared) m.points.push_back({-p[0], -p[1], p[2]});
  }
  const std::size_t tets = m.tets.size();
  for (std::size_t t = 0; t < tets; ++t) {
    auto tet = m.tets[t];
    for (Index& v : tet) v = copy[static_cast<std::size_t>(v)];
    m.tets.push_back(tet);
  }
  return test::with_tags(std::move(m));
}

TEST(SurfaceEdit, PartsThatTouchStayConforming) {
  const TetMesh before = touching_cubes();
  ASSERT_TRUE(validate(before).ok());
  TetMesh after = before;
  const Report report = optimize(after, editing());
  EXPECT_GT(report.vertices_inserted + report.vertices_removed, 0);
  ASSERT_TRUE(validate(after).ok());
  // Each edge on the common line is one of both parts.
  std::map<std::pair<Index, Index>, std::set<bool>> parts;
  for (const auto& tet : after.tets) {
    double x = 0;
    for (const Index v : tet) x += after.points[static_cast<std::size_t>(v)][0];
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        const Point3& p = after.points[static_cast<std::size_t>(tet[i])];
        const Point3& q = after.points[static_cast<std::size_t>(tet[j])];
        const bool on_line = p[0] == 0 && p[1] == 0 && q[0] == 0 && q[1] == 0;
        if (tet[i] < tet[j] && on_line) parts[{tet[i], tet[j]}].insert(x > 0);
      }
    }
  }
  EXPECT_FALSE(parts.empty());
  for (const auto& [edge, sides] : parts) EXPECT_EQ(sides.size(), 2U);
}

void expect_same_for_any_number_of_threads(const TetMesh& before, Options options) {
  options.threads = 1;
  TetMesh one = before;
  optimize(one, options);
  options.threads = 3;
  TetMesh three = before;
  optimize(three, options);
  EXPECT_EQ(one.points, three.points);
  EXPECT_EQ(one.tets, three.tets);
  EXPECT_EQ(one.triangles, three.triangles);
}

TEST(SurfaceEdit, IsTheSameForAnyNumberOfThreads) {
  expect_same_for_any_number_of_threads(test::with_listed_sides(test::scrambled(test::two_materials(6, 0.3), 3, 5)),
                                        editing());
}

TEST(SurfaceEdit, HappensWhereOptionsAllowItOnly) {
  const auto edits = [](const Options& options, unsigned seed = 3) {
    const TetMesh before = test::with_listed_sides(test::scrambled(test::cube(5, 0.3, seed), seed, 3));
    TetMesh after = before;
    const Report report = optimize(after, options);
    const auto changes = surface_changes(before, after, report);
    return changes.first + changes.second;
  };
  Options options = editing();
  EXPECT_GT(edits(options), 0);
  options.surface_vertices = SurfaceVertices::automatic;
  EXPECT_GT(edits(options), 0);
  options.surface_vertices = SurfaceVertices::keep;
  EXPECT_EQ(edits(options), 0);
  options = editing();
  options.keep_vertices = true;
  EXPECT_EQ(edits(options), 0);
  options = editing();
  options.boundary_flips = false;
  EXPECT_EQ(edits(options), 0);
  options = editing();
  options.boundary = Boundary::fixed;
  EXPECT_EQ(edits(options), 0);
  options.boundary = Boundary::slide;
  EXPECT_GT(edits(options), 0);
  options.max_deviation = 0.01;
  EXPECT_GT(edits(options), 0);
  options = editing();
  options.effort = Effort::standard;
  // In its single round, vertices inside the mesh may be the better choice everywhere.
  int sum = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) sum += edits(options, seed);
  EXPECT_GT(sum, 0);
  EXPECT_EQ(edits(Options{}), 0);
}

TEST(SurfaceEdit, LeavesConstraintsAlone) {
  TetMesh before = test::with_listed_sides(test::scrambled(test::cube(5, 0.3), 3, 4));
  std::vector<Face> kept;
  for (std::size_t i = 0; i < before.triangles.size(); i += 5) {
    before.required_triangles.push_back(static_cast<Index>(i));
    kept.push_back(ascending(before.triangles[i]));
  }
  for (Index v = 0; v < 20; ++v) before.required_vertices.push_back(v);
  TetMesh after = before;
  const Report report = optimize(after, editing());
  ASSERT_TRUE(validate(after).ok());
  test::expect_present(after);
  ASSERT_EQ(after.required_triangles.size(), kept.size());
  std::map<Index, Index> original2new;
  for (std::size_t v = 0; v < after.points.size(); ++v) {
    const Index original = report.vertex2original.empty() ? static_cast<Index>(v) : report.vertex2original[v];
    if (original >= 0) original2new[original] = static_cast<Index>(v);
  }
  for (std::size_t i = 0; i < kept.size(); ++i) {
    Face now{};
    for (std::size_t k = 0; k < 3; ++k) now[k] = original2new.at(kept[i][k]);
    EXPECT_EQ(ascending(now), ascending(after.triangles[static_cast<std::size_t>(after.required_triangles[i])]));
  }
  for (Index v = 0; v < 20; ++v) {
    EXPECT_EQ(after.points[static_cast<std::size_t>(original2new.at(v))], before.points[static_cast<std::size_t>(v)]);
  }
}

/// The faces of the surface by sheet: the regions on both sides, and the tag.
using Sheets = std::map<std::pair<std::array<int, 2>, int>, std::vector<test::SkinFace>>;
Sheets sheets_of(const TetMesh& m) {
  Sheets sheets;
  for (const test::SkinFace& f : test::skin(m)) sheets[{f.regions, f.tag}].push_back(f);
  return sheets;
}

/// A mesh with a curved surface, whose outer faces are listed with two tags.
TetMesh curved(std::uint32_t seed) {
  TetMesh m = seed % 2 == 0 ? test::waved(test::two_materials(6, 0.15), seed) : test::ball(6, 0.15, seed);
  for (const test::SkinFace& f : test::skin(m)) {
    double x = 0;
    for (const Index v : f.v) x += test::at(m, v).x / 3;
    m.triangles.push_back(f.v);
    m.triangle_tags.push_back(x < 0.3 ? 1 : 2);
  }
  return m;
}

Options bending() {
  Options options = editing();
  options.boundary = Boundary::slide;
  options.feature_angle = 60;
  return options;
}

/// The number of vertices on an edge of the unit cube stretched along x.
int vertices_on_long_edges(const TetMesh& m) {
  int on = 0;
  for (const Point3& p : m.points) on += (p[1] == 0 || p[1] == 1) && (p[2] == 0 || p[2] == 1) ? 1 : 0;
  return on;
}

/// All vertices on the edges of a bar are listed as corners: no vertex slides along these edges.
TEST(SurfaceEdit, InsertsBetweenCorners) {
  int inserted = 0;
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    TetMesh before = test::cube(4, 0.2, seed);
    for (std::size_t v = 0; v < before.points.size(); ++v) {
      Point3& p = before.points[v];
      const int sides = (p[1] == 0 || p[1] == 1) + (p[2] == 0 || p[2] == 1) + (p[0] == 0 || p[0] == 1);
      if (sides >= 2) before.corners.push_back(static_cast<Index>(v));
      p[0] *= 4;
    }
    TetMesh after = before;
    Options options = editing();
    options.boundary = Boundary::slide;
    optimize(after, options);
    ASSERT_TRUE(validate(after).ok());
    test::expect_present(after);
    // Exactly on the edges: the bar keeps its shape.
    inserted += vertices_on_long_edges(after) - vertices_on_long_edges(before);
    EXPECT_NEAR(test::region_volumes(after).at(0), 4, 1e-12);
  }
  EXPECT_GT(inserted, 0);
}

TEST(SurfaceEdit, OnACurvedSurfaceKeepsItsSheetsAndLines) {
  std::int64_t changes = 0;
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    const TetMesh before = curved(seed);
    TetMesh after = before;
    const Report report = optimize(after, bending());
    ASSERT_TRUE(validate(after).ok()) << validate(after).message(false);
    EXPECT_GE(quality(after).dihedral_min, quality(before).dihedral_min - 1e-9);
    EXPECT_EQ(after.triangles.size(), test::skin(after).size());
    const Sheets old_sheets = sheets_of(before);
    const Sheets new_sheets = sheets_of(after);
    ASSERT_EQ(old_sheets.size(), new_sheets.size());
    for (const auto& [sheet, faces] : new_sheets) {
      const std::vector<TrianglePoints> old_faces = test::corners(before, old_sheets.at(sheet));
      const std::vector<TrianglePoints> new_faces = test::corners(after, faces);
      const ClosestTriangle old_tree(old_faces);
      for (const TrianglePoints& t : new_faces) {
        for (const Vec3& p : t) EXPECT_LT(std::sqrt(old_tree.distance2(p)), 1e-13);
      }
      // The mean edge is 1/6 to 1/3. Sliding alone reaches half of it at corners below the feature angle.
      EXPECT_LT(test::sampled_distance(new_faces, old_tree, 4), 0.1);
      EXPECT_LT(test::sampled_distance(old_faces, ClosestTriangle(new_faces), 4), 0.1);
    }
    // The lines between sheets.
    const auto lines = [](const TetMesh& m) {
      return test::corners(m, test::plain_features(m, test::skin(m), 180).edges);
    };
    const ClosestTriangle old_lines(lines(before));
    const ClosestTriangle new_lines(lines(after));
    EXPECT_LT(test::sampled_distance(lines(after), old_lines, 10), 0.1);
    EXPECT_LT(test::sampled_distance(lines(before), new_lines, 10), 0.1);
    const auto [inserted, removed] = surface_changes(before, after, report);
    changes += inserted + removed;
  }
  EXPECT_GT(changes, 10);
}

/// In flat tetrahedra the rounds that lower the mean energy insert vertices on the surface. They come before any bend,
/// and planes of the triangles that slid are off the input surface.
TEST(SurfaceEdit, EarlyInsertedVerticesAreOnTheInputSurface) {
  int inserted = 0;
  for (std::uint32_t seed = 1; seed <= 2; ++seed) {
    TetMesh before = test::waved(test::cube(6, 0.2, seed), seed);
    for (Point3& p : before.points) p[2] *= 0.3;
    TetMesh after = before;
    inserted += surface_changes(before, after, optimize(after, bending())).first;
    EXPECT_LT(compare(before, after).vertices_to_old, 1e-12);
  }
  EXPECT_GT(inserted, 10);
}

/// A flat block with voids that have no vertex in common, of some tetrahedra in a row each; all faces are listed.
TetMesh with_voids(int cells, std::size_t tets_per_void, std::uint32_t seed) {
  TetMesh m = test::cube(cells, 0.27, seed);
  for (Point3& p : m.points) p[2] *= 0.3;
  const auto is_inner = [&m](Index v) {
    const Point3& p = span_of(m.points)[v];
    return p[0] > 0 && p[0] < 1 && p[1] > 0 && p[1] < 1;
  };
  std::vector<std::uint8_t> is_taken(m.points.size(), 0);
  std::vector<std::array<Index, 4>> kept;
  for (std::size_t t = 0; t < m.tets.size();) {
    const auto row = std::span(m.tets).subspan(t, std::min(tets_per_void, m.tets.size() - t));
    const bool is_void = t % 11 == seed % 11 && std::ranges::all_of(row | std::views::join, [&](Index v) {
                           return is_inner(v) && span_of(is_taken)[v] == 0;
                         });
    for (const Index v : row | std::views::join) span_of(is_taken)[v] |= is_void ? 1 : 0;
    if (!is_void) kept.push_back(m.tets[t]);
    t += is_void ? row.size() : 1;
  }
  m.tets = kept;
  m.tet_tags.assign(kept.size(), 1);
  for (const test::SkinFace& f : test::skin(m)) m.triangles.push_back(f.v);
  m.triangle_tags.assign(m.triangles.size(), 1);
  return m;
}

/// The number of edges of the outer boundary that are not on two triangles.
Size touching_edges(const TetMesh& m) {
  std::map<std::pair<Index, Index>, int> edges;
  for (const test::SkinFace& f : test::skin(m)) {
    for (std::size_t k = 0; k < 3; ++k) ++edges[std::minmax(f.v[k], f.v[(k + 1) % 3])];
  }
  return std::ranges::count_if(edges, [](const auto& edge) { return edge.second != 2; });
}

void expect_voids_stay_open(const TetMesh& before, int restarts) {
  ASSERT_TRUE(validate(before).ok()) << validate(before).message(false);
  TetMesh after = before;
  Options options = bending();
  options.feature_angle = 180;
  options.restarts = restarts;
  optimize(after, options);
  EXPECT_EQ(after.triangles.size(), test::skin(after).size());
  EXPECT_LE(touching_edges(after), touching_edges(before));
}

/// The last vertex of a void, or a contraction at a handle of three edges, would make two triangles one face.
TEST(SurfaceEdit, VoidsDoNotClose) {
  for (std::uint32_t seed = 1; seed <= (test::kSanitized ? 1U : 6U); ++seed) {
    expect_voids_stay_open(with_voids(5, 1, seed), seed % 2 == 0 ? 0 : -1);
  }
}

/// In these meshes two contractions of one pass would make the same edge.
TEST(SurfaceEdit, ContractionsOfOnePassDoNotCloseVoids) {
  expect_voids_stay_open(with_voids(7, 3, 1), 0);
  expect_voids_stay_open(with_voids(5, 3, 10), 0);
}

TEST(SurfaceEdit, OnACurvedSurfaceIsTheSameForAnyNumberOfThreads) {
  expect_same_for_any_number_of_threads(curved(2), bending());
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
// Classification of vertices whose surface is preserved; closest points on triangles.
#include <gtest/gtest.h>

#include <chrono>
#include <random>

#include "boundary/constraints.hpp"
#include "boundary/sliding/reference_surface.hpp"
#include "boundary/surface.hpp"
#include "boundary/vertex_dof.hpp"
#include "math/closest_triangle.hpp"
#include "math/constants.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"
#include "support/sanitized.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// The report of a run that moves no vertex: it counts the vertices by degrees of freedom.
Report classify(TetMesh mesh, Boundary boundary = Boundary::preserve) {
  Options options;
  options.boundary = boundary;
  options.max_iterations = 0;
  options.threads = 1;
  return optimize(mesh, options);
}

TEST(Classification, OfACube) {
  const Report r = classify(test::cube(4));
  EXPECT_EQ(r.fixed_vertices, 8);
  EXPECT_EQ(r.line_vertices, 12 * 3);
  EXPECT_EQ(r.plane_vertices, 6 * 9);
  EXPECT_EQ(r.free_vertices, 27);
}

TEST(Classification, FixedModeFixesTheSurface) {
  const Report r = classify(test::cube(4), Boundary::fixed);
  EXPECT_EQ(r.fixed_vertices, 98);
  EXPECT_EQ(r.free_vertices, 27);
}

TEST(Classification, OfATurnedCubeIsTheSame) {
  TetMesh m = test::cube(4);
  const double c = std::cos(0.7);
  const double s = std::sin(0.7);
  for (Point3& p : m.points) {
    p = {c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]};
    p = {p[0], c * p[1] - s * p[2], s * p[1] + c * p[2]};
  }
  const Report r = classify(m);
  EXPECT_EQ(r.fixed_vertices, 8);
  EXPECT_EQ(r.line_vertices, 36);
}

TEST(Classification, OfAnInterface) {
  // The interface x = 1/2: its rim lies on four outer faces (lines), where the rim meets an edge of the cube stays.
  const Report r = classify(test::two_materials(4));
  EXPECT_EQ(r.fixed_vertices, 8 + 4);
  EXPECT_EQ(r.line_vertices, 12 * 3 - 4 + 4 * 3);
  EXPECT_EQ(r.plane_vertices, 6 * 9 - 4 * 3 + 9);
  EXPECT_EQ(r.free_vertices, 27 - 9);
}

TEST(Classification, BordersBetweenPatchTagsAreLines) {
  // Half of the face z = 0 tagged 5: the border at x = 1/2.
  TetMesh m = test::cube(4);
  const auto id = [](int i, int j) { return static_cast<Index>(j * 5 + i); };
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 2; ++i) {
      m.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      m.triangles.push_back({id(i, j), id(i, j + 1), id(i + 1, j + 1)});
    }
  }
  m.triangle_tags.assign(m.triangles.size(), 5);
  const Report r = classify(m);
  EXPECT_EQ(r.fixed_vertices, 8 + 2);
  EXPECT_EQ(r.line_vertices, 36 - 2 + 3);
  EXPECT_EQ(r.plane_vertices, 54 - 3);
}

TEST(Classification, TheLastTagOfAFaceListedRepeatedlyCounts) {
  // The face z = 0 has tag 5 except for one triangle in its middle.
  const auto planes = [](const std::vector<int>& tags_of_the_one) {
    TetMesh m = test::cube(4);
    const auto id = [](int i, int j) { return static_cast<Index>(j * 5 + i); };
    for (int j = 0; j < 4; ++j) {
      for (int i = 0; i < 4; ++i) {
        m.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
        m.triangles.push_back({id(i, j), id(i, j + 1), id(i + 1, j + 1)});
      }
    }
    m.triangle_tags.assign(m.triangles.size(), 5);
    const std::size_t one = 2 * (4 * 1 + 1);
    m.triangle_tags[one] = tags_of_the_one[0];
    for (std::size_t i = 1; i < tags_of_the_one.size(); ++i) {
      m.triangles.push_back(m.triangles[one]);
      m.triangle_tags.push_back(tags_of_the_one[i]);
    }
    return classify(m).plane_vertices;
  };
  EXPECT_EQ(planes({5}), 54);
  EXPECT_EQ(planes({6}), 51);
  EXPECT_EQ(planes({0}), 51);
  EXPECT_EQ(planes({5, 0}), 54);
  EXPECT_EQ(planes({0, 5, 0}), 54);
  EXPECT_EQ(planes({6, 5}), 54);
  EXPECT_EQ(planes({5, 6, 0}), 51);
}

TEST(Classification, ListedCornersAreFixedUnlessTheListIsExhaustive) {
  TetMesh m = test::cube(4);
  m.corners = {6, 1};  // inside the face z = 0, and on the edge y = z = 0
  Report r = classify(m);
  EXPECT_EQ(r.fixed_vertices, 10);
  EXPECT_EQ(r.plane_vertices, 53);
  EXPECT_EQ(r.corners_not_held, 0);
  // Every vertex of the surface, as TetGen lists them.
  m.corners.clear();
  for (std::size_t v = 0; v < m.points.size(); ++v) {
    for (const double x : m.points[v]) {
      if (x != 0 && x != 1) continue;
      m.corners.push_back(static_cast<Index>(v));
      break;
    }
  }
  r = classify(m);
  EXPECT_EQ(r.fixed_vertices, 8);
  EXPECT_EQ(r.plane_vertices, 54);
  EXPECT_EQ(r.corners_not_held, 90);
  m.required_vertices = {6};
  EXPECT_EQ(classify(m).plane_vertices, 53);
}

TEST(Classification, EdgesConstrain) {
  TetMesh m = test::cube(4);
  const auto id = [](int i, int j, int k) { return static_cast<Index>((k * 5 + j) * 5 + i); };
  // A tagged line through the inside, along x.
  for (int i = 1; i < 3; ++i) m.edges.push_back({id(i, 2, 2), id(i + 1, 2, 2)});
  m.edge_tags = {7, 7};
  const Report r = classify(m);
  EXPECT_EQ(r.free_vertices, 27 - 3);
  EXPECT_EQ(r.line_vertices, 36 + 1);  // its middle
  EXPECT_EQ(r.fixed_vertices, 8 + 2);  // its ends
  m.edge_tags = {0, 0};
  EXPECT_EQ(classify(m).free_vertices, 27);
  m.ridges = {0, 1};
  EXPECT_EQ(classify(m).line_vertices, 37);
  m.required_edges = {0};
  EXPECT_EQ(classify(m).line_vertices, 36);
}

TEST(Classification, ATriangleInsideConstrainsIfTagged) {
  TetMesh m = test::cube(4);
  const auto id = [](int i, int j, int k) { return static_cast<Index>((k * 5 + j) * 5 + i); };
  m.triangles = {{id(1, 2, 1), id(2, 2, 1), id(2, 2, 2)}};
  m.triangle_tags = {0};
  Report r = classify(m);
  EXPECT_EQ(r.free_vertices, 27);
  EXPECT_EQ(r.triangles_dropped, 1);
  m.triangle_tags = {3};
  r = classify(m);
  EXPECT_EQ(r.triangles_dropped, 0);
  EXPECT_EQ(r.free_vertices, 24);
}

TEST(Classification, SidesOfOtherElementsRemainWithoutTags) {
  TetMesh m = test::cube(4);
  // A prism on a face of the cube's top.
  const auto id = [](int i, int j, int k) { return static_cast<Index>((k * 5 + j) * 5 + i); };
  const std::array<Index, 3> below{id(1, 1, 4), id(2, 1, 4), id(2, 2, 4)};
  const auto first = static_cast<Index>(m.points.size());
  for (const Index v : below) {
    const Point3 p = m.points[static_cast<std::size_t>(v)];
    m.points.push_back({p[0], p[1], p[2] + 0.25});
    m.point_tags.push_back(0);
  }
  m.others.push_back({"Prisms", 6, {below[0], below[1], below[2], first, first + 1, first + 2}, {0}, {}});
  m.triangles = {{id(1, 2, 1), id(2, 2, 1), id(2, 2, 2)}, {first, first + 1, first + 2}};
  m.triangle_tags = {0, 0};
  m.edges = {{first, first + 1}, {below[0], first}, {first, id(3, 3, 3)}};
  m.edge_tags = {0, 0, 0};
  const TetMesh before = m;
  const Report r = optimize(m);
  EXPECT_EQ(r.triangles_dropped, 1);
  EXPECT_EQ(r.edges_dropped, 1);
  EXPECT_EQ(m.triangles, (decltype(m.triangles){before.triangles[1]}));
  EXPECT_EQ(m.edges, (decltype(m.edges){before.edges[0], before.edges[1]}));
}

TEST(Classification, ElementsOfOtherKindsFreezeTheirVertices) {
  TetMesh m = test::cube(4);
  m.others.push_back({"Quadrilaterals", 4, {6, 7, 12, 11}, {2}, {}});
  EXPECT_EQ(classify(m).plane_vertices, 50);
}

TEST(Classification, ASheetThinnerThanTheToleranceKeepsItsShape) {
  TetMesh m = test::cube(4);
  for (Point3& p : m.points) p[2] *= 1e-7;
  const TetMesh before = m;
  optimize(m);
  const Comparison c = compare(before, m);
  EXPECT_LT(std::fabs(c.volume_change), 1e-9);
  EXPECT_LT(c.old_to_new, 1e-9);
  EXPECT_TRUE(validate(m).ok());
}

/// Lines, one per group, of two edges each; pairs of triangles, one per periodic link.
TEST(Constraints, OfManyGroupsAndLinksTakeLinearTime) {
  // With quadratic time this would take half a minute; it takes a part of a second.
  constexpr std::chrono::seconds kEnough(test::kSanitized ? 50 : 5);
  constexpr Index kCount = 20'000;
  TetMesh mesh;
  for (Index i = 0; i < kCount; ++i) {
    const auto v = static_cast<Index>(mesh.points.size());
    mesh.points.resize(mesh.points.size() + 9);
    mesh.edges.insert(mesh.edges.end(), {{v, v + 1}, {v + 1, v + 2}});
    mesh.edge_tags.insert(mesh.edge_tags.end(), 2, i + 1);
    mesh.groups.push_back({1, i + 1, "line", {i + 1}});
    mesh.triangles.insert(mesh.triangles.end(), {{v + 3, v + 4, v + 5}, {v + 6, v + 7, v + 8}, {v, v + 4, v + 5}});
    mesh.triangle_tags.insert(mesh.triangle_tags.end(), 3, i + 1);
    PeriodicLink link;
    for (Index k = 3; k < 6; ++k) link.pairs.push_back({v + k, v + k + 3});
    mesh.periodic.push_back(link);
  }
  Options options;
  for (Index i = 0; i < kCount; i += 2) options.frozen_patches.push_back(i + 1);
  const auto start = std::chrono::steady_clock::now();
  const Constraints found = find_constraints(mesh, options);
  EXPECT_LT(std::chrono::steady_clock::now() - start, kEnough);
  for (std::size_t i = 0; i < to_size_t(kCount); ++i) {
    const bool is_even = i % 2 == 0;
    EXPECT_EQ(found.vertices[9 * i], is_even ? VertexConstraint::frozen : VertexConstraint::corner);
    EXPECT_EQ(found.vertices[9 * i + 1], VertexConstraint::none);
    EXPECT_EQ(found.vertices[9 * i + 2], VertexConstraint::corner);
    EXPECT_EQ(found.vertices_without_links[9 * i + 4], is_even ? VertexConstraint::frozen : VertexConstraint::none);
    EXPECT_EQ(found.vertices[9 * i + 4], VertexConstraint::frozen);
    EXPECT_EQ(found.required_triangles[3 * i], 1);
    EXPECT_EQ(found.required_triangles[3 * i + 1], 1);
    EXPECT_EQ(found.required_triangles[3 * i + 2], 0);
  }
  options.frozen_patches.push_back(kCount + 1);
  EXPECT_THROW(find_constraints(mesh, options), OptionError);
}

TEST(Surface, IsRejectedWhereItsCornersExceed32Bits) {
  EXPECT_NO_THROW(check_surface_size(715'827'882));
  EXPECT_THROW(check_surface_size(715'827'883), MeshError);
}

TEST(ReferenceSurface, IsRejectedWhereItsSegmentsExceed32Bits) {
  EXPECT_NO_THROW(check_sliding_vertices(1'073'741'824));
  EXPECT_THROW(check_sliding_vertices(1'073'741'825), MeshError);
}

TEST(ClosestTriangle, OfADegenerateTriangleIsOnItsEdges) {
  // Where two vertices coincide, rounding may produce a normal.
  std::mt19937 random(5);
  const auto u = [&random] { return test::uniform(random); };
  for (int i = 0; i < 1000; ++i) {
    const Vec3 a{u(), u(), u()};
    const Vec3 b{u(), u(), u()};
    const double s = u();
    const Vec3 p = a + s * (b - a);
    for (const TrianglePoints& t : {TrianglePoints{a, b, b}, TrianglePoints{a, a, b}, TrianglePoints{a, b, a}}) {
      ASSERT_NEAR(std::sqrt(ClosestTriangle({t}).distance2(p)), 0, 1e-15);
      // Beyond its end.
      ASSERT_NEAR(ClosestTriangle({t}).distance2(b + s * (b - a)), s * s * dot(b - a, b - a), 1e-14);
    }
  }
}

TEST(ClosestTriangle, IsTheFirstWhereSquaredDistancesOverflow) {
  const TrianglePoints t{{{1e200, 0, 0}, {2e200, 0, 0}, {1e200, 1e200, 0}}};
  const ClosestTriangle::Hit hit = ClosestTriangle({t, t}).closest({0, 0, 1e200});
  EXPECT_EQ(hit.triangle, 0);
  EXPECT_EQ(hit.distance2, kInfinity);
}

TEST(ClosestTriangle, EqualsTheMinimumOverAllTriangles) {
  std::mt19937 random(3);
  const auto u = [&random] { return test::uniform(random); };
  std::vector<TrianglePoints> triangles;
  for (int i = 0; i < 300; ++i) {
    const Vec3 c{u(), u(), u()};
    triangles.push_back({c, c + 0.1 * Vec3{u(), u(), u()}, c + 0.1 * Vec3{u(), u(), u()}});
  }
  triangles.push_back({Vec3{0.5, 0.5, 0.5}, Vec3{0.5, 0.5, 0.5}, Vec3{0.6, 0.5, 0.5}});  // degenerate
  const ClosestTriangle tree(triangles);
  for (int i = 0; i < 50; ++i) {
    const Vec3 p{2 * u() - 0.5, 2 * u() - 0.5, 2 * u() - 0.5};
    double best = 1e300;
    for (const TrianglePoints& t : triangles) {
      // A dense sample bounds the distance from above, closely.
      best = std::min(best, ClosestTriangle({t}).distance2(p));
      for (int a = 0; a <= 10; ++a) {
        for (int b = 0; a + b <= 10; ++b) {
          const Vec3 q = t[0] + (a / 10.0) * (t[1] - t[0]) + (b / 10.0) * (t[2] - t[0]);
          ASSERT_LE(ClosestTriangle({t}).distance2(p), dot(p - q, p - q) + 1e-14);
        }
      }
    }
    EXPECT_EQ(tree.distance2(p), best);
  }
  EXPECT_NEAR(ClosestTriangle({{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}}}).distance2({0.2, 0.2, 3}), 9, 1e-12);
  EXPECT_NEAR(ClosestTriangle({{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}}}).distance2({2, 0, 0}), 1, 1e-12);
  EXPECT_EQ(ClosestTriangle({}).distance2({0, 0, 0}), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace tetune

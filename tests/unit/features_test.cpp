// SPDX-License-Identifier: Apache-2.0
// The degrees of freedom of sliding vertices: feature edges, corners, and lists that are not lists of features.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "boundary/classify.hpp"
#include "boundary/sliding/features.hpp"
#include "mesh/constrained_edges.hpp"
#include "meshes.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "work.hpp"

namespace tetune {
namespace {

Report classify(TetMesh mesh, double feature_angle = 45) {
  Options options;
  options.boundary = Boundary::slide;
  options.feature_angle = feature_angle;
  options.max_iterations = 0;
  options.threads = 1;
  return optimize(mesh, options);
}

void expect(const Report& r, std::int64_t fixed, std::int64_t curve, std::int64_t surface, std::int64_t free) {
  EXPECT_EQ(r.fixed_vertices, fixed);
  EXPECT_EQ(r.curve_vertices, curve);
  EXPECT_EQ(r.surface_vertices, surface);
  EXPECT_EQ(r.free_vertices, free);
  EXPECT_EQ(r.plane_vertices + r.line_vertices, 0);
}

/// The reference surface of a mesh without lists, and the degrees of freedom of its vertices.
struct Sliding {
  test::CpuMesh work;
  Surface<backend::Cpu> surface;
  ReferenceSurface<backend::Cpu> reference;
  std::vector<VertexDof> dof;

  explicit Sliding(const TetMesh& mesh, double feature_angle) : work(test::to_work(mesh)) {
    const backend::Cpu cpu(1);
    build_adjacency(cpu, work);
    test::lock_interfaces(cpu, work, mesh);
    const ListedTriangles listed{};
    backend::Cpu::Buffer<Listed> state;
    build_surface(cpu, work, listed, state, surface);
    const EdgeSet<backend::Cpu> none(cpu, {}, work.vertices());
    backend::Cpu::Buffer<std::uint8_t> frozen;
    frozen.upload(cpu, std::vector<std::uint8_t>(mesh.points.size(), kMovable));
    backend::Cpu::Buffer<VertexDof> buffer(cpu, work.vertices());
    build_reference(cpu, work, surface, none.ends.span(), none.view(), frozen.span(), feature_angle, buffer.span(),
                    reference);
    dof = buffer.download();
  }
};

Index id(int n, int i, int j, int k) { return static_cast<Index>((k * (n + 1) + j) * (n + 1) + i); }

/// A pyramid with its tip down, over a square whose triangle beside the diagonal (0, 1) is a cap with its vertex at
/// `cap`; vertex 2 is at `corner`.
TetMesh pyramid_with_cap(const Point3& cap, const Point3& corner) {
  TetMesh m;
  m.points = {{-1, 0, 0}, {1, 0, 0}, corner, {0, -1, 0}, cap, {0, 0, -2}};
  m.tets = {{0, 1, 2, 5}, {0, 4, 1, 5}, {0, 3, 4, 5}, {4, 3, 1, 5}};
  for (auto& t : m.tets) std::swap(t[0], t[1]);
  return test::with_tags(m);
}
/// Whether the edge between two vertices is one of the reference surface that is no feature.
bool is_smooth_edge(const Sliding& s, Index a, Index b) {
  const ReferenceView ref = s.reference.view();
  for (Size corner = 0; corner < 3 * ref.triangles.size(); ++corner) {
    const SurfaceTriangle& t = ref.triangles[corner / 3];
    const Index u = t.v[(corner + 1) % 3];
    const Index v = t.v[(corner + 2) % 3];
    if ((u == a && v == b) || (u == b && v == a)) return ref.across[corner] != kFeatureEdge;
  }
  ADD_FAILURE() << "no edge " << a << ' ' << b;
  return false;
}

TEST(Features, NoneAtACapWhoseNormalIsNoise) {
  // The cap is turned by 63 degrees against all its neighbors, which are coplanar.
  const Sliding s(pyramid_with_cap({0, -0.01, 0.02}, {0, 1, 0}), 50);
  EXPECT_TRUE(is_smooth_edge(s, 0, 1));
  EXPECT_TRUE(is_smooth_edge(s, 0, 4));
  EXPECT_TRUE(is_smooth_edge(s, 1, 4));
  EXPECT_EQ(s.dof[4], VertexDof::surface);
}
TEST(Features, BesideACapAreKept) {
  // The surface folds by 45 degrees at the diagonal, beside which the cap is coplanar with the other two triangles.
  const Sliding flat(pyramid_with_cap({0, -0.01, 0}, {0, 1, -1}), 40);
  EXPECT_FALSE(is_smooth_edge(flat, 0, 1));
  EXPECT_EQ(flat.dof[4], VertexDof::surface);
  // With a cap whose normal is noise, the fold is at its short edges.
  const Sliding noisy(pyramid_with_cap({0, -0.01, 0.02}, {0, 1, -1}), 40);
  EXPECT_TRUE(is_smooth_edge(noisy, 0, 1));
  EXPECT_FALSE(is_smooth_edge(noisy, 0, 4));
  EXPECT_FALSE(is_smooth_edge(noisy, 1, 4));
  EXPECT_EQ(noisy.dof[4], VertexDof::curve);
}
TEST(Features, ATriangleWithAShortEdgeIsNoCap) {
  // Two long strips of width 0.01 that fold by 90 degrees: thin triangles with normals that count.
  TetMesh m;
  m.points = {{0, 0, 0}, {1, 0, 0}, {0, 0.01, 0}, {1, 0.01, 0}, {0, 0, -0.01}, {1, 0, -0.01}};
  m.tets = {{0, 2, 1, 4}, {1, 2, 3, 5}, {1, 2, 5, 4}};
  const Sliding s(test::with_tags(m), 40);
  EXPECT_FALSE(is_smooth_edge(s, 0, 1));
  EXPECT_TRUE(is_smooth_edge(s, 1, 2));
}

TEST(Features, OfACube) {
  expect(classify(test::cube(4)), 8, 36, 54, 27);
  expect(classify(test::cube(4), 89), 8, 36, 54, 27);
  // The surface turns by 90 degrees at the edges of the cube.
  expect(classify(test::cube(4), 91), 0, 0, 98, 27);
  expect(classify(test::cube(4), 180), 0, 0, 98, 27);
}

TEST(Features, OfAPartMuchSmallerThanTheMeshAreTheSame) {
  TetMesh m = test::cube(4);
  const auto one = static_cast<Index>(m.points.size());
  const TetMesh large = m;
  for (Point3& p : m.points) p = {1e-45 * p[0], 1e-45 * p[1], 1e-45 * p[2]};
  for (const Point3& p : large.points) m.points.push_back({p[0] - 2, p[1], p[2]});
  for (auto tet : large.tets) {
    for (Index& v : tet) v += one;
    m.tets.push_back(tet);
  }
  expect(classify(test::with_tags(m)), 16, 72, 108, 54);
}

TEST(Features, OfATurnedAndStretchedCubeAreTheSame) {
  TetMesh m = test::cube(4);
  const double c = std::cos(0.7);
  const double s = std::sin(0.7);
  for (Point3& p : m.points) {
    p = {c * p[0] - s * p[1], s * p[0] + c * p[1], 3e5 * p[2]};
    p = {p[0], c * p[1] - s * p[2], s * p[1] + c * p[2]};
  }
  expect(classify(m), 8, 36, 54, 27);
}

TEST(Features, OfTwoMaterialsIncludeTheBorderOfTheInterface) {
  expect(classify(test::two_materials(4)), 8 + 4, 36 - 4 + 12, 54 - 12 + 9, 27 - 9);
  // The border of the interface is on three sheets, so it is a feature for any angle. It is closed; its four turns by
  // 90 degrees are within a feature angle of 180 degrees.
  expect(classify(test::two_materials(4), 180), 0, 16, 98 - 16 + 9, 27 - 9);
}

TEST(Features, LinesKeepTheirOrder) {
  const Sliding s(test::cube(4), 45);
  for (int i = 1; i < 4; ++i) {
    const auto line = s.reference.line.span()[id(4, i, 0, 0)];
    EXPECT_EQ(std::minmax(line.next[0], line.next[1]), std::minmax<Index>(id(4, i - 1, 0, 0), id(4, i + 1, 0, 0)));
  }
  EXPECT_EQ(s.reference.line.span()[id(4, 1, 1, 0)].next[0], -1);
}

TEST(Features, AdjacencyAcrossEdgesIsSymmetric) {
  for (const double angle : {45.0, 180.0}) {
    const Sliding s(test::two_materials(4, 0.1), angle);
    int features = 0;
    for (Size c = 0; c < s.reference.across.size(); ++c) {
      const Index other = s.reference.across.span()[c];
      if (other == kFeatureEdge) {
        ++features;
        continue;
      }
      EXPECT_EQ(s.reference.across.span()[other], c);
      const SurfaceTriangle t = s.reference.triangles.span()[c / 3];
      const SurfaceTriangle q = s.reference.triangles.span()[other / 3];
      EXPECT_EQ(std::minmax(t.v[(c + 1) % 3], t.v[(c + 2) % 3]),
                std::minmax(q.v[(other + 1) % 3], q.v[(other + 2) % 3]));
    }
    // 16 border edges with three triangles each; the edges of the cube, 12 times 4, with two.
    EXPECT_EQ(features, 3 * 16 + (angle < 90 ? 2 * 48 : 0));
  }
}

/// A prism of n sides around a center line, of the given number of layers; with `tip` it ends in an apex.
TetMesh prism(int n, int layers, bool tip) {
  TetMesh m;
  for (int l = 0; l <= layers; ++l) {
    m.points.push_back({0, 0, static_cast<double>(l)});
    const double r = tip ? 1 - static_cast<double>(l) / (layers + 1) : 1;
    for (int i = 0; i < n; ++i) {
      const double a = 2 * std::numbers::pi * i / n;
      m.points.push_back({r * std::cos(a), r * std::sin(a), static_cast<double>(l)});
    }
  }
  const auto at = [n](int l, int i) { return static_cast<Index>(l * (n + 1) + 1 + i % n); };
  const auto axis = [n](int l) { return static_cast<Index>(l * (n + 1)); };
  for (int l = 0; l < layers; ++l) {
    for (int i = 0; i < n; ++i) {
      // The wedge between two sides, with its columns in ascending order, so that neighbors have the same diagonals.
      std::array<std::pair<Index, Index>, 3> column{
          {{axis(l), axis(l + 1)}, {at(l, i), at(l + 1, i)}, {at(l, i + 1), at(l + 1, i + 1)}}};
      std::sort(column.begin(), column.end());
      m.tets.push_back({column[0].first, column[1].first, column[2].first, column[2].second});
      m.tets.push_back({column[0].first, column[1].first, column[1].second, column[2].second});
      m.tets.push_back({column[0].first, column[0].second, column[1].second, column[2].second});
    }
  }
  if (tip) {
    m.points.push_back({0, 0, layers + 1.0});
    for (int i = 0; i < n; ++i) {
      m.tets.push_back({axis(layers), at(layers, i), at(layers, i + 1), static_cast<Index>(m.points.size() - 1)});
    }
  }
  for (auto& t : m.tets) {
    const auto p = [&](std::size_t k) { return vec(m.points[static_cast<std::size_t>(t[k])]); };
    if (dot(cross(p(1) - p(0), p(2) - p(0)), p(3) - p(0)) < 0) std::swap(t[2], t[3]);
  }
  return test::with_tags(m);
}

TEST(Features, OfACylinderAreItsTwoCircles) {
  // 12 sides turn by 30 degrees each, and so do the circles at each vertex.
  const TetMesh m = prism(12, 3, false);
  expect(classify(m), 0, 2 * 12, 2 * 12 + 2, 2);
  // Below 30 degrees the edges between the sides are features too; they meet the circles in corners.
  expect(classify(m, 20), 2 * 12, 2 * 12, 2, 2);
  expect(classify(m, 180), 0, 0, 4 * 12 + 2, 2);
  // 6 sides turn by 60.
  expect(classify(prism(6, 3, false)), 2 * 6, 2 * 6, 2, 2);
}

TEST(Features, OfAConeAreItsCircleAndNotItsApex) {
  // The edges at the apex turn by less than the angle: no feature ends there. A list of corners may contain it.
  TetMesh m = prism(16, 3, true);
  expect(classify(m), 0, 16, 3 * 16 + 1 + 1, 3);
  m.corners = {static_cast<Index>(m.points.size() - 1)};
  expect(classify(m), 1, 16, 3 * 16 + 1, 3);
}

/// Two cubes of n^3 cells. Coincident vertices at p are merged if shared(p).
template <class IsShared>
TetMesh two_cubes(int n, const Point3& offset, const IsShared& shared) {
  TetMesh m = test::cube(n);
  const TetMesh other = m;
  std::vector<Index> number;
  for (const Point3& p : other.points) {
    const Point3 q{p[0] + offset[0], p[1] + offset[1], p[2] + offset[2]};
    const auto at = std::find(m.points.begin(), m.points.begin() + static_cast<std::ptrdiff_t>(other.points.size()), q);
    if (shared(q) && at != m.points.begin() + static_cast<std::ptrdiff_t>(other.points.size())) {
      number.push_back(static_cast<Index>(at - m.points.begin()));
    } else {
      number.push_back(static_cast<Index>(m.points.size()));
      m.points.push_back(q);
    }
  }
  for (auto t : other.tets) {
    for (Index& v : t) v = number[static_cast<std::size_t>(v)];
    m.tets.push_back(t);
  }
  m.tet_tags.clear();
  return test::with_tags(m);
}

TEST(Features, AVertexSharedByTwoCubesIsFixed) {
  const TetMesh m = two_cubes(2, {1, 1, 1}, [](const Point3&) { return true; });
  ASSERT_EQ(m.points.size(), 2U * 27 - 1);
  EXPECT_EQ(classify(m).fixed_vertices, 15);
  expect(classify(m, 180), 1, 0, 2 * 25, 2);
}

TEST(Features, VerticesOfAnEdgeSharedByTwoCubesSlideAlongIt) {
  const TetMesh m = two_cubes(4, {1, 1, 0}, [](const Point3&) { return true; });
  ASSERT_EQ(m.points.size(), 2U * 125 - 5);
  const Report r = classify(m, 180);
  // Its ends are ends of a line.
  expect(r, 2, 3, 2 * (98 - 5), 2 * 27);
  TetMesh after = m;
  Options options;
  options.boundary = Boundary::slide;
  options.feature_angle = 180;
  optimize(after, options);
  for (std::size_t v = 0; v < m.points.size(); ++v) {
    if (m.points[v][0] == 1 && m.points[v][1] == 1) {
      EXPECT_EQ(after.points[v][0], 1);
      EXPECT_EQ(after.points[v][1], 1);
    }
  }
}

TEST(Features, AVertexSharedByTwoSheetsIsFixed) {
  // Cubes that share the middle vertex of a face alone: two closed fans at one vertex.
  const TetMesh m = two_cubes(2, {1, 0, 0}, [](const Point3& p) { return p[1] == 0.5 && p[2] == 0.5; });
  ASSERT_EQ(m.points.size(), 2U * 27 - 1);
  expect(classify(m, 180), 1, 0, 2 * 25, 2);
}

/// Triangles of the face z = 0 of a cube of n^3 cells, tagged by their column.
template <class Tag>
TetMesh with_patches(int n, const Tag& tag) {
  TetMesh m = test::cube(n);
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      m.triangles.push_back({id(n, i, j, 0), id(n, i + 1, j, 0), id(n, i + 1, j + 1, 0)});
      m.triangles.push_back({id(n, i, j, 0), id(n, i, j + 1, 0), id(n, i + 1, j + 1, 0)});
      m.triangle_tags.insert(m.triangle_tags.end(), 2, tag(i, j));
    }
  }
  return m;
}

TEST(Features, BordersBetweenPatchesAreLines) {
  const TetMesh halves = with_patches(4, [](int i, int) { return i < 2 ? 5 : 6; });
  // With 180 degrees the boundary of the face is a line as well, between tags 5 or 6 and no tag; it meets the border
  // between the patches twice.
  expect(classify(halves), 8 + 2, 36 - 2 + 3, 54 - 3, 27);
  expect(classify(halves, 180), 2, 16 - 2 + 3, 98 - 16 - 3, 27);
  const TetMesh whole = with_patches(4, [](int, int) { return 5; });
  expect(classify(whole), 8, 36, 54, 27);
  expect(classify(whole, 180), 0, 16, 98 - 16, 27);
}

TEST(Features, RidgesAreLinesWhateverTheAngle) {
  TetMesh m = test::cube(4);
  // A closed line around the inside of the face z = 0.
  const std::array<std::array<int, 2>, 8> ring{{{1, 1}, {2, 1}, {3, 1}, {3, 2}, {3, 3}, {2, 3}, {1, 3}, {1, 2}}};
  for (std::size_t k = 0; k < 8; ++k) {
    const auto& a = ring[k];
    const auto& b = ring[(k + 1) % 8];
    m.edges.push_back({id(4, a[0], a[1], 0), id(4, b[0], b[1], 0)});
    m.ridges.push_back(static_cast<Index>(k));
  }
  m.edge_tags.assign(8, 0);
  expect(classify(m), 8 + 4, 36 + 4, 54 - 8, 27);  // it turns sharply at four corners
  expect(classify(m, 180), 0, 8, 98 - 8, 27);
  m.required_edges = {0};
  expect(classify(m, 180), 2, 6, 98 - 8, 27);
}

TEST(Features, VerticesOfATaggedLineInsideSlideAlongIt) {
  TetMesh m = test::cube(4);
  for (int i = 1; i < 3; ++i) m.edges.push_back({id(4, i, 2, 2), id(4, i + 1, 2, 2)});
  m.edge_tags = {7, 7};
  expect(classify(m), 8 + 2, 36 + 1, 54, 27 - 3);
}

TEST(Lists, OfEdgesThatMeetInFewPlacesAreFeatures) {
  const auto are_lines = [](const std::vector<Index>& ends, Size first, const std::vector<VertexDof>& dof) {
    return are_feature_lines(span_of(ends), first, span_of(dof));
  };
  const std::vector<VertexDof> dof(1000, VertexDof::surface);
  const auto star = [](Index center) {
    std::vector<Index> ends;
    for (Index k = 1; k <= 3; ++k) {
      ends.push_back(center);
      ends.push_back(center + k);
    }
    return ends;
  };
  const auto stars = [&](int count) {
    std::vector<Index> ends;
    for (int i = 0; i < count; ++i) {
      const std::vector<Index> one = star(static_cast<Index>(4 * i));
      ends.insert(ends.end(), one.begin(), one.end());
    }
    return ends;
  };
  EXPECT_TRUE(are_lines({}, 0, dof));
  EXPECT_TRUE(are_lines(stars(50), 0, dof));  // one in twenty
  EXPECT_FALSE(are_lines(stars(51), 0, dof));
  // Ten junctions are accepted in any mesh.
  const std::vector<VertexDof> small(44, VertexDof::surface);
  EXPECT_TRUE(are_lines(stars(10), 0, small));
  EXPECT_FALSE(are_lines(stars(11), 0, small));
  // Neither the first entries nor junctions that are fixed anyway count.
  EXPECT_TRUE(are_lines(stars(51), 6, dof));
  std::vector<VertexDof> corners = dof;
  for (std::size_t i = 0; i < 4 * 51; i += 4) corners[i] = VertexDof::fixed;
  EXPECT_TRUE(are_lines(stars(51), 0, corners));
}

/// All edges of the surface, tagged, as TetGen lists them.
TetMesh all_edges_tagged(int n) {
  TetMesh m = test::cube(n);
  const Sliding s(m, 45);
  for (Size t = 0; t < s.reference.triangles.size(); ++t) {
    const SurfaceTriangle f = s.reference.triangles.span()[t];
    for (int k = 0; k < 3; ++k) m.edges.push_back({f.v[k], f.v[(k + 1) % 3]});
  }
  m.edge_tags.assign(m.edges.size(), 1);
  return m;
}

TEST(Lists, OfAllEdgesAreNoFeatures) {
  TetMesh m = all_edges_tagged(4);
  const Report r = classify(m);
  expect(r, 8, 36, 54, 27);
  EXPECT_EQ(r.edges_not_held, 96 * 3);  // each once: 192 triangles
  // They remain edges of the mesh.
  TetMesh after = m;
  Options options;
  options.boundary = Boundary::slide;
  optimize(after, options);
  EXPECT_EQ(after.edges, m.edges);
  // Ridges among them remain features: here on the face z = 0.
  const std::array<std::array<Index, 2>, 2> ridge{{{id(4, 1, 2, 0), id(4, 2, 2, 0)}, {id(4, 2, 2, 0), id(4, 3, 2, 0)}}};
  for (const auto& e : ridge) {
    m.edges.push_back(e);
    m.edge_tags.push_back(0);
    m.ridges.push_back(static_cast<Index>(m.edges.size() - 1));
  }
  expect(classify(m), 8 + 2, 36 + 1, 54 - 3, 27);
  // The same decision for Boundary::preserve.
  Options preserve;
  preserve.max_iterations = 0;
  TetMesh again = all_edges_tagged(4);
  EXPECT_EQ(optimize(again, preserve).plane_vertices, 54);
}

TEST(Lists, OfFewCornersAreCornersAndOfManyAreNot) {
  TetMesh m = test::cube(6);
  for (int i = 1; i <= 5; ++i) m.corners.push_back(id(6, i, 3, 0));
  Report r = classify(m);
  expect(r, 8 + 5, 60, 150 - 5, 125);
  EXPECT_EQ(r.corners_not_held, 0);
  m.corners.clear();
  for (int i = 1; i <= 5; ++i) {
    for (int j = 1; j <= 5; ++j) m.corners.push_back(id(6, i, j, 0));
  }
  m.corners.push_back(0);
  r = classify(m);
  expect(r, 8, 60, 150, 125);
  EXPECT_EQ(r.corners_not_held, 25);
  // Required vertices are fixed, whatever their number.
  m.required_vertices = m.corners;
  expect(classify(m), 8 + 25, 60, 150 - 25, 125);
}

TEST(Frozen, RegionsPatchesAndVerticesOfTheOptionsDoNotMove) {
  TetMesh m = test::two_materials(4);
  Options options;
  options.boundary = Boundary::slide;
  options.max_iterations = 0;
  options.frozen_regions = {2};
  TetMesh copy = m;
  // 3 of 5 layers of 25 vertices.
  EXPECT_EQ(optimize(copy, options).fixed_vertices, 75 + 4);
  options.frozen_regions = {3};
  EXPECT_THROW(optimize(copy, options), OptionError);
  options.frozen_regions.clear();
  options.frozen_patches = {5};
  EXPECT_THROW(optimize(copy, options), OptionError);
  TetMesh patched = with_patches(4, [](int i, int) { return i < 2 ? 5 : 6; });
  EXPECT_EQ(optimize(patched, options).fixed_vertices, 15 + 4 + 2);
  options.frozen_patches.clear();
  options.frozen_vertices.assign(m.points.size() - 1, 0);
  EXPECT_THROW(optimize(copy, options), OptionError);
  options.frozen_vertices.assign(m.points.size(), 1);
  EXPECT_EQ(optimize(copy, options).fixed_vertices, 125);
}

TEST(Frozen, APatchInsideARegionRemainsWithoutOpenBoundaries) {
  TetMesh m = test::cube(4);
  m.triangles = {{id(4, 1, 2, 1), id(4, 2, 2, 1), id(4, 2, 2, 2)}, {id(4, 2, 1, 1), id(4, 2, 1, 2), id(4, 3, 1, 2)}};
  m.triangle_tags = {3, 4};
  Options options;
  options.max_iterations = 0;
  options.open_boundaries = false;
  TetMesh dropped = m;
  Report r = optimize(dropped, options);
  EXPECT_EQ(r.triangles_dropped, 2);
  EXPECT_EQ(r.free_vertices, 27);
  options.frozen_patches = {3};
  TetMesh kept = m;
  r = optimize(kept, options);
  EXPECT_EQ(r.triangles_dropped, 1);
  EXPECT_EQ(r.free_vertices, 24);
  EXPECT_EQ(kept.triangles, (std::vector<std::array<Index, 3>>{m.triangles[0]}));
  options.frozen_patches.clear();
  options.open_boundaries = true;
  TetMesh all = m;
  r = optimize(all, options);
  EXPECT_EQ(r.triangles_dropped, 0);
  EXPECT_EQ(r.free_vertices, 21);
}

}  // namespace
}  // namespace tetune

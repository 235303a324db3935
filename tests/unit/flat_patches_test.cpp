// SPDX-License-Identifier: Apache-2.0
// Patches of the reference surface that lie in a plane, and where their vertices may go.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "boundary/sliding/flat_patches.hpp"
#include "support/curved.hpp"
#include "support/meshes.hpp"
#include "support/sliding_dofs.hpp"

namespace tetune {
namespace {

using test::classify_sliding, test::cube_vertex, test::Sliding;

/// The vertices of a mesh after those of flat patches got planes and lines. Vertices are numbered as in the mesh.
struct Restricted {
  std::vector<VertexDof> dof;
  std::vector<Vec3> axis;
  Index flat_triangles = 0;

  explicit Restricted(const TetMesh& mesh, double tolerance = 1e-9, double feature_angle = 45) {
    const Sliding sliding(mesh, feature_angle);
    const ReferenceSurfaceOnHost reference = sliding.reference.download();
    const FlatPatches flat(reference, tolerance);
    dof = sliding.dof;
    axis.assign(dof.size(), Vec3{0, 0, 0});
    flat.restrict_vertices(reference, dof, axis);
    for (Index t = 0; t < std::ssize(reference.triangles); ++t) flat_triangles += flat.contains(t) ? 1 : 0;
  }
  std::ptrdiff_t count(VertexDof one) const { return std::count(dof.begin(), dof.end(), one); }
};

TEST(FlatPatches, OfACubeHavePlanesLinesAndCorners) {
  const Restricted r(test::cube(3));
  EXPECT_EQ(r.flat_triangles, 6 * 9 * 2);
  EXPECT_EQ(r.count(VertexDof::fixed), 8);
  EXPECT_EQ(r.count(VertexDof::line), 12 * 2);
  EXPECT_EQ(r.count(VertexDof::plane), 6 * 4);
  EXPECT_EQ(r.count(VertexDof::free), 8);
  const Vec3 of_side = span_of(r.axis)[cube_vertex(3, 1, 1, 0)];
  EXPECT_EQ(std::abs(of_side.z), 1);
  EXPECT_EQ(of_side.x, 0);
  EXPECT_EQ(of_side.y, 0);
  const Vec3 of_edge = span_of(r.axis)[cube_vertex(3, 0, 0, 2)];
  EXPECT_NEAR(std::abs(of_edge.z), 1, 1e-15);
}

TEST(FlatPatches, BesideACurvedPatchKeepItsLines) {
  TetMesh mesh = test::cube(4);
  for (Point3& p : mesh.points) p[2] *= 1 + 0.1 * p[0] * (1 - p[0]);
  const Restricted r(mesh);
  EXPECT_EQ(r.flat_triangles, 5 * 16 * 2);
  // Inside the upper side vertices slide over it; at its rim along curves, straight ones too, as its triangles change.
  EXPECT_EQ(r.count(VertexDof::surface), 9);
  EXPECT_EQ(r.count(VertexDof::curve), 4 * 3);
  EXPECT_EQ(r.count(VertexDof::line), 8 * 3);
  EXPECT_EQ(r.count(VertexDof::plane), 5 * 9);
}

TEST(FlatPatches, AreFlatToATolerance) {
  TetMesh mesh = test::cube(3);
  mesh.points[static_cast<std::size_t>(cube_vertex(3, 1, 1, 0))][2] = -1e-4;
  EXPECT_EQ(Restricted(mesh, 2e-4).flat_triangles, 6 * 18);
  EXPECT_EQ(Restricted(mesh, 0.5e-4).flat_triangles, 5 * 18);
}

TEST(FlatPatches, MeetInterfacesInLines) {
  const Restricted r(test::two_materials(4));
  EXPECT_GT(r.flat_triangles, 6 * 32);
  EXPECT_EQ(r.count(VertexDof::surface) + r.count(VertexDof::curve), 0);
  EXPECT_EQ(r.count(VertexDof::line), 8 * 3 + 4 * 3 + 4 * 2);
}

TEST(FlatPatches, OfARoundShapeAreNone) {
  const Restricted r(test::ball(4));
  EXPECT_EQ(r.flat_triangles, 0);
  EXPECT_EQ(r.count(VertexDof::plane) + r.count(VertexDof::line), 0);
}

TEST(FlatPatches, OfOnePlaneHaveNoLineInCommon) {
  // The borders between tags.
  const Report r = classify_sliding(test::with_patches(test::cube(4), 0.5), 45, 0.01);
  EXPECT_GT(r.curve_vertices, 0);
  EXPECT_GT(r.line_vertices, 0);
  EXPECT_EQ(r.surface_vertices, 0);
}

TEST(FlatPatches, AreUsedWithABound) {
  EXPECT_EQ(classify_sliding(test::cube(3), 45, 0).plane_vertices, 0);
  EXPECT_EQ(classify_sliding(test::cube(3), 45, 0.01).plane_vertices, 24);
}

}  // namespace
}  // namespace tetune

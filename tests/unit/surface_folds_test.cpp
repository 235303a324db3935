// SPDX-License-Identifier: Apache-2.0
#include "phases/untangle/surface_folds.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "driver/import_mesh.hpp"
#include "mesh/connect.hpp"
#include "support/meshes.hpp"
#include "support/work.hpp"

namespace tetune {
namespace {

constexpr int kCells = 4;
/// A vertex of the lattice with four cells: in the top face, one cell from the edge x = 0.
constexpr std::size_t kInTop = (4 * 5 + 2) * 5 + 1;

struct FoldedSurface : testing::Test {
  TetMesh mesh = test::cube(kCells);
  std::vector<VertexDof> dofs;

  FoldedSurface() {
    dofs.assign(mesh.points.size(), VertexDof::fixed);
    dofs[kInTop] = VertexDof::plane;
  }
  HostMesh host() const {
    const backend::Cpu cpu(1);
    test::CpuMesh work = test::to_work(mesh);
    build_adjacency(cpu, work);
    return HostMesh(work);
  }
};

TEST_F(FoldedSurface, AVertexBeyondTheEdgeOfItsPlaneFoldsTheSurface) {
  ASSERT_EQ(mesh.points[kInTop], (Point3{0.25, 0.5, 1}));
  const std::vector<std::uint8_t> before = folded_vertices(host(), dofs);
  EXPECT_EQ(std::count(before.begin(), before.end(), 1), 0);
  EXPECT_TRUE(newly_folded(host(), dofs, before).empty());

  mesh.points[kInTop][0] = -0.1;
  const std::vector<std::uint8_t> after = folded_vertices(host(), dofs);
  EXPECT_EQ(std::count(after.begin(), after.end(), 1), 1);
  EXPECT_EQ(after[kInTop], 1);
  const std::vector<Index> slots = newly_folded(host(), dofs, before);
  EXPECT_FALSE(slots.empty());
  for (const Index slot : slots) {
    const auto& tet = mesh.tets[static_cast<std::size_t>(slot)];
    EXPECT_NE(std::find(tet.begin(), tet.end(), static_cast<Index>(kInTop)), tet.end());
  }
  // A fold of the input is not reported.
  EXPECT_TRUE(newly_folded(host(), dofs, after).empty());
}

/// One of the middle of the edge x = 0 of the top face. Its faces are those of two planes.
TEST_F(FoldedSurface, AVertexBeyondTheNextOneOnItsLineFoldsTheSurface) {
  constexpr std::size_t kOnEdge = (4 * 5 + 2) * 5;
  ASSERT_EQ(mesh.points[kOnEdge], (Point3{0, 0.5, 1}));
  dofs.assign(mesh.points.size(), VertexDof::fixed);
  dofs[kOnEdge] = VertexDof::line;
  const std::vector<std::uint8_t> before = folded_vertices(host(), dofs);
  EXPECT_EQ(std::count(before.begin(), before.end(), 1), 0);
  mesh.points[kOnEdge][1] = 0.7;
  EXPECT_TRUE(newly_folded(host(), dofs, before).empty()) << "before the next vertex";
  mesh.points[kOnEdge][1] = 0.8;
  EXPECT_FALSE(newly_folded(host(), dofs, before).empty());
}

TEST_F(FoldedSurface, FixedVerticesAreNotChecked) {
  dofs[kInTop] = VertexDof::fixed;
  mesh.points[kInTop][0] = -0.1;
  const std::vector<std::uint8_t> folded = folded_vertices(host(), dofs);
  EXPECT_EQ(std::count(folded.begin(), folded.end(), 1), 0);
}

/// The number for which a position is nearest to a point.
template <class Position>
Index nearest(Size count, const Vec3& to, const Position& position) {
  Index best = 0;
  for (Index i = 1; i < count; ++i) {
    if (norm(position(i) - to) < norm(position(best) - to)) best = i;
  }
  return best;
}

/// A vertex of a curved surface, in the middle of the top, is moved over it.
TEST(SlidingVertices, AFaceThatIsTurnedOverIsFound) {
  const auto height = [](double x, double y) { return 1 + 0.3 * (x * (1 - x) + y * (1 - y)); };
  TetMesh mesh = test::cube(6);
  for (Point3& p : mesh.points) p[2] *= height(p[0], p[1]);
  Options options;
  options.boundary = Boundary::slide;
  const backend::Cpu cpu(1);
  WorkingSet<backend::Cpu> work;
  Report report;
  work.scale = 1;
  import_mesh(cpu, ImportInput{mesh, options}, work, report);
  const std::vector<VertexDof> dofs = work.dofs.dof.download();
  const ReferenceView surface = work.dofs.reference.view();
  const Index v =
      nearest(std::ssize(mesh.points), {0.5, 0.5, height(0.5, 0.5)}, [&](Index i) { return surface.point(i); });
  ASSERT_EQ(dofs[to_size_t(v)], VertexDof::surface);
  const std::vector<std::uint8_t> before = folded_vertices(HostMesh(work.mesh), dofs, SlidingVertices(work.dofs));
  EXPECT_EQ(std::count(before.begin(), before.end(), 1), 0);

  const auto folded_at = [&](double x) {
    const Index triangle =
        nearest(surface.triangles.size(), {x, 0.5, height(x, 0.5)}, [&](Index t) { return surface.centroid(t); });
    const Vec3 p = surface.centroid(triangle);
    work.mesh.points.span()[v] = point(p);
    work.dofs.surface_point.span()[v] = {SurfacePointKind::triangle, triangle};
    return newly_folded(HostMesh(work.mesh), dofs, before, SlidingVertices(work.dofs)).size();
  };
  EXPECT_EQ(folded_at(0.55), 0U);
  EXPECT_GT(folded_at(0.8), 0U);
}

}  // namespace
}  // namespace tetune

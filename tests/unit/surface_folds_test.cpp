// SPDX-License-Identifier: Apache-2.0
#include "phases/untangle/surface_folds.hpp"

#include <gtest/gtest.h>

#include <algorithm>

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

}  // namespace
}  // namespace tetune

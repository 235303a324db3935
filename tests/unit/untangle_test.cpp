// SPDX-License-Identifier: Apache-2.0
#include "driver/untangle.inl"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/connect.inl"
#include "meshes.hpp"
#include "work.hpp"

namespace tetune {
namespace {

constexpr int kCells = 4;
/// Of the lattice with four cells: in the top face, one cell from the rim x = 0; that rim's own is one less.
constexpr std::size_t kInTop = (4 * 5 + 2) * 5 + 1;

struct FoldedSurface : testing::Test {
  TetMesh mesh = test::cube(kCells);
  std::vector<Mobility> kind;

  FoldedSurface() {
    kind.assign(mesh.points.size(), Mobility::fixed);
    kind[kInTop] = Mobility::plane;
  }
  untangle_detail::HostMesh host() const {
    const par::Cpu cpu(1);
    test::CpuMesh work = test::to_work(mesh);
    build_adjacency(cpu, work);
    return untangle_detail::HostMesh(work);
  }
};

TEST_F(FoldedSurface, AVertexBeyondTheRimOfItsPlaneFoldsIt) {
  ASSERT_EQ(mesh.points[kInTop], (Point3{0.25, 0.5, 1}));
  const std::vector<std::uint8_t> before = untangle_detail::folded_vertices(host(), kind);
  EXPECT_EQ(std::count(before.begin(), before.end(), 1), 0);
  EXPECT_TRUE(untangle_detail::newly_folded(host(), kind, before).empty());

  mesh.points[kInTop][0] = -0.1;
  const std::vector<std::uint8_t> after = untangle_detail::folded_vertices(host(), kind);
  EXPECT_EQ(std::count(after.begin(), after.end(), 1), 1);
  EXPECT_EQ(after[kInTop], 1);
  const std::vector<Index> slots = untangle_detail::newly_folded(host(), kind, before);
  EXPECT_FALSE(slots.empty());
  for (const Index slot : slots) {
    const auto& tet = mesh.tets[static_cast<std::size_t>(slot)];
    EXPECT_NE(std::find(tet.begin(), tet.end(), static_cast<Index>(kInTop)), tet.end());
  }
  // What was so before is the caller's.
  EXPECT_TRUE(untangle_detail::newly_folded(host(), kind, after).empty());
}

TEST_F(FoldedSurface, OnlyVerticesThatKeepToAPlaneAreAsked) {
  kind[kInTop] = Mobility::fixed;
  mesh.points[kInTop][0] = -0.1;
  const std::vector<std::uint8_t> folded = untangle_detail::folded_vertices(host(), kind);
  EXPECT_EQ(std::count(folded.begin(), folded.end(), 1), 0);
}

}  // namespace
}  // namespace tetune

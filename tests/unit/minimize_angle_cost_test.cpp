// SPDX-License-Identifier: Apache-2.0
// Vertices moved for larger angles.
#include <gtest/gtest.h>

#include "relocation/minimize_angle_cost.hpp"
#include "relocation/rings.hpp"
#include "retriangulate_fixture.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

TEST(MinimizeAngleCost, MovesFlaggedVerticesAloneAndNoAngleBecomesSmaller) {
  TetMesh m = test::cube(5, 0.2);
  test::RetriangulationWork work(m);
  const backend::Cpu cpu(2);
  Rings<backend::Cpu> rings;
  build_rings(cpu, work.mesh, rings);
  Coloring<backend::Cpu> coloring;
  color_vertices(cpu, rings.view(), work.dofs.dof.span(), coloring);
  std::vector<std::uint8_t> flags(m.points.size(), 0);
  for (std::size_t v = 0; v < flags.size(); v += 2) flags[v] = 1;
  backend::Cpu::Buffer<std::uint8_t> buffer;
  buffer.upload(cpu, flags);
  const Size moved = minimize_angle_cost(cpu, work.mesh, work.criterion, {rings.view(), coloring, work.dofs},
                                         Span<const std::uint8_t>(buffer.span()), 0.5)
                         .get()
                         .value;
  const TetMesh after = test::from_work(work.mesh, m);
  EXPECT_TRUE(validate(after).ok());
  EXPECT_GE(quality(after).dihedral_min, quality(m).dihedral_min);
  EXPECT_GT(quality(after).dihedral_1, quality(m).dihedral_1 + 1);
  Size changed = 0;
  for (std::size_t v = 0; v < flags.size(); ++v) {
    if (after.points[v] == m.points[v]) continue;
    ++changed;
    EXPECT_EQ(flags[v], 1);
    EXPECT_EQ(work.dofs.dof.span()[static_cast<Size>(v)], VertexDof::free);
  }
  EXPECT_EQ(changed, moved);
  EXPECT_GT(moved, 10);
}

}  // namespace
}  // namespace tetune

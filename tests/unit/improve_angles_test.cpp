// SPDX-License-Identifier: Apache-2.0
// The rounds that follow where many tetrahedra have about the largest cost.
#include "phases/improve_angles.hpp"

#include <gtest/gtest.h>

#include "driver/import_mesh.inl"
#include "meshes.hpp"

namespace tetune {
namespace {

using backend::Cpu;

/// Whether a mesh has a crowd under Effort::best.
bool has_crowd(const TetMesh& mesh) {
  Options options;
  options.effort = Effort::best;
  const Cpu backend(1);
  WorkingSet<Cpu> work;
  Report report;
  import_mesh(backend, mesh, options, nullptr, true, work, report);
  PhaseTimer timer(report);
  const Context context;
  Optimizer<Cpu> optimizer(backend, work, options, context, report, timer, PhaseTimer::SteadyClock::now());
  optimizer.sum_energy(kShapeObjective);
  return improve_angles_detail::has_crowd(optimizer);
}

/// A lattice of n^3 cubes whose height is scaled: its smallest angles are all equal.
TetMesh flattened(int n, double scale) {
  TetMesh mesh = test::cube(n);
  for (Point3& p : mesh.points) p[2] *= scale;
  return mesh;
}

TEST(ImproveAngles, ManyEquallyBadElementsAreACrowd) { EXPECT_TRUE(has_crowd(flattened(4, 0.5))); }

TEST(ImproveAngles, ElementsThatReachTheGoalAreNoCrowd) { EXPECT_FALSE(has_crowd(flattened(4, 0.95))); }

TEST(ImproveAngles, FewerElementsAreNoCrowd) {
  // 48 tetrahedra in all.
  EXPECT_FALSE(has_crowd(flattened(2, 0.5)));
}

TEST(ImproveAngles, ElementsNearAWorseOneAreNoCrowd) {
  TetMesh mesh = flattened(4, 0.5);
  // The vertex in the middle, nearer to the layer below: some tetrahedra there become much flatter.
  for (Point3& p : mesh.points) {
    if (p[0] == 0.5 && p[1] == 0.5 && p[2] == 0.25) p[2] -= 0.08;
  }
  EXPECT_FALSE(has_crowd(mesh));
}

}  // namespace
}  // namespace tetune

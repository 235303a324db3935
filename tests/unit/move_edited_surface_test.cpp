// SPDX-License-Identifier: Apache-2.0
#include "operators/stars/move_edited_surface.hpp"

#include <gtest/gtest.h>

#include "backend/cpu.hpp"
#include "driver/import_mesh.hpp"
#include "support/curved.hpp"

namespace tetune {
namespace {

using backend::Cpu;

/// A mesh whose surface is edited within a bound, and a vertex of it.
class Edited {
 public:
  Edited(const TetMesh& mesh, double max_deviation) {
    Options options;
    options.effort = Effort::best;
    options.boundary = Boundary::slide;
    options.max_deviation = max_deviation;
    Report report;
    import_mesh(cpu_, ImportInput{mesh, options}, work, report);
    while (work.dofs.dof.span()[vertex] != VertexDof::surface) ++vertex;
    list_corners(cpu_, work.mesh, work.boundary);
    for (Size c = corners().begin(vertex); c < corners().end(vertex); ++c) around.push_back(corners().items[c] / 3);
  }
  BoundaryTriangle& triangle(Size t) { return work.boundary.triangles.span()[t]; }
  /// Moves the vertex in the mesh, by a part of the way to another one of a triangle.
  void drift(double part) {
    const BoundaryTriangle& t = triangle(around.front());
    const Index other = t.v[0] == vertex ? t.v[1] : t.v[0];
    const Vec3 x = position();
    work.mesh.points.span()[vertex] = point(x + part * (vec(work.mesh.points.span()[other]) - x));
  }
  /// The number of vertices of the edited surface that move.
  Size move() {
    Coloring<Cpu> coloring;
    coloring.vertices.upload(cpu_, {vertex});
    coloring.first = {0, 1};
    return move_edited_surface(cpu_, work.mesh, work.dofs, work.boundary, coloring).get().value;
  }
  Vec3 position() { return vec(work.mesh.points.span()[vertex]); }
  double distance() { return norm(position() - vec(work.dofs.checked.edited_points.span()[vertex])); }
  std::uint8_t& is_edited(Index v) { return work.dofs.checked.is_edited.span()[v]; }

  WorkingSet<Cpu> work;
  Index vertex = 0;
  std::vector<Size> around;  ///< the triangles at the vertex

 private:
  CsrView corners() { return work.boundary.vertex2corner.view(); }
  Cpu cpu_{1};
};

TEST(MoveEditedSurface, CostsNothingInAPlane) {
  Edited edited(test::cube(3), 0.1);
  edited.drift(0.4);
  EXPECT_EQ(edited.move(), 0);  // its triangles have not changed
  edited.is_edited(edited.vertex) = 1;
  EXPECT_EQ(edited.move(), 1);
  EXPECT_EQ(edited.distance(), 0);
  for (const Size t : edited.around) {
    EXPECT_LT(edited.triangle(t).deviation, 1e-15);
    for (const Index v : edited.triangle(t).v) EXPECT_EQ(edited.is_edited(v), 1);
  }
  EXPECT_EQ(edited.move(), 0);  // it has not drifted
  edited.drift(0.01);
  EXPECT_EQ(edited.move(), 0);  // by less than half of what is allowed
}

TEST(MoveEditedSurface, AddsToTheDeviationOfACurvedSurface) {
  Edited edited(test::ball(4), 0.2);
  edited.is_edited(edited.vertex) = 1;
  edited.triangle(edited.around.front()).deviation = 1e-3;
  edited.drift(0.1);
  EXPECT_EQ(edited.move(), 1);
  EXPECT_EQ(edited.distance(), 0);
  for (const Size t : edited.around) {
    EXPECT_GT(edited.triangle(t).deviation, 1e-3);
    EXPECT_LE(edited.triangle(t).deviation, edited.work.boundary.max_bend);
  }
}

TEST(MoveEditedSurface, StaysWhereItWouldBendTooFar) {
  Edited edited(test::ball(4), 1e-3);
  edited.is_edited(edited.vertex) = 1;
  edited.drift(0.4);
  EXPECT_EQ(edited.move(), 0);
  EXPECT_GT(edited.distance(), 0);
  for (const Size t : edited.around) EXPECT_EQ(edited.triangle(t).deviation, 0);
}

}  // namespace
}  // namespace tetune

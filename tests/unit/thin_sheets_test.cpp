// SPDX-License-Identifier: Apache-2.0
// Curved sheets that are thin for their triangles, over which vertices do not slide.
#include <gtest/gtest.h>

#include <cmath>

#include "support/curved.hpp"
#include "support/meshes.hpp"
#include "support/sliding_dofs.hpp"
#include "tetune/quality.hpp"

namespace tetune {
namespace {

using test::classify_sliding;

constexpr int kSize = 6;

/// A sheet of kSize by kSize squares of one layer, bent along x so that neighbors are 1/kSize^2 times `bend` off the
/// plane of a triangle, and with two rims that are as much off their chords in the plane.
TetMesh sheet(double thickness, double bend, double bend_of_rim = 0) {
  TetMesh m = test::cube(kSize);
  std::vector<std::array<Index, 4>> layer;
  for (const auto& tet : m.tets) {
    const auto is_low = [&m](Index v) { return span_of(m.points)[v][2] < 1.5 / kSize; };
    if (std::all_of(tet.begin(), tet.end(), is_low)) layer.push_back(tet);
  }
  m.tets = layer;
  m.tet_tags.resize(layer.size());
  for (Point3& p : m.points) {
    p[2] = p[2] * kSize * thickness + bend * p[0] * p[0];
    p[1] += bend_of_rim * p[0] * p[0];
  }
  return m;
}

TEST(ThinSheets, BentOnesAreHeld) {
  constexpr double kHeight = 0.6 / (kSize * kSize);
  EXPECT_EQ(classify_sliding(sheet(kHeight, 0)).thin_vertices, 0);
  EXPECT_EQ(classify_sliding(sheet(kHeight, 0.3)).thin_vertices, 0);
  const Report thin = classify_sliding(sheet(0.1 * kHeight, 0.3));
  // All but the four corners of either side, and the ends of the lines in between, slide otherwise.
  const Report free = classify_sliding(sheet(0.1 * kHeight, 0.3), 45, 1.0);
  EXPECT_EQ(free.thin_vertices, 0);
  EXPECT_EQ(thin.thin_vertices, free.surface_vertices + free.curve_vertices + free.plane_vertices + free.line_vertices);
  EXPECT_EQ(thin.surface_vertices + thin.curve_vertices, 0);
}

TEST(ThinSheets, VerticesOfBentRimsAreHeld) {
  constexpr double kHeight = 0.6 / (kSize * kSize);
  EXPECT_EQ(classify_sliding(sheet(kHeight, 0, 0.3)).thin_vertices, 0);
  // The inner vertices of two rims on either side.
  EXPECT_EQ(classify_sliding(sheet(0.1 * kHeight, 0, 0.3)).thin_vertices, 4 * (kSize - 1));
}

TEST(ThinSheets, WedgesAreNone) {
  TetMesh m = test::cube(kSize);
  for (Point3& p : m.points) p[2] = p[2] * 0.5 * p[0] + 0.5 * p[1] * p[1] + 0.01 * p[2];
  EXPECT_EQ(classify_sliding(m).thin_vertices, 0);
}

TEST(ThinSheets, KeepTheirThickness) {
  for (const Effort effort : {Effort::standard, Effort::best}) {
    const TetMesh before = sheet(0.001, 0.5);
    TetMesh after = before;
    Options options;
    options.boundary = Boundary::slide;
    options.effort = effort;
    optimize(after, options);
    EXPECT_NEAR(quality(after).volume / quality(before).volume, 1, 1e-6);
  }
}

}  // namespace
}  // namespace tetune

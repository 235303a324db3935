// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <ostream>
#include <vector>

#include "math/closest_triangle.hpp"
#include "support/curved.hpp"
#include "tetune/options.hpp"

/// Curved meshes that slide, and plain measures of their surfaces.
namespace tetune::test {

inline constexpr int kShapes = 5;
inline TetMesh curved(int shape, std::uint32_t seed) {
  switch (shape) {
    case 0:
      return test::ball(7, 0.15, seed);
    case 1:
      return test::waved(test::cube(6, 0.15, seed), seed);
    case 2:
      return test::waved(test::two_materials(6, 0.15), seed);
    case 3:
      return test::with_patches(test::ball(6, 0.15, seed), 0.1);
    default:
      return test::with_patches(test::waved(test::two_materials(6, 0.15), seed), 0.4);
  }
}

struct SlideCase {
  int shape;
  std::uint32_t seed;
  Relocation relocation;
  Energy energy;
  double feature_angle;
};
inline void PrintTo(const SlideCase& c, std::ostream* out) { *out << "shape " << c.shape << " seed " << c.seed; }

inline Options options_of(const SlideCase& c) {
  Options options;
  options.boundary = Boundary::slide;
  options.relocation = c.relocation;
  options.energy = c.energy;
  options.feature_angle = c.feature_angle;
  options.boundary_flips = c.seed == 2;
  options.max_iterations = 15;
  return options;
}

inline double mean_edge(const std::vector<TrianglePoints>& triangles) {
  double sum = 0;
  for (const TrianglePoints& t : triangles) sum += norm(t[1] - t[0]) + norm(t[2] - t[1]) + norm(t[0] - t[2]);
  return sum / (3 * static_cast<double>(triangles.size()));
}

inline double distance_to(const std::vector<TrianglePoints>& triangles, const std::vector<Vec3>& points) {
  const ClosestTriangle tree(triangles);
  double most = 0;
  for (const Vec3& p : points) most = std::max(most, tree.distance2(p));
  return std::sqrt(most);
}

}  // namespace tetune::test

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "support/meshes.hpp"

namespace tetune::test {

/// A cube of `low`, `low` + `side` whose opposite faces match: vertices inside the mesh, and within its faces and on
/// its edges, are displaced by up to `jitter` spacings, images alike.
inline TetMesh periodic_cube(int n, double jitter, double low = 0, double side = 1) {
  TetMesh mesh = cube(n);
  const TetMesh regular = mesh;
  const auto key = [n](const Point3& p) {
    int k = 0;
    for (const double x : p) k = k * n + static_cast<int>(std::lround(x * n)) % n;
    return static_cast<std::uint32_t>(k);
  };
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    std::mt19937 random(17 + key(regular.points[v]));
    for (std::size_t k = 0; k < 3; ++k) {
      const double x = regular.points[v][k];
      const double moved = x + jitter / n * (std::uniform_real_distribution<>(-1, 1)(random));
      // A coordinate on the face of an axis stays.
      const bool on_face = x == 0 || x == 1;
      mesh.points[v][k] = low + side * (on_face ? x : moved);
    }
  }
  return mesh;
}

}  // namespace tetune::test

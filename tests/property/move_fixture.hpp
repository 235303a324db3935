// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "backend/span.hpp"
#include "mesh/id_maps.hpp"
#include "support/meshes.hpp"
#include "support/options.hpp"
#include "tetune/tetune.hpp"

/// Targets of motions, and checks of results.
namespace tetune::test {

inline bool is_free(const Point3& p) { return std::isnan(p[0]); }
inline bool same_bits(const Point3& a, const Point3& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// The vertex of the result for each of the input, or -1.
inline std::vector<Index> original2new(const MoveReport& r, std::size_t originals, std::size_t vertices) {
  return inverse_map(explicit_map(r.optimization.vertex2original, vertices), originals);
}

/// Targets for some of the vertices, which move by up to `length`.
inline VertexTargets random_targets(const TetMesh& mesh, double part, double length, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  VertexTargets targets(mesh.points.size(), kFree);
  for (std::size_t v = 0; v < targets.size(); ++v) {
    if (v > 0 && unit(random) > part) continue;
    targets[v] = mesh.points[v];
    for (double& x : targets[v]) x += length * (2 * unit(random) - 1);
  }
  return targets;
}

inline void expect_valid(const TetMesh& mesh) {
  const ValidationReport valid = validate(mesh);
  ASSERT_TRUE(valid.ok()) << valid.message(false);
}

/// The prescribed vertices are at their targets, or on the straight way there.
inline void expect_on_way(const TetMesh& before, const TetMesh& after, const VertexTargets& target,
                          const MoveReport& r) {
  const std::vector<Index> now = original2new(r, before.points.size(), after.points.size());
  for (std::size_t v = 0; v < target.size(); ++v) {
    if (is_free(target[v])) continue;
    ASSERT_GE(now[v], 0) << "a prescribed vertex was removed";
    const Point3& p = after.points[to_size_t(now[v])];
    if (r.reached()) {
      ASSERT_TRUE(same_bits(p, target[v])) << "vertex " << v;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_NEAR(p[k], before.points[v][k] + r.fraction * (target[v][k] - before.points[v][k]), 1e-9);
    }
  }
}

}  // namespace tetune::test

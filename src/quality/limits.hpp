// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "tetune/mesh.hpp"
#include "tetune/targets.hpp"

namespace tetune {

inline bool misses(const Target& target, double value) {
  return larger_is_better(target.measure) ? value < target.value : value > target.value;
}

/// 1 for each tetrahedron that misses one of the limits, or has no positive volume (in floating-point arithmetic).
/// `threads` 0 means all. Throws MeshError as quality() does.
std::vector<std::uint8_t> tets_missing_limits(const TetMesh& mesh, const std::vector<Target>& limits, int threads);

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "tetune/mesh.hpp"

/// Meshes of any size for tests and benchmarks, reproducible from a seed.
namespace tetune::reference {

/// A unit cube of n x n x n cells, each divided into six tetrahedra along its diagonal. Vertices are displaced by at
/// most `jitter` of a cell along each axis, those of the boundary within it; up to 0.2 every volume stays positive. All
/// tags are 0.
TetMesh lattice(int n, double jitter = 0, std::uint32_t seed = 1);

/// Applies `rounds` rounds of random valid 2-3 flips within regions, which lower the quality of a valid mesh. Requires
/// that no listed triangle or edge is inside a region.
TetMesh scrambled(TetMesh mesh, int rounds, std::uint32_t seed = 1);

}  // namespace tetune::reference

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "tetune/mesh.hpp"

/// The sequential method of Alexa, "Harmonic triangulations", TOG 2019, as Stroeter et al. 2022 describe it (Sect. 2
/// and 5.1): what the paper compares with, and an oracle for our tests. It shares the energy and the mesh with the
/// rest, and nothing of flips, relocation or boundary.
namespace tetune::reference {

struct FlipResult {
  std::int64_t flips23 = 0, flips32 = 0;
  double decrease = 0;  ///< of the sum of eta
};

struct Iteration {
  std::int64_t flips = 0;
  double energy = 0;         ///< after it
  double gradient_norm = 0;  ///< squared 2-norm of the gradient of tr(L) = eta / 9 before its descent step
};

struct AlexaReport {
  double energy_before = 0, energy_after = 0;
  std::int64_t flips23 = 0, flips32 = 0;
  std::vector<Iteration> iterations;
  double flip_seconds = 0, first_flip_seconds = 0, descent_seconds = 0, projection_seconds = 0, seconds = 0;
  /// No flips were found; otherwise `max_iterations` ended it.
  bool finished = false;
};

/// Harmonic 2-3 and 3-2 flips from one queue ordered by the reduction of the energy, until none is left. The mesh must
/// be valid. Flips do not touch faces between regions.
FlipResult flip_in_order(TetMesh& mesh);

/// Alternates flip_in_order() with one descent step of the whole mesh: one step size for all vertices, no tetrahedron
/// inverted, Brent's method on [0, lambda], then the boundary vertices put back on the closest point of the input
/// surface; until no flips are found. Boundary vertices whose reprojection would invert a tetrahedron take the step
/// back. Required vertices stay.
AlexaReport optimize(TetMesh& mesh, int max_iterations = 1000);

}  // namespace tetune::reference

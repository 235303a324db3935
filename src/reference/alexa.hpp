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
  /// It came to the end asked for; otherwise `max_iterations` ended it.
  bool finished = false;
};

/// Harmonic 2-3 and 3-2 flips from one queue ordered by the reduction of the energy, until none is left. The mesh must
/// be valid. Flips do not touch faces between regions.
FlipResult flip_in_order(TetMesh& mesh);

enum class AlexaEnd {
  no_flips,  ///< the first round that finds no flips
  descended  ///< the same, after five rounds in a row that each lowered the energy by less than 1e-4 of it
};

/// Alternates flip_in_order() with one descent step of the whole mesh, "one gradient descent step on the entire mesh"
/// (Sect. 2): one step size for all vertices, no tetrahedron inverted, Brent's method on [0, lambda], then the boundary
/// vertices put back on the closest point of the input surface. Required vertices stay.
///
/// Two things the paper leaves open, and we read in favour of the method:
/// - The end. It "performs a considerable number of iterations until no harmonic flips can be found" (Sect. 5.4).
///   Between two rounds lies a single, often tiny step ("a small set of vertices preventing substantial optimization",
///   Sect. 4), so a round without flips can come after the first: AlexaEnd::no_flips, to the letter, ends after one to
///   four on our shapes, far from a minimum and far from a considerable number. AlexaEnd::descended goes on until
///   descent, too, has nothing left to give: our own end, with patience, as one tetrahedron can hold up one step. It
///   takes tens of times as long: measure times with the former.
/// - What becomes of a tetrahedron that reprojection inverts. Its boundary vertices take the step back, and where that
///   is not enough all its vertices do; so do those of a tetrahedron that ends worse than the worst one before the
///   step, as one that is all but flat would hold up every step after it.
AlexaReport optimize(TetMesh& mesh, AlexaEnd end = AlexaEnd::descended, int max_iterations = 1000);

}  // namespace tetune::reference

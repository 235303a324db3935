// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "tetune/mesh.hpp"

/// The sequential method of Alexa, "Harmonic triangulations", TOG 2019, as described by Stroeter et al. 2022 (Sect. 2
/// and 5.1): the baseline of that paper, and an oracle for the tests. It shares the energy and the mesh with the rest
/// of the library, but not flips, relocation or the treatment of the boundary.
namespace tetune::reference {

struct FlipResult {
  std::int64_t flips23 = 0, flips32 = 0;
  double decrease = 0;  ///< of the sum of eta
};

struct Iteration {
  std::int64_t flips = 0;
  double energy = 0;         ///< after the iteration
  double gradient_norm = 0;  ///< squared 2-norm of the gradient of tr(L) = eta / 9 before the descent step
};

struct AlexaReport {
  double energy_before = 0, energy_after = 0;
  std::int64_t flips23 = 0, flips32 = 0;
  std::vector<Iteration> iterations;
  double flip_seconds = 0, first_flip_seconds = 0, descent_seconds = 0, projection_seconds = 0, seconds = 0;
  /// Whether the termination criterion was met; otherwise `max_iterations` was reached.
  bool finished = false;
};

/// Applies 2-3 and 3-2 flips that lower the harmonic energy, from one queue ordered by the reduction, until none is
/// left. Requires a valid mesh. Faces between regions are kept.
FlipResult flip_in_order(TetMesh& mesh);

/// Termination criterion of optimize().
enum class AlexaEnd {
  no_flips,  ///< the first iteration without flips
  descended  ///< the first iteration without flips after five consecutive ones with a relative decrease below 1e-4
};

/// Alternates flip_in_order() with "one gradient descent step on the entire mesh" (Sect. 2): one step size lambda for
/// all vertices that inverts no tetrahedron, Brent's method on [0, lambda], then the projection of the boundary
/// vertices to the closest point of the input surface. Required vertices do not move.
///
/// The paper leaves two things open, which are decided here in favor of the method:
/// - Termination. The method "performs a considerable number of iterations until no harmonic flips can be found"
///   (Sect. 5.4). Between two passes of flips lies a single, often tiny step ("a small set of vertices preventing
///   substantial optimization", Sect. 4), so that the second pass may find no flips. AlexaEnd::no_flips, the literal
///   reading, ends after one to four iterations on the shapes of bench/paper, far from a minimum. AlexaEnd::descended
///   continues until the descent has converged too; five iterations, because a single tetrahedron can prevent one step.
///   It takes tens of times as long: times are measured with no_flips.
/// - Tetrahedra that the projection inverts. Their boundary vertices return to their positions before the step, and if
///   that does not suffice, all their vertices do. The same holds for a tetrahedron that becomes worse than the worst
///   one before the step, because a nearly flat one would prevent every later step.
AlexaReport optimize(TetMesh& mesh, AlexaEnd end = AlexaEnd::descended, int max_iterations = 1000);

}  // namespace tetune::reference

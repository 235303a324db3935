// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/criterion.hpp"
#include "energy/regularized_ring.hpp"
#include "energy/ring_of.hpp"
#include "mesh/work_mesh.hpp"
#include "relocation/movable_vertices.hpp"
#include "relocation/step.hpp"

namespace tetune {

/// A vertex that moves farther than this fraction of the local length activates itself and its ring for the next sweep.
inline constexpr double kActivationThreshold = 1e-2;

struct SweepSum {
  double decrease = 0;
  double gradient2 = 0;
  Size moved = 0;
  TETUNE_HD void merge(const SweepSum& other) {
    decrease += other.decrease;
    gradient2 += other.gradient2;
    moved += other.moved;
  }
};

/// The vertices that a sweep moves.
enum class SweepScope : std::uint8_t {
  mesh,       ///< any of the mesh: one that moves far activates its neighbors, and displacement bounds hold
  selection,  ///< a few: neighbors remain inactive, and displacement is not bounded, because a few vertices hardly
              ///< change the element sizes of the surface
};

/// The ring of sweeps over valid meshes. Meshes with inverted elements take RegularizedRing, whose objective requires a
/// positive regularization.
template <class Backend>
using SweepRing = typename RingOf<typename Backend::Pack>::type;

/// One sweep over the active vertices: the colors one after the other, the vertices of a color in parallel (Alg. 1).
/// `Step` is NewtonStep or GradientStep. Ends between two colors when a stop is requested. Returns the pending
/// SweepSum.
template <class Ring, class Backend, class Step>
ResultOf<Backend, SweepSum> sweep(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                                  const MovableVertices<Backend>& vertices, const Step& step,
                                  SweepScope scope = SweepScope::mesh);

}  // namespace tetune

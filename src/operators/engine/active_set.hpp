// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/atomic.hpp"
#include "operators/engine/flip_energy_lower_bound.hpp"
#include "operators/engine/flip_state.hpp"

/// The set of tetrahedra that the next pass evaluates.
namespace tetune {

/// Makes every tetrahedron active whose energy is above `min_energy`, and evaluates no others until tetrahedra are made
/// active again.
template <class Backend>
void activate_all(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                  FlipState<Backend>& state, double min_energy = 0);

/// Sets the slack of all slots to unknown: tetrahedra are evaluated again where they may gain.
template <class Backend>
void reset_slack(const Backend& backend, const WorkMesh<Backend>& mesh, FlipState<Backend>& state) {
  state.slack.resize(backend, mesh.slots(), mesh.room());
  backend.fill(state.slack.span(), kUnknownSlack);
}

/// After vertices have moved: computes the energy of each slot again, and makes the tetrahedra active that have drifted
/// so far that a flip around them may gain now, and whose energy is above `min_energy`. Returns the sum of the
/// energies.
template <class Backend>
double activate_drifted(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                        FlipState<Backend>& state, double min_energy = 0);

/// Makes the tetrahedra active that have an edge between flagged vertices.
template <class Backend>
void activate_around(const Backend& backend, WorkMesh<Backend>& mesh, FlipState<Backend>& state,
                     Span<const std::uint8_t> flags);

/// After an application: makes the marked tetrahedra active; of those marked kActiveIfPromising, the ones that may
/// gain.
template <class Backend>
void activate_marked(const Backend& backend, const Criterion& criterion, FlipState<Backend>& state);

/// The marks of slots, as kernels change them.
struct ActiveMarks {
  Span<std::uint8_t> marks;
  Span<float> slack;
  /// For a tetrahedron that is new or has a new neighbor. One that is active remains so, promising or not.
  TETUNE_HD void mark_changed(Index t) const {
    if (backend::load_shared(marks[t]) == 0) backend::store_shared(marks[t], kActiveIfPromising);
    backend::store_shared(slack[t], kUnknownSlack);
  }
};

}  // namespace tetune

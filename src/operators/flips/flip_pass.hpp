// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/engine/active_set.hpp"
#include "operators/engine/slots.hpp"

namespace tetune {

/// One pass of 2-3 flips, 3-2 flips and edge removals over the active set (Alg. 5): the candidates of every active
/// tetrahedron are evaluated, one is applied when its bid is the highest on all its tetrahedra, and the next active set
/// is what changed, what is beside it, and what owns a gain that was not applied. In place: a 2-3 flip takes a slot, a
/// 3-2 flip frees one, an edge removal with n > 4 tetrahedra takes n - 4, and adjacency is kept up to date. `changed`,
/// when given, is set for the vertices whose ring changed. Throws MeshError, before anything is changed, if the mesh
/// would need more slots than kMaxSlots.
template <class Backend>
PassResult flip_pass(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                     FlipState<Backend>& state, Span<std::uint8_t> changed);

/// Runs passes until one makes no flip. Returns the flips of all of them.
template <class Backend>
FlipCounts flip_until_none(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                           FlipState<Backend>& state, Span<std::uint8_t> changed) {
  FlipCounts all;
  for (int pass = 0; pass < kMaxFlipPasses && state.active.size() > 0; ++pass) {
    const PassResult r = flip_pass(backend, mesh, criterion, state, changed);
    if (r.counts.flips() == 0) break;
    all += r.counts;
  }
  return all;
}

}  // namespace tetune

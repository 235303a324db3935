// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/engine/application.hpp"
#include "operators/flips/flip_pass.hpp"
#include "operators/flips/flip_proposals.hpp"

namespace tetune {

template <class Backend>
PassResult flip_pass(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                     FlipState<Backend>& state, Span<std::uint8_t> changed) {
  const FlipProposals<typename Backend::Pack> proposals{
      rated(mesh, criterion), state.constrained(), state.max_ring,    state.active.span(),
      state.energies.span(),  state.slack.span(),  state.marks.span()};
  return flip_active(backend, mesh, criterion, state, proposals, changed);
}

}  // namespace tetune

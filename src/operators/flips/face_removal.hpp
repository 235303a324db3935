// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/engine/flip_state.hpp"

namespace tetune {

/// One pass of face removals over the active set as it was left, with candidates for each face of an active
/// tetrahedron: the best part of a cluster of three or more faces between two vertices a and b is replaced by the edge
/// (a, b). New tetrahedra are active for flip_pass() afterwards.
template <class Backend>
PassResult face_removal_pass(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                             FlipState<Backend>& state, Span<std::uint8_t> changed);

}  // namespace tetune

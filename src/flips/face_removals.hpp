// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "flips/flip_pass.hpp"

namespace tetune {

/// One pass of face removals: like flip_pass(), over the active set as it was left, with a flip for each face of an
/// active tetrahedron. A cluster of three or more faces between two vertices a and b gives way to the edge (a, b). What
/// it makes is active for flip_pass() afterwards. Only FlipReport::face_removals and the like are set.
template <class Backend>
FlipReport face_removal_pass(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state,
                             Span<std::uint8_t> awake);

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "relocate/sweep.hpp"

namespace tetune {

/// Moves the flagged vertices, colour after colour, each where it may go, to where the smallest dihedral angle around
/// it is larger, until its cotangent is no more than `enough`. Returns how many moved.
template <class Backend>
Size open_angles(const Backend& par, WorkMesh<Backend>& mesh, const RingsView& rings, const Coloring<Backend>& coloring,
                 Mobilities<Backend>& mobilities, Span<const std::uint8_t> flags, double enough);

}  // namespace tetune

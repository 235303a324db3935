// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "relocate/sweep.hpp"

namespace tetune {

/// Moves the flagged vertices, colour after colour, to where the smallest dihedral angle around them is larger, until
/// its cotangent is no more than `enough`. Returns how many moved. Vertices that slide on the input surface stay.
template <class Backend>
Size open_angles(const Backend& par, WorkMesh<Backend>& mesh, const RingsView& rings, const Coloring<Backend>& coloring,
                 const Mobilities<Backend>& mobilities, Span<const std::uint8_t> flags, double enough);

}  // namespace tetune

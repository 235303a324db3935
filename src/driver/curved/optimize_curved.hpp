// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tetune/optimize.hpp"

namespace tetune {

/// optimize() of a mesh with curved edges: optimizes the straight tetrahedra with the curved surface as a constraint,
/// and then makes the curved ones valid (docs/method.md, "Curved tetrahedra").
Report optimize_curved(TetMesh& mesh, const Options& options, const Context& context);

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tetune/mesh.hpp"

namespace tetune {

/// The smallest dihedral angle of a mesh with positive volumes, in degrees; 180 without tetrahedra.
/// `threads` 0 means all.
double smallest_dihedral(const TetMesh& mesh, int threads);

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tetune/validate.hpp"

namespace tetune {

/// The part of validate() that must hold before anything may index into the mesh: lengths, indices, finite coordinates.
ValidationReport validate_arrays(const TetMesh& mesh);

}  // namespace tetune

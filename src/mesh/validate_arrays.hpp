// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tetune/validate.hpp"

namespace tetune {

/// The numbers of entries of the arrays of a mesh.
struct ArrayCounts {
  std::int64_t vertices = 0, tets = 0, triangles = 0, edges = 0, others = 0;
};

/// One finding per array that is longer than 32-bit ids allow.
ValidationReport validate_counts(const ArrayCounts& counts);

/// The part of validate() that must hold before the mesh may be indexed: lengths and indices.
ValidationReport validate_indices(const TetMesh& mesh);

/// validate_indices(), finite coordinates and curved edges.
ValidationReport validate_arrays(const TetMesh& mesh);

/// Throws MeshError with the findings of validate_arrays(), if any.
void require_arrays(const TetMesh& mesh);

}  // namespace tetune

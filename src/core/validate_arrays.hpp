// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tetune/validate.hpp"

namespace tetune {

/// How many entries the arrays of a mesh have.
struct ArrayCounts {
  std::size_t vertices = 0, tets = 0, triangles = 0, edges = 0, others = 0;
};

/// A finding for each array that is longer than ids and the work on it allow.
ValidationReport validate_counts(const ArrayCounts& counts);

/// The part of validate() that must hold before anything may index into the mesh: lengths, indices, finite coordinates.
ValidationReport validate_arrays(const TetMesh& mesh);

}  // namespace tetune

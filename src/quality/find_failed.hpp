// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tetune/criteria.hpp"

namespace tetune {

/// A tetrahedron that misses AcceptanceCriterion::fail, and its value; of a face, the tetrahedron of smaller id.
struct FailedTet {
  Index tet;
  double value;
};

/// Returns the tetrahedra of a mesh that fail, in increasing order, each once. The criterion and the arrays must be
/// valid: see check().
std::vector<FailedTet> find_failed(const TetMesh& mesh, const AcceptanceCriterion& criterion, int threads);

}  // namespace tetune

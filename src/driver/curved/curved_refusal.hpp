// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "tetune/mesh.hpp"
#include "tetune/options.hpp"

namespace tetune {

/// Throws OptionError for options that curved meshes do not have, and MeshError where the straight tetrahedra are not
/// valid.
void check_curved_input(const TetMesh& mesh, const Options& options);

/// Second-order elements of an input that could not be made valid.
struct CurvedFailure {
  std::int64_t invalid = 0;   ///< number of those of the input
  std::vector<Index> left;    ///< those that stay so, in increasing order
  std::vector<Index> folded;  ///< those of them with a face that its own mid-side nodes fold
  bool is_stopped = false;
};

/// Throws UntangleError, with the options that may help.
[[noreturn]] void refuse_curved(const TetMesh& mesh, const Options& options, const CurvedFailure& failure);

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "io/second_order.hpp"
#include "tetune/mesh.hpp"

namespace tetune::plugin {

/// Merges points at the same position, as the pieces of a file have; with `middles`, whose ids are those of the points.
/// The data and the tag of a vertex are those of the copy that an element or a mid-side node uses and that is not among
/// the `duplicates`, of which there is one per point; of several such copies, those of the first. Returns the number of
/// vertices that are nearer to a vertex of another piece than 1e-9 of the diagonal, but not at the same position.
std::size_t merge_points(TetMesh& mesh, const std::vector<bool>& duplicates, std::vector<Middle>& middles);

}  // namespace tetune::plugin

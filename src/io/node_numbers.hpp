// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "io/io_context.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// The numbers that a writer gives the nodes of a mesh, which has its mid-side nodes after its vertices: those of
/// TetMesh::deck_nodes, and numbers above all of these for other nodes. Where they repeat or one is above `max`, all
/// nodes are numbered from 1, with a warning.
std::vector<std::int64_t> numbers_of_nodes(const TetMesh& mesh, std::size_t vertices, std::int64_t max,
                                           const IoContext& context);

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "io/io_context.hpp"
#include "io/number_index.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// The numbers that a writer gives the nodes of a mesh, which has its mid-side nodes after its vertices: those of
/// TetMesh::deck_nodes, and numbers above all of these for other nodes. Where they repeat or one is above `max`, all
/// nodes are numbered from 1, with a warning.
std::vector<std::int64_t> numbers_of_nodes(const TetMesh& mesh, std::size_t vertices, std::int64_t max,
                                           const IoContext& context);

/// Indexes the nodes of a file by their numbers, and erases each node that repeats the number and the position of one
/// before it. Calls fail(first, second), which throws, for nodes of one number at different positions.
NumberIndex merge_repeated_nodes(std::vector<std::int64_t>& numbers, std::vector<Point3>& points,
                                 const std::function<void(Index first, Index second)>& fail);

}  // namespace tetune

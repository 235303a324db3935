// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "io/io_context.hpp"
#include "io/number_index.hpp"
#include "io/second_order.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// The numbers that a writer gives the nodes of a mesh, which has `middles` after its vertices unless that is null:
/// those of TetMesh::deck_nodes, and numbers above all of these for other nodes. Where they repeat or one is above
/// `max`, all nodes are numbered from 1, with a warning.
std::vector<std::int64_t> numbers_of_nodes(const TetMesh& mesh, const Middles* middles, std::int64_t max,
                                           const IoContext& context);

/// Indexes the nodes of a file by their numbers, and erases each node that repeats the number and the position of one
/// before it. Calls fail(first, second), which throws, for nodes of one number at different positions.
NumberIndex merge_repeated_nodes(std::vector<std::int64_t>& numbers, std::vector<Point3>& points,
                                 const std::function<void(Index first, Index second)>& fail);

/// Keeps the numbers of all nodes but `middles` in TetMesh::deck_nodes. for_each_vertex(visit) calls visit(element,
/// node) for each vertex of each element; fail(element, text), which throws, is called for a mid-side node that is a
/// vertex.
template <class ForEachVertex, class Fail>
void keep_numbers(const std::vector<std::int64_t>& numbers, const MiddleList& middles, TetMesh& mesh,
                  const ForEachVertex& for_each_vertex, const Fail& fail) {
  const std::vector<std::uint8_t> is_middle = middle_flags(middles, numbers.size());
  if (!middles.nodes.empty()) {
    for_each_vertex([&](const auto& element, Index v) {
      if (span_of(is_middle)[v] == 0) return;
      fail(element, "node " + std::to_string(span_of(numbers)[v]) +
                        " is a vertex of this element and in the middle of an edge of another one; give all elements "
                        "the same order");
    });
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (is_middle[i] == 0) mesh.deck_nodes.push_back(numbers[i]);
  }
}

}  // namespace tetune

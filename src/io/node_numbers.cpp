// SPDX-License-Identifier: Apache-2.0
#include "io/node_numbers.hpp"

#include <algorithm>
#include <iterator>
#include <string>

#include "io/number_index.hpp"

namespace tetune {

std::vector<std::int64_t> numbers_of_nodes(const TetMesh& mesh, std::size_t vertices, std::int64_t max,
                                           const IoContext& context) {
  std::vector<std::int64_t> numbers;
  if (mesh.deck_nodes.size() == vertices) numbers = mesh.deck_nodes;
  numbers.resize(mesh.points.size(), 0);
  std::vector<std::int64_t> kept;
  std::copy_if(numbers.begin(), numbers.end(), std::back_inserter(kept), [](std::int64_t n) { return n != 0; });
  const NumberIndex index(kept);
  std::int64_t last = kept.empty() ? 0 : span_of(kept)[index.order().back()];
  const std::int64_t others = std::ssize(numbers) - std::ssize(kept);
  if (index.repeated() < 0 && last + others <= max) {
    for (std::int64_t& number : numbers) number = number == 0 ? ++last : number;
    return numbers;
  }
  context.warn("the numbers of the nodes have more than " + std::to_string(std::to_string(max).size()) +
               " digits or occur twice: the nodes are numbered from 1");
  for (std::size_t v = 0; v < numbers.size(); ++v) numbers[v] = std::int64_t(v) + 1;
  return numbers;
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "io/node_numbers.hpp"

#include <algorithm>
#include <iterator>
#include <string>

#include "backend/span.hpp"

namespace tetune {

std::vector<std::int64_t> numbers_of_nodes(const TetMesh& mesh, const Middles* middles, std::int64_t max,
                                           const IoContext& context) {
  const std::size_t vertices = middles == nullptr ? mesh.points.size() : middles->vertices();
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

NumberIndex merge_repeated_nodes(std::vector<std::int64_t>& numbers, std::vector<Point3>& points,
                                 const std::function<void(Index first, Index second)>& fail) {
  NumberIndex index(numbers);
  if (index.repeated() < 0) return index;
  std::vector<std::uint8_t> is_copy(numbers.size(), 0);
  const std::vector<Index>& order = index.order();
  for (std::size_t i = 1; i < order.size(); ++i) {
    const Index a = order[i - 1], b = order[i];
    if (span_of(numbers)[a] != span_of(numbers)[b]) continue;
    if (span_of(points)[a] != span_of(points)[b]) fail(a, b);
    span_of(is_copy)[b] = 1;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < is_copy.size(); ++i) {
    if (is_copy[i] != 0) continue;
    points[kept] = points[i];
    numbers[kept++] = numbers[i];
  }
  points.resize(kept);
  numbers.resize(kept);
  return NumberIndex(numbers);
}

}  // namespace tetune

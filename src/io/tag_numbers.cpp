// SPDX-License-Identifier: Apache-2.0
#include "io/tag_numbers.hpp"

#include <vector>

#include "backend/span.hpp"
#include "mesh/element_kinds.hpp"

namespace tetune {

std::map<int, int> numbers_of_tags(const std::set<int>& tags, std::set<int> taken, int max) {
  taken.insert(tags.begin(), tags.end());
  FreeNumbers free_numbers(std::move(taken));
  std::map<int, int> tag2number;
  for (const int tag : tags) {
    int& number = tag2number[tag];
    if (tag > 0 && tag <= max) number = tag;
    if (tag < 0 && tag >= -max && free_numbers.take(-tag)) number = -tag;
  }
  for (auto& [tag, number] : tag2number) {
    if (number == 0) number = free_numbers.take_lowest();
  }
  return tag2number;
}

std::array<std::set<int>, 4> tags_by_dimension(const TetMesh& mesh) {
  std::array<std::set<int>, 4> tags;
  const auto add = [&tags](int dimension, const std::vector<int>& list) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (i == 0 || list[i] != list[i - 1]) tags[to_size_t(dimension)].insert(list[i]);
    }
  };
  add(1, mesh.edge_tags);
  add(2, mesh.triangle_tags);
  add(3, mesh.tet_tags);
  for (const ElementBlock& block : mesh.others) {
    const ElementKind* const kind = find_element_kind(block.kind);
    if (kind != nullptr) add(kind->dimension, block.tags);
  }
  return tags;
}

void warn_of_renumbered_tags(const std::map<int, int>& tag2number, int dimension, const std::string& range,
                             const IoContext& context) {
  std::string first;
  int renumbered = 0;
  for (const auto& [tag, number] : tag2number) {
    if (tag == number || renumbered++ > 0) continue;
    first = std::to_string(tag) + " is written as " + std::to_string(number);
  }
  if (renumbered == 0) return;
  if (renumbered > 1) first += ", and " + std::to_string(renumbered - 1) + " more";
  context.warn("the format's numbers are " + range + ": of elements of dimension " + std::to_string(dimension) +
               " the tag " + first);
}

}  // namespace tetune

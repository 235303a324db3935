// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "backend/span.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// The block of a kind and order of elements of a mesh, which is appended where the mesh has none.
inline ElementBlock& element_block(TetMesh& mesh, std::string_view kind, int vertices, bool second_order = false) {
  for (ElementBlock& block : mesh.others) {
    if (block.kind == kind && block.second_order == second_order) return block;
  }
  return mesh.others.emplace_back(ElementBlock{std::string(kind), vertices, {}, {}, {}, {}, second_order});
}

/// The blocks of a mesh, one per kind whatever their order. Where the mesh has several of a kind, `joined` has all of
/// them, without data.
inline const std::vector<ElementBlock>& blocks_by_kind(const TetMesh& mesh, std::vector<ElementBlock>& joined) {
  std::set<std::string_view> kinds;
  for (const ElementBlock& block : mesh.others) kinds.insert(block.kind);
  if (kinds.size() == mesh.others.size()) return mesh.others;
  for (const std::string_view kind : kinds) {
    ElementBlock& all = joined.emplace_back();
    all.kind = kind;
    for (const ElementBlock& block : mesh.others) {
      if (block.kind != kind) continue;
      all.vertices_per_element = block.vertices_per_element;
      for (const Index i : block.required) all.required.push_back(to_index(all.tags.size()) + i);
      all.element2vertex.insert(all.element2vertex.end(), block.element2vertex.begin(), block.element2vertex.end());
      all.tags.insert(all.tags.end(), block.tags.begin(), block.tags.end());
    }
  }
  return joined;
}

}  // namespace tetune

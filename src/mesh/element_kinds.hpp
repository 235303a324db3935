// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "backend/span.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// The ends of an edge, by their positions among the vertices of an element.
using Pair = std::array<int, 2>;

/// The edges of elements in the order in which Abaqus, CalculiX and VTK number the nodes in their middles: those of the
/// base, of the top, and between them.
inline constexpr std::array<Pair, 4> kQuadEdges{{{0, 1}, {1, 2}, {2, 3}, {3, 0}}};
inline constexpr std::array<Pair, 8> kPyramidEdges{{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}}};
inline constexpr std::array<Pair, 9> kPrismEdges{
    {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}}};
inline constexpr std::array<Pair, 12> kHexEdges{
    {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};

/// A kind of ElementBlock. Its vertices are in the order of MEDIT's and VTK's files.
struct ElementKind {
  std::string_view name;
  int vertices;
  int dimension;
  std::span<const Pair> edges{};
};
inline constexpr std::array<ElementKind, 5> kElementKinds{{{kPoints, 1, 0},
                                                           {"Quadrilaterals", 4, 2, kQuadEdges},
                                                           {"Pyramids", 5, 3, kPyramidEdges},
                                                           {"Prisms", 6, 3, kPrismEdges},
                                                           {"Hexahedra", 8, 3, kHexEdges}}};

/// Null for a name that is not one of these.
inline const ElementKind* find_element_kind(std::string_view name) {
  const auto* const kind =
      std::find_if(kElementKinds.begin(), kElementKinds.end(), [name](const ElementKind& k) { return k.name == name; });
  return kind == kElementKinds.end() ? nullptr : kind;
}

/// Readers list other elements by kind and order: the kinds above, then again all but points, with mid-side nodes.
inline constexpr std::size_t kOtherLists = 2 * kElementKinds.size() - 1;
inline constexpr bool is_second_order_list(std::size_t list) { return list >= kElementKinds.size(); }
inline constexpr const ElementKind& kind_of_list(std::size_t list) {
  return kElementKinds[is_second_order_list(list) ? list + 1 - kElementKinds.size() : list];
}

/// An empty block per list.
inline std::vector<ElementBlock> blocks_of_lists() {
  std::vector<ElementBlock> blocks;
  for (std::size_t list = 0; list < kOtherLists; ++list) {
    const ElementKind& kind = kind_of_list(list);
    blocks.push_back({std::string(kind.name), kind.vertices, {}, {}, {}, {}, is_second_order_list(list)});
  }
  return blocks;
}

/// Whether the elements of a block of a mesh have mid-side nodes.
inline bool has_middles(const TetMesh& mesh, const ElementBlock& block) {
  return mesh.second_order && block.second_order;
}

/// The list of a block; kOtherLists for a kind that is none of those above.
inline std::size_t list_of(const TetMesh& mesh, const ElementBlock& block) {
  const ElementKind* const kind = find_element_kind(block.kind);
  if (kind == nullptr) return kOtherLists;
  const std::size_t first = to_size_t(kind - kElementKinds.data());
  return has_middles(mesh, block) && !kind->edges.empty() ? first + kElementKinds.size() - 1 : first;
}

/// Calls f(a, b) for the ends of each edge of elements of other kinds that have mid-side nodes.
template <class Function>
void for_each_other_middle(const TetMesh& mesh, const Function& f) {
  for (const ElementBlock& block : mesh.others) {
    const ElementKind* const kind = find_element_kind(block.kind);
    if (kind == nullptr || !has_middles(mesh, block)) continue;
    const std::size_t each = to_size_t(kind->vertices);
    for (std::size_t first = 0; first + each <= block.element2vertex.size(); first += each) {
      const auto vertices = std::span(block.element2vertex).subspan(first, each);
      for (const auto& [i, j] : kind->edges) f(vertices[to_size_t(i)], vertices[to_size_t(j)]);
    }
  }
}

}  // namespace tetune

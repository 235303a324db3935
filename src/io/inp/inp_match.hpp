// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "io/inp/inp_deck.hpp"

namespace tetune {

/// The remedy where a mesh is not one of its deck.
inline constexpr const char* kNotOfDeck = "; write a mesh that this deck can follow, or another format";

/// The correspondence between the entities of a mesh and those of its deck.
struct InpMatch {
  /// Per vertex: its node in the deck, or -1; and its number.
  std::vector<Index> vertex2node;
  std::vector<std::int64_t> vertex_labels;
  /// Per node of the deck its vertex, or -1.
  std::vector<Index> node2vertex;
  std::vector<Index> inserted;  ///< vertices

  /// Per tetrahedron: its number, and its vertices in the order in which it is written.
  std::vector<std::int64_t> tet_labels;
  std::vector<std::array<Index, 4>> listed;
  /// Per tetrahedron of the deck the one that has its number, or -1; and whether its line stays.
  std::vector<Index> old2tet;
  std::vector<std::uint8_t> is_same;
  /// Per *ELEMENT card of tetrahedra those with new numbers.
  std::vector<std::vector<Index>> added;

  /// Likewise for triangles that are elements and faces of tetrahedra; other triangles have the number 0.
  std::vector<std::int64_t> triangle_labels;
  std::vector<Index> old2triangle;  ///< per entry of InpModel::triangles
  std::vector<std::uint8_t> is_same_triangle;
  std::vector<std::vector<Index>> added_triangles;
};

/// Finds the elements of a deck that are unchanged; the others of a region or patch get the numbers of those that it
/// has lost, then new ones. Throws FileError where the mesh is not of this deck.
InpMatch match_inp(const InpModel& model, const TetMesh& mesh);

/// The position in a list of regions or patches, or -1.
template <class T>
Index find_inp_tag(const std::vector<T>& list, int tag) {
  const auto at = std::lower_bound(list.begin(), list.end(), tag, [](const T& item, int t) { return item.tag < t; });
  return at == list.end() || at->tag != tag ? -1 : to_index(at - list.begin());
}

}  // namespace tetune

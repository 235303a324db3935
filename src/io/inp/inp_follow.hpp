// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/inp/inp_match.hpp"
#include "io/io_context.hpp"
#include "io/second_order.hpp"

namespace tetune {

/// The cards that change with the mesh.
struct InpChanges {
  /// The new text of cards of sets and of faces; none where the old one holds.
  std::vector<std::optional<std::string>> set_cards, face_cards;
  /// The inserted vertices are in the set of the last *NODE card.
  bool appends_nodes = false;
  /// Further cards of sets, after the last node.
  std::string cards_after_nodes;
  /// Further cards of sets, after the last element of each *ELEMENT card of tetrahedra, and of triangles.
  std::vector<std::string> cards_after_tets, cards_after_triangles;
  /// Lines of inserted nodes, per entry of InpModel::conditions.
  std::vector<std::string> conditions;
};

/// Finds the sets and surfaces of a deck in a mesh. Throws FileError where one of them is lost.
InpChanges follow_inp(const InpModel& model, const TetMesh& mesh, const InpMatch& match, const Middles* middles,
                      const IoContext& context);

}  // namespace tetune

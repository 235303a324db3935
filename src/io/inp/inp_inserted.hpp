// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "io/inp/inp_match.hpp"
#include "io/second_order.hpp"

namespace tetune {

/// The place of a node that the deck lacks, in the mesh of the deck.
struct InpInserted {
  /// Nodes of the deck, with the weights by which values between them vary linearly; of a mid-side node, or outside of
  /// the mesh of the deck, none.
  std::vector<Index> nodes;
  std::vector<double> weights;
  /// The nodes of the deck that have to be in a set that the node joins (InsertedVertex::support).
  std::vector<Index> support;
  /// The vertices at the ends of the edge of a mid-side node.
  std::array<Index, 2> ends{-1, -1};
  bool has_inserted_end = false;
  /// Whether both ends of the edge of a mid-side node are on the surface of the mesh, and the edge is not: conditions
  /// on the surface do not apply to the node.
  bool is_across = false;
  bool is_middle() const { return ends[0] >= 0; }
};

/// Per entry of InpMatch::inserted; nothing where no set and no condition of the deck needs the places.
std::vector<InpInserted> find_inp_inserted(const InpModel& model, const TetMesh& mesh, const InpMatch& match,
                                           const Middles* middles);

}  // namespace tetune

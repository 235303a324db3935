// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "io/inp/inp_deck.hpp"
#include "io/second_order.hpp"

/// The mid-side nodes of second-order tetrahedra of decks.
namespace tetune {

/// Sorts the edges. Throws FileError where an edge has two nodes, or a mid-side node has another part.
void check_inp_middles(InpModel& model, const std::string& path);

/// Takes the mid-side nodes out of the members of sets of nodes.
void split_inp_sets(InpModel& model);

/// Takes the mid-side nodes out of a mesh whose vertices are the nodes of the deck. Edges become required where a
/// mid-side node is named that no region and no patch of its set has.
void erase_inp_middles(InpModel& model, TetMesh& mesh, const std::string& path);

/// Adds the mid-side nodes to a mesh of the deck as vertices, with their numbers in the deck, or 0.
Middles add_inp_middles(const InpModel& model, TetMesh& mesh);

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "io/inp/inp_card_kind.hpp"
#include "io/inp/inp_scan.hpp"

/// The data lines of cards.
namespace tetune {

/// Reads the lines of nodes up to the next that is none.
void read_inp_nodes(InpCursor& cursor, InpModel& model);
/// Reads the lines of tetrahedra up to the next that is none. `set`: that of their card, or -1.
void read_inp_tets(InpCursor& cursor, Index set, InpScan& scan);
/// Reads one triangle of the last card of triangles.
void read_inp_triangle(InpCursor& cursor, const InpElementType& type, Index set, InpScan& scan);
/// Reads one element of another type.
void read_inp_other(InpCursor& cursor, const InpElementType& type, Index set, InpScan& scan);
/// Reads a line of the last set card.
void read_inp_set_line(InpCursor& cursor, const InpCardKind& kind, InpScan& scan);
/// Reads a line of the last face card.
void read_inp_face_line(InpCursor& cursor, const InpCardKind& kind, InpScan& scan);

/// Collects the names and numbers in a data line of any other card, and in a parameter of its keyword line.
void note_inp_data(const std::vector<std::string_view>& fields, const InpCardKind& kind, InpScan& scan);
void note_inp_parameter(const std::string& key, const std::string& value, const InpCardKind& kind, InpScan& scan);

}  // namespace tetune

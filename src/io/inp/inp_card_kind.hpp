// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/inp/inp_format.hpp"

namespace tetune {

/// The fields of the data lines of a card that can name nodes and elements by number.
struct InpCardKind {
  enum class Fields { none, first, every, every_third };
  Fields nodes = Fields::none;
  Fields elements = Fields::none;
  /// Whether the lines of the card are `element or set, face, ...`.
  bool has_faces = false;
  /// Whether the card relates the nodes of sets one by one.
  bool pairs = false;
  /// Whether the load of the card acts on each node of a set: the total would change with their number.
  bool is_per_node = false;
  /// The fields that follow a node or set of nodes in a line of values:
  /// field: values, which vary linearly between the nodes; components: the number of a component, and such values;
  /// range: the first and last degree of freedom, and a value; members: nothing.
  enum class Condition { none, field, components, range, members };
  Condition condition = Condition::none;
  static bool is_field(Condition c) { return c == Condition::field || c == Condition::components; }
  bool is_of_fields() const { return is_field(condition); }
  /// The reason why decks with such a card are refused, or nullptr.
  const char* refusal = nullptr;
};

/// The kind of a card. One that is not known can name a node or an element by its first field.
InpCardKind inp_card_kind(const InpKeyword& keyword);

}  // namespace tetune

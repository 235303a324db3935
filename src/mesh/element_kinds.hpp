// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "tetune/mesh.hpp"

namespace tetune {

/// A kind of ElementBlock. Its vertices are in the order of MEDIT's and VTK's files.
struct ElementKind {
  std::string_view name;
  int vertices;
  int dimension;
};
inline constexpr std::array<ElementKind, 5> kElementKinds{
    {{kPoints, 1, 0}, {"Quadrilaterals", 4, 2}, {"Pyramids", 5, 3}, {"Prisms", 6, 3}, {"Hexahedra", 8, 3}}};

/// Null for a name that is not one of these.
inline const ElementKind* find_element_kind(std::string_view name) {
  const auto* const kind =
      std::find_if(kElementKinds.begin(), kElementKinds.end(), [name](const ElementKind& k) { return k.name == name; });
  return kind == kElementKinds.end() ? nullptr : kind;
}

}  // namespace tetune

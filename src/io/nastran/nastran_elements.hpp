// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace tetune {

/// The largest number of a node, element or property: they have at most 8 digits.
inline constexpr int kMaxNastranNumber = 99'999'999;

/// A card of elements. Its nodes follow the numbers of the element and of its property; mid-side nodes, which may be
/// blank, the vertices.
struct NastranElementKind {
  enum class Role { tetrahedron, triangle, edge, other };
  std::string_view card;
  Role role;
  std::uint8_t vertices, nodes;
  /// ElementBlock::kind.
  std::string_view block{};
  /// Whether elements of the block are written with this card.
  bool is_written = false;

  std::size_t dimension() const {
    if (role == Role::edge) return 1;
    return role == Role::triangle || block == "Quadrilaterals" ? 2 : 3;
  }
};

/// All kinds, in the order in which elements are written.
inline constexpr std::array<NastranElementKind, 13> kNastranElementKinds{{
    {"CROD", NastranElementKind::Role::edge, 2, 2},
    {"CBAR", NastranElementKind::Role::edge, 2, 2},
    {"CBEAM", NastranElementKind::Role::edge, 2, 2},
    {"CTRIA3", NastranElementKind::Role::triangle, 3, 3},
    {"CTRIA6", NastranElementKind::Role::triangle, 3, 6},
    {"CQUAD4", NastranElementKind::Role::other, 4, 4, "Quadrilaterals", true},
    {"CQUAD8", NastranElementKind::Role::other, 4, 8, "Quadrilaterals"},
    {"CTETRA", NastranElementKind::Role::tetrahedron, 4, 10},
    {"CPYRAM", NastranElementKind::Role::other, 5, 13, "Pyramids", true},
    {"CPYRA", NastranElementKind::Role::other, 5, 13, "Pyramids"},
    {"CPYRA5", NastranElementKind::Role::other, 5, 5, "Pyramids"},
    {"CPENTA", NastranElementKind::Role::other, 6, 15, "Prisms", true},
    {"CHEXA", NastranElementKind::Role::other, 8, 20, "Hexahedra", true},
}};

/// The kind of elements of a card; null for other cards.
inline const NastranElementKind* find_nastran_element_kind(std::string_view card) {
  const auto* const found = std::find_if(kNastranElementKinds.begin(), kNastranElementKinds.end(),
                                         [card](const NastranElementKind& e) { return e.card == card; });
  return found == kNastranElementKinds.end() ? nullptr : found;
}

}  // namespace tetune

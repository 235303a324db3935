// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace tetune {

/// The places of the nodes among those that a file lists for an element of second order: first of the vertices, then of
/// the mid-side nodes in the order of kTetEdges, kTriangleEdges, kEdgeEdges and MiddleOrder::base_between_top. The file
/// goes around the base and the top; there a mid-side node follows the vertex before it.
inline constexpr std::array<std::uint8_t, 3> kUnvEdgePlaces{0, 2, 1};
inline constexpr std::array<std::uint8_t, 6> kUnvTrianglePlaces{0, 2, 4, 1, 3, 5};
inline constexpr std::array<std::uint8_t, 8> kUnvQuadPlaces{0, 2, 4, 6, 1, 3, 5, 7};
inline constexpr std::array<std::uint8_t, 10> kUnvTetPlaces{0, 2, 4, 9, 1, 3, 5, 6, 7, 8};
inline constexpr std::array<std::uint8_t, 13> kUnvPyramidPlaces{0, 2, 4, 6, 12, 1, 3, 5, 7, 8, 9, 10, 11};
inline constexpr std::array<std::uint8_t, 15> kUnvPrismPlaces{0, 2, 4, 9, 11, 13, 1, 3, 5, 6, 7, 8, 10, 12, 14};
inline constexpr std::array<std::uint8_t, 20> kUnvHexPlaces{0, 2, 4, 6, 12, 14, 16, 18, 1,  3,
                                                            5, 7, 8, 9, 10, 11, 13, 15, 17, 19};

/// A kind of elements of universal files.
struct UnvElementKind {
  enum class Role { edge, triangle, tetrahedron, other, unread };
  Role role;
  std::uint8_t dimension;
  /// Numbers of nodes without and with those in the middles of edges.
  std::uint8_t vertices, nodes;
  /// ElementBlock::kind.
  std::string_view block{};
  /// The FE descriptor ids that elements of first and of second order are written with.
  int written = 0, written_quadratic = 0;
  /// Of the nodes of an element of second order, as above.
  std::span<const std::uint8_t> places{};

  /// The place of node k of an element with n nodes, vertices first.
  std::size_t place(std::size_t n, std::size_t k) const { return n == nodes && n > vertices ? places[k] : k; }
};

/// All kinds, in the order in which elements are written. The last stands for elements of a higher order, which are not
/// read.
inline constexpr std::array<UnvElementKind, 8> kUnvElementKinds{{
    {UnvElementKind::Role::edge, 1, 2, 3, {}, 11, 24, kUnvEdgePlaces},
    {UnvElementKind::Role::triangle, 2, 3, 6, {}, 91, 92, kUnvTrianglePlaces},
    {UnvElementKind::Role::other, 2, 4, 8, "Quadrilaterals", 94, 95, kUnvQuadPlaces},
    {UnvElementKind::Role::tetrahedron, 3, 4, 10, {}, 111, 118, kUnvTetPlaces},
    {UnvElementKind::Role::other, 3, 5, 13, "Pyramids", 312, 114, kUnvPyramidPlaces},
    {UnvElementKind::Role::other, 3, 6, 15, "Prisms", 112, 113, kUnvPrismPlaces},
    {UnvElementKind::Role::other, 3, 8, 20, "Hexahedra", 115, 116, kUnvHexPlaces},
    {UnvElementKind::Role::unread, 0, 0, 0},
}};

/// The largest descriptor of a beam, rod or pipe. These elements have a line of orientation and cross sections between
/// the first line and that of the nodes.
inline constexpr int kMaxUnvBeam = 32;

/// The kind of elements with this FE descriptor id; null where they are not of a mesh, such as springs and masses.
inline const UnvElementKind* find_unv_element_kind(std::int64_t descriptor) {
  struct Listed {
    std::size_t kind;  // position in kUnvElementKinds
    std::array<int, 14> descriptors;
  };
  constexpr std::array<Listed, 8> kListed{{{0, {11, 21, 22, 23, 24, 31, 32}},
                                           {1, {41, 42, 51, 52, 61, 62, 72, 74, 81, 82, 91, 92}},
                                           {2, {44, 45, 54, 55, 64, 65, 71, 75, 84, 85, 94, 95}},
                                           {3, {111, 118}},
                                           {4, {114, 119, 312}},  // as Salome writes them; 119 in older versions
                                           {5, {101, 102, 112, 113}},
                                           {6, {104, 105, 115, 116}},
                                           {7, {43, 46, 53, 56, 63, 66, 73, 76, 93, 96, 103, 106, 117, 300}}}};
  if (descriptor <= 0) return nullptr;
  for (const Listed& listed : kListed) {
    const auto& list = listed.descriptors;
    if (std::find(list.begin(), list.end(), descriptor) != list.end()) return &kUnvElementKinds[listed.kind];
  }
  return nullptr;
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace tetune {

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
};

/// All kinds, in the order in which elements are written. The last stands for elements of an order that is not read.
inline constexpr std::array<UnvElementKind, 8> kUnvElementKinds{{
    {UnvElementKind::Role::edge, 1, 2, 3, {}, 11, 24},
    {UnvElementKind::Role::triangle, 2, 3, 6, {}, 91, 92},
    {UnvElementKind::Role::other, 2, 4, 8, "Quadrilaterals", 94},
    {UnvElementKind::Role::tetrahedron, 3, 4, 10, {}, 111, 118},
    {UnvElementKind::Role::other, 3, 5, 13, "Pyramids", 312},
    {UnvElementKind::Role::other, 3, 6, 15, "Prisms", 112},
    {UnvElementKind::Role::other, 3, 8, 20, "Hexahedra", 115},
    {UnvElementKind::Role::unread, 0, 0, 0},
}};

/// The largest descriptor of a beam, rod or pipe. These elements have a line of orientation and cross sections between
/// the first line and that of the nodes.
inline constexpr int kMaxUnvBeam = 32;

/// The kind of elements with this FE descriptor id; null where they are not of a mesh, such as springs and masses.
inline const UnvElementKind* find_unv_element_kind(std::int64_t descriptor) {
  struct Listed {
    std::size_t kind;  // position in kUnvElementKinds
    std::array<int, 27> descriptors;
  };
  constexpr std::array<Listed, 8> kListed{{{0, {11, 21, 22, 23, 24, 31, 32}},
                                           {1, {41, 42, 51, 52, 61, 62, 72, 74, 81, 82, 91, 92}},
                                           {2, {44, 54, 64, 71, 84, 94}},
                                           {3, {111, 118}},
                                           {4, {119, 312}},  // as Salome writes them, in older and in current versions
                                           {5, {101, 112}},
                                           {6, {104, 115}},
                                           {7, {43, 45, 46, 53,  55,  56,  63,  65,  66,  73,  75,  76, 85,
                                                93, 95, 96, 102, 103, 105, 106, 113, 114, 116, 117, 300}}}};
  if (descriptor <= 0) return nullptr;
  for (const Listed& listed : kListed) {
    const auto& list = listed.descriptors;
    if (std::find(list.begin(), list.end(), descriptor) != list.end()) return &kUnvElementKinds[listed.kind];
  }
  return nullptr;
}

/// The places of the nodes among those that a file lists for an element of second order: first of the vertices, then of
/// the mid-side nodes in the order of kTetEdges, kTriangleEdges and kEdgeEdges. In the file a mid-side node follows the
/// vertex before it.
inline constexpr std::array<std::uint8_t, 10> kUnvTetPlaces{0, 2, 4, 9, 1, 3, 5, 6, 7, 8};
inline constexpr std::array<std::uint8_t, 6> kUnvTrianglePlaces{0, 2, 4, 1, 3, 5};
inline constexpr std::array<std::uint8_t, 3> kUnvEdgePlaces{0, 2, 1};

/// The place of node k of an element with n nodes: vertices first, as in kUnvTetPlaces.
inline std::size_t unv_place(UnvElementKind::Role role, std::size_t n, std::size_t k) {
  if (role == UnvElementKind::Role::tetrahedron && n == kUnvTetPlaces.size()) return kUnvTetPlaces[k];
  if (role == UnvElementKind::Role::triangle && n == kUnvTrianglePlaces.size()) return kUnvTrianglePlaces[k];
  if (role == UnvElementKind::Role::edge && n == kUnvEdgePlaces.size()) return kUnvEdgePlaces[k];
  return k;
}

}  // namespace tetune

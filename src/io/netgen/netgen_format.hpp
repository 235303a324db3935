// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "backend/span.hpp"

namespace tetune {

/// The section of a file that lists an element.
enum class NetgenSection : std::uint8_t { surface, volume };

/// A kind of other elements in Netgen's files, by its number of nodes. Solids have the opposite orientation to those in
/// MEDIT's and VTK's files: vertex k there is vertex order[k] here, and vice versa.
struct NetgenKind {
  const char* kind;
  int vertices;
  NetgenSection section;
  std::array<int, 8> order;
};
inline constexpr std::array<NetgenKind, 4> kNetgenKinds{
    {{"Quadrilaterals", 4, NetgenSection::surface, {0, 1, 2, 3}},
     {"Pyramids", 5, NetgenSection::volume, {0, 3, 2, 1, 4}},
     {"Prisms", 6, NetgenSection::volume, {0, 2, 1, 3, 5, 4}},
     {"Hexahedra", 8, NetgenSection::volume, {0, 3, 2, 1, 4, 7, 6, 5}}}};

/// The places of tetune's vertices, and of the nodes in the middles of its edges as VTK numbers these, among the nodes
/// of tetrahedra and triangles.
inline constexpr std::array<int, 10> kNetgenTet{0, 2, 1, 3, 5, 7, 4, 6, 9, 8};
inline constexpr std::array<int, 6> kNetgenTriangle{0, 1, 2, 5, 3, 4};

/// Netgen's name of materials and boundary conditions without a name.
inline constexpr const char* kNetgenUnnamed = "default";
/// Data of triangles: the number of the face of the geometry.
inline constexpr const char* kNetgenSurface = "netgen:surface";
/// The type of identified points that are periodic.
inline constexpr int kNetgenPeriodic = 2;

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune {

/// A section of a MEDIT file that tetune keeps: its name in text, its code in binary (libMeshb's numbers).
struct MeditSection {
  std::string_view name;
  int code;
  int vertices;  ///< of one element; 0: a list of ids
};

inline constexpr int kMeditVersion = 1;
inline constexpr int kMeditDimension = 3;
inline constexpr int kMeditEnd = 54;
inline constexpr MeditSection kMeditVertices{"Vertices", 4, 1};

/// Elements that TetMesh has arrays for.
inline constexpr MeditSection kMeditEdges{"Edges", 5, 2};
inline constexpr MeditSection kMeditTriangles{"Triangles", 6, 3};
inline constexpr MeditSection kMeditTetrahedra{"Tetrahedra", 8, 4};

/// Elements kept as ElementBlock.
inline constexpr std::array<MeditSection, 4> kMeditOthers{{
    {"Quadrilaterals", 7, 4},
    {"Pyramids", 49, 5},
    {"Prisms", 9, 6},
    {"Hexahedra", 10, 8},
}};

inline constexpr MeditSection kMeditRequiredQuadrilaterals{"RequiredQuadrilaterals", 18, 0};

/// Lists of ids, and where each belongs.
struct MeditList {
  MeditSection section;
  std::vector<Index> TetMesh::*ids;
};
inline constexpr std::array<MeditList, 6> kMeditLists{{
    {{"Corners", 13, 0}, &TetMesh::corners},
    {{"RequiredVertices", 15, 0}, &TetMesh::required_vertices},
    {{"Ridges", 14, 0}, &TetMesh::ridges},
    {{"RequiredEdges", 16, 0}, &TetMesh::required_edges},
    {{"RequiredTriangles", 17, 0}, &TetMesh::required_triangles},
    {{"RequiredTetrahedra", 12, 0}, &TetMesh::required_tets},
}};

}  // namespace tetune

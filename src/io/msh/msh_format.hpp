// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>

#include "backend/span.hpp"
#include "io/second_order.hpp"

/// Gmsh's format, versions 2.2 and 4.1 (Gmsh's manual, Sect. "MSH file format"): what its reader and writer share.
namespace tetune {

/// Data of elements: the number of their entity, and that of their partition.
inline constexpr const char* kMshEntities = "gmsh:geometrical";
inline constexpr const char* kMshPartitions = "gmsh:partition";
/// Names of tags (TetMesh::cell_tags_name) that are numbers of groups, and of entities in files without groups.
inline constexpr const char* kMshGroupTags = "gmsh:physical";
inline constexpr const char* kMshEntityTags = kMshEntities;

/// The first line of the comments in which tetune notes the tags of entities in no group, as `dimension entity tag`.
inline constexpr std::string_view kMshLooseTags = "tetune: tags of entities in no physical group";

/// The lists in which a mesh has its elements: tetrahedra, triangles, edges, and the lists of other kinds and orders
/// (kind_of_list()).
inline constexpr std::size_t kMshTets = 0, kMshTriangles = 1, kMshEdges = 2, kMshFirstOther = 3;
inline constexpr std::size_t kMshLists = kMshFirstOther + kOtherLists;

/// A type of elements that tetune keeps.
struct MshType {
  int number;
  int dimension;
  int corners;
  int nodes;
  std::size_t list;
  const char* kind;  ///< ElementBlock::kind
};

inline constexpr std::array<MshType, kMshLists + 3> kMshTypes{{
    {4, 3, 4, 4, kMshTets, ""},
    {2, 2, 3, 3, kMshTriangles, ""},
    {1, 1, 2, 2, kMshEdges, ""},
    {15, 0, 1, 1, kMshFirstOther, "Points"},
    {3, 2, 4, 4, kMshFirstOther + 1, "Quadrilaterals"},
    {7, 3, 5, 5, kMshFirstOther + 2, "Pyramids"},
    {6, 3, 6, 6, kMshFirstOther + 3, "Prisms"},
    {5, 3, 8, 8, kMshFirstOther + 4, "Hexahedra"},
    {16, 2, 4, 8, kMshFirstOther + 5, "Quadrilaterals"},
    {19, 3, 5, 13, kMshFirstOther + 6, "Pyramids"},
    {18, 3, 6, 15, kMshFirstOther + 7, "Prisms"},
    {17, 3, 8, 20, kMshFirstOther + 8, "Hexahedra"},
    {11, 3, 4, 10, kMshTets, ""},
    {9, 2, 3, 6, kMshTriangles, ""},
    {8, 1, 2, 3, kMshEdges, ""},
}};

/// The type of a list; of tetrahedra, triangles and edges that of first order.
inline constexpr const MshType& msh_type_of(std::size_t list) { return kMshTypes[list]; }
/// The second-order type of tetrahedra, triangles or edges.
inline constexpr const MshType& msh_second_order_type_of(std::size_t list) { return kMshTypes[kMshLists + list]; }

inline constexpr const MshType* find_msh_type(std::int64_t number) {
  for (const MshType& type : kMshTypes) {
    if (type.number == number) return &type;
  }
  return nullptr;
}

/// The edges with nodes in their middles, in the order of these; of first-order types none.
inline std::span<const Pair> msh_middle_edges(const MshType& type) {
  if (type.nodes == type.corners) return {};
  if (type.list == kMshTets) return kGmshTetEdges;
  if (type.list == kMshTriangles) return kTriangleEdges;
  if (type.list == kMshEdges) return kEdgeEdges;
  return edges_of_kind(type.kind, MiddleOrder::gmsh);
}

}  // namespace tetune

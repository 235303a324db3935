// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vtkCellType.h>

#include <array>
#include <vector>

#include "plugin.hpp"

/// The types of cells and the names of arrays that reading and writing share.
namespace tetune::plugin {

/// VTK's types of other elements, by their lists (kind_of_list()).
inline constexpr std::array<int, kOtherLists> kOtherTypes{VTK_VERTEX,
                                                          VTK_QUAD,
                                                          VTK_PYRAMID,
                                                          VTK_WEDGE,
                                                          VTK_HEXAHEDRON,
                                                          VTK_QUADRATIC_QUAD,
                                                          VTK_QUADRATIC_PYRAMID,
                                                          VTK_QUADRATIC_WEDGE,
                                                          VTK_QUADRATIC_HEXAHEDRON};
inline constexpr const char* kOwnTags = "medit:ref";

/// Lists of vertices as flags, under the names of Mmg's Python package.
struct PointFlags {
  const char* name;
  std::vector<Index> TetMesh::*ids;
};
inline constexpr std::array<PointFlags, 2> kPointFlags{
    {{"mmg_required_vertices", &TetMesh::required_vertices}, {"mmg_corners", &TetMesh::corners}}};
inline constexpr const char* kRequiredEdges = "mmg_required_edges";
inline constexpr const char* kRidges = "mmg_ridge_edges";
inline constexpr const char* kRequiredTriangles = "mmg_required_triangles";
inline constexpr const char* kRequiredTets = "mmg_required_tetrahedra";
inline constexpr const char* kRequiredQuads = "mmg_required_quadrilaterals";

}  // namespace tetune::plugin

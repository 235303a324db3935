// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <array>
#include <map>
#include <utility>

#include "plugin.hpp"

namespace tetune::plugin {

inline constexpr const char* kPhysical = "gmsh:physical";
inline constexpr const char* kGeometrical = "gmsh:geometrical";

/// Gmsh's numbers of the element types that tetune reads.
inline constexpr int kEdge = 1, kTriangle = 2, kTet = 4, kEdge3 = 8, kTriangle6 = 9, kTet10 = 11;
/// Gmsh's numbers of the types of other elements, by their lists (kind_of_list()).
inline constexpr std::array<int, kOtherLists> kOtherTypes{15, 3, 7, 6, 5, 16, 19, 18, 17};

/// Reads the model that Gmsh has opened.
TetMesh from_gmsh(Warnings& warnings);
/// Makes a mesh the model of Gmsh; returns whether every element is in a group.
bool to_gmsh(TetMesh mesh, Warnings& warnings);

}  // namespace tetune::plugin

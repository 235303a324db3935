// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <array>
#include <limits>
#include <map>
#include <utility>

#include "plugin.hpp"

namespace tetune::plugin {

inline constexpr const char* kPhysical = "gmsh:physical";
inline constexpr const char* kGeometrical = "gmsh:geometrical";

/// Gmsh's numbers of the element types that tetune reads.
inline constexpr int kEdge = 1, kTriangle = 2, kTet = 4, kEdge3 = 8, kTriangle6 = 9, kTet10 = 11;
/// In the order of kElementKinds.
inline constexpr std::array<int, 5> kOtherTypes{15, 3, 7, 6, 5};

/// The limits of a format.
struct Format {
  int max_entity = std::numeric_limits<int>::max();  ///< largest number of an entity
};

/// Reads the model that Gmsh has opened.
TetMesh from_gmsh(Warnings& warnings);
/// Makes a mesh the model of Gmsh; returns whether every element is in a group.
bool to_gmsh(TetMesh mesh, const Format& format, Warnings& warnings);

}  // namespace tetune::plugin

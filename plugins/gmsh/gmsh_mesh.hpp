// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <array>

#include "plugin.hpp"

namespace tetune::plugin {

inline constexpr const char* kPhysical = "gmsh:physical";
inline constexpr const char* kGeometrical = "gmsh:geometrical";

/// Gmsh's numbers of the element types that tetune takes.
inline constexpr int kEdge = 1, kTriangle = 2, kTet = 4, kEdge3 = 8, kTriangle6 = 9, kTet10 = 11;
/// In the order of kOtherKinds.
inline constexpr std::array<int, 5> kOtherTypes{15, 3, 7, 6, 5};

/// Reads what Gmsh has opened, and hands a mesh over to Gmsh.
TetMesh from_gmsh(Warnings& warnings);
/// `classify`: nodes are given to entities. Returns whether each element is in a physical group.
bool to_gmsh(TetMesh mesh, bool classify, Warnings& warnings);
/// Names the data that other formats than .msh have no room for.
void warn_of_data(const TetMesh& mesh, Warnings& warnings);
/// Appends point and element data to an .msh file.
void append_data(const std::string& file, const TetMesh& mesh, Warnings& warnings);

}  // namespace tetune::plugin

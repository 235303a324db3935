// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>

#include "tetune/export.hpp"
#include "tetune/mesh.hpp"

/// Periodic meshes: optimize() moves linked vertices together (TetMesh::periodic).
namespace tetune {

/// Links the vertices of the opposite faces of a box along the chosen axes: one link per axis is added to
/// TetMesh::periodic, from the face of the smallest coordinate to that of the largest. Throws MeshError where a vertex
/// of one face has none opposite, within 1e-9 of the longest side; then the mesh is as before.
TETUNE_API void link_box_faces(TetMesh& mesh, const std::array<bool, 3>& axes);

/// Adds the links of a text file. A line "translation X Y Z" begins a link; each line "VERTEX MASTER" after it is a
/// pair, in numbers from 1: the vertex is at the master's position plus the translation, within 1e-9 of the longest
/// side of the mesh. '#' starts a comment. Throws FileError; then the mesh is as before.
TETUNE_API void read_periodic_map(const std::string& path, TetMesh& mesh);

}  // namespace tetune

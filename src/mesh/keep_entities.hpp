// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "tetune/mesh.hpp"

/// Dropping entities of a mesh, and renumbering the references to those that stay.
namespace tetune {

/// The new positions of a list's entries when those with keep[i] == 0 are dropped; -1 for these.
std::vector<Index> positions_of_kept(const std::vector<std::uint8_t>& keep);

/// Moves the listed triangles or edges to their new positions and renumbers references to them; returns the number of
/// dropped ones.
std::int64_t keep_triangles(TetMesh& mesh, const std::vector<Index>& old2new) noexcept;
std::int64_t keep_edges(TetMesh& mesh, const std::vector<Index>& old2new) noexcept;

/// Moves the vertices to their new positions and renumbers all references to them. Vertices without a new position must
/// be in no element; they are removed from the corners.
void keep_vertices(TetMesh& mesh, const std::vector<Index>& old2new) noexcept;

}  // namespace tetune

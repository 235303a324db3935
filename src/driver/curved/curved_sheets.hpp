// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "curved/surface_middles.hpp"

/// The surface of a mesh by its sheets.
namespace tetune {

/// The triangles of the boundary, between regions and with a tag.
std::vector<SheetTriangle> find_sheets(const TetMesh& mesh);

/// Listed edges that may be feature lines: ridges and required ones, and tagged ones unless they meet at many vertices,
/// as where a program lists every edge.
std::vector<std::array<Index, 2>> find_lines(const TetMesh& mesh);

}  // namespace tetune

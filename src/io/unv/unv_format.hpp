// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "tetune/mesh.hpp"

namespace tetune {

/// TetMesh::dialect starts with this where it has the lines of the data set of units of the file that was read.
inline constexpr std::string_view kUnvDialect = "unv\n";

/// The unit of length of the universal file that the mesh was read from; empty if it is the meter, or not known.
std::string unv_length_unit(const TetMesh& mesh);

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "tetune/mesh.hpp"

namespace tetune {

/// TetMesh::dialect of a universal file is this, the number of its data set of groups, the end of a line, and the lines
/// of its data set of units.
inline constexpr std::string_view kUnvDialect = "unv ";
/// The data set of groups that most programs read, and the only one that Gmsh reads.
inline constexpr const char* kUnvGroups = "2467";
inline constexpr const char* kUnvGroupsOfGmsh = "2477";

/// The lines of units in TetMesh::dialect.
inline std::string_view unv_units(const TetMesh& mesh) {
  const std::string_view dialect = mesh.dialect;
  return dialect.starts_with(kUnvDialect) ? dialect.substr(dialect.find('\n') + 1) : std::string_view();
}
/// The unit of length of the universal file that the mesh was read from; empty if it is the meter, or not known.
std::string unv_length_unit(const TetMesh& mesh);

}  // namespace tetune

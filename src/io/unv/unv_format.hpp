// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "tetune/mesh.hpp"

namespace tetune {

/// The start of TetMesh::dialect of a universal file. The number of its data set of groups, the end of a line, and the
/// lines of its data set of units follow.
inline constexpr std::string_view kUnvDialect = "unv ";
/// The data sets of groups: the one that most programs read, and the only one that Gmsh reads.
inline constexpr const char* kUnvGroups = "2467";
inline constexpr const char* kUnvGroupsOfGmsh = "2477";

/// The columns of an integer (format I10), of a real number of single precision (1PE13.5) and of double (1PD25.16).
inline constexpr std::size_t kUnvIntegerWidth = 10, kUnvSingleWidth = 13, kUnvRealWidth = 25;

/// The codes of the entities of a group that are nodes and elements.
inline constexpr std::int64_t kUnvNode = 7, kUnvElement = 8;

/// The lines of units in TetMesh::dialect; empty for a mesh of another format.
inline std::string_view unv_units(const TetMesh& mesh) {
  const std::string_view dialect = mesh.dialect;
  return dialect.starts_with(kUnvDialect) ? dialect.substr(dialect.find('\n') + 1) : std::string_view();
}
/// The integer with which a text starts, after blanks; 0 where there is none, or one beyond 32 bits.
int leading_unv_integer(std::string_view text);
/// The unit of length of the universal file that the mesh was read from; empty if it is the meter, or not known.
std::string unv_length_unit(const TetMesh& mesh);

}  // namespace tetune

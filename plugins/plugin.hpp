// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mesh/element_kinds.hpp"
#include "system/path.hpp"
#include "tetune/error.hpp"
#include "tetune/mesh.hpp"

/// The functions that each plugin defines for program.cpp. Messages do not name the file; tetune adds its name.
namespace tetune::plugin {

using Warnings = std::vector<std::string>;

/// check() throws FileError unless the library has the format of this name; the others where they fail.
void check(const std::string& file);
/// `time`: the number of one of times(), from 1; 0: the first, or that of a file without times.
TetMesh read(const std::string& file, int time, Warnings& warnings);
/// The times whose values the file has. Called for formats that have them (Format::has_times).
std::vector<double> times(const std::string& file);
void write(const std::string& file, TetMesh mesh, Warnings& warnings);

/// Entry i of a list, for the signed indices of meshes and libraries.
template <class List, class Integer>
decltype(auto) item(List& list, Integer i) {
  return list[static_cast<std::size_t>(i)];
}
/// The length of a list as an index of a mesh, which is below 2^31.
template <class List>
Index index_count(const List& list) {
  return static_cast<Index>(list.size());
}
/// The range of a list that holds entry i of `size` values.
template <class List>
auto entry_of(List& list, std::int64_t i, std::size_t size) {
  return std::span(list).subspan(static_cast<std::size_t>(i) * size, size);
}
/// The number of values per entry.
inline std::size_t components_of(const DataArray& array) { return static_cast<std::size_t>(array.components); }

}  // namespace tetune::plugin

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tetune/error.hpp"
#include "tetune/mesh.hpp"

/// What each plugin defines; program.cpp calls it. Messages do not name the file, tetune does.
namespace tetune::plugin {

using Warnings = std::vector<std::string>;

/// All throw FileError. check(): unless the library has the format of this name.
void check(const std::string& file);
TetMesh read(const std::string& file, Warnings& warnings);
void write(const std::string& file, TetMesh mesh, Warnings& warnings);

inline std::string ending_of(const std::string& file) { return std::filesystem::path(file).extension().string(); }

/// Kinds of elements that are kept as they are, by their number of vertices.
struct OtherKind {
  const char* name;
  int vertices;
  int dimension;
};
inline constexpr OtherKind kOtherKinds[] = {
    {kPoints, 1, 0}, {"Quadrilaterals", 4, 2}, {"Pyramids", 5, 3}, {"Prisms", 6, 3}, {"Hexahedra", 8, 3}};

}  // namespace tetune::plugin

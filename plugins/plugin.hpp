// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
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

/// Positive numbers that are not taken yet, from the lowest up.
class FreeNumbers {
 public:
  explicit FreeNumbers(std::set<int> taken) : taken_(std::move(taken)) {}
  /// Whether the number was free; now it is taken.
  bool take(int number) { return taken_.insert(number).second; }
  int take_lowest() {
    while (!take(lowest_)) ++lowest_;
    return lowest_;
  }

 private:
  std::set<int> taken_;
  int lowest_ = 1;
};

}  // namespace tetune::plugin

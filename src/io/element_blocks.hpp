// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "tetune/mesh.hpp"

namespace tetune {

/// The block of a kind of elements of a mesh, which is appended where the mesh has none.
inline ElementBlock& element_block(TetMesh& mesh, std::string_view kind, int vertices) {
  for (ElementBlock& block : mesh.others) {
    if (block.kind == kind) return block;
  }
  return mesh.others.emplace_back(ElementBlock{std::string(kind), vertices, {}, {}, {}});
}

}  // namespace tetune

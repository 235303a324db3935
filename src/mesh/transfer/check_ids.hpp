// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "mesh/work_mesh.hpp"
#include "tetune/error.hpp"

namespace tetune {

/// Throws MeshError for an id below 0 that is not kInserted.
inline void check_not_negative(const std::vector<Index>& map, const std::string& name) {
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (map[i] >= kInserted) continue;
    throw MeshError(name + "[" + std::to_string(i) + "] is " + std::to_string(map[i]) +
                    "; it must be the id of a vertex or element, or -1 for none");
  }
}

}  // namespace tetune

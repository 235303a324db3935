// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "par/macros.hpp"
#include "par/prefetch.hpp"
#include "par/span.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// For loops over the tetrahedra of a caller's mesh: as meshers list them, their vertices are anywhere in memory.
TETUNE_INLINE void fetch_ahead(const TetMesh& mesh, par::Size t) {
  constexpr par::Size kAhead = 12;
  if (t + kAhead >= static_cast<par::Size>(mesh.tets.size())) return;
  for (const Index v : mesh.tets[static_cast<std::size_t>(t + kAhead)]) {
    par::prefetch(&mesh.points[static_cast<std::size_t>(v)]);
  }
}

}  // namespace tetune

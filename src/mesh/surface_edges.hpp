// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "backend/span.hpp"
#include "mesh/sorted.hpp"
#include "mesh/tet.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// The vertices and edges of the boundary and of the faces between regions.
class SurfaceEdges {
 public:
  explicit SurfaceEdges(const TetMesh& mesh);

  /// 1 per vertex on the surface.
  const std::vector<std::uint8_t>& on_surface() const { return on_surface_; }
  /// Whether an edge leads through the inside from one point of the surface to another.
  bool is_across(Index a, Index b) const {
    return span_of(on_surface_)[a] != 0 && span_of(on_surface_)[b] != 0 && !is_listed(edges_, ascending(a, b));
  }

 private:
  std::vector<std::uint8_t> on_surface_;
  std::vector<std::array<Index, 2>> edges_;  ///< in increasing order
};

}  // namespace tetune

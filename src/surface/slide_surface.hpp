// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/motion.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// What a mesh slides on where that is not the surface it comes with: the surface that its vertices were on before they
/// first moved, while parts of it are optimised in turn. All in the mesh's vertices. Where it reaches beyond the mesh,
/// the mesh has vertices that are in no tetrahedron.
struct SlideSurface {
  std::vector<Point3> points;              ///< where each vertex was
  std::vector<Mobility> kind;              ///< of each vertex: where it may go
  std::vector<std::array<Index, 2>> line;  ///< for each vertex of Mobility::curve, the next ones along its line
  std::vector<std::array<Index, 3>> site;  ///< the triangle, edge or vertex of the surface on which each vertex is now;
                                           ///< vertices that are too many are -1
  std::vector<std::array<Index, 3>> triangles;
  std::vector<std::uint8_t> walls;  ///< of each triangle: bit k says that there is no way across the edge opposite k
};

/// A site that is none.
inline constexpr std::array<Index, 3> kNoSite{-1, -1, -1};

}  // namespace tetune

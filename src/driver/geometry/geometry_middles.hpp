// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "tetune/geometry.hpp"

namespace tetune {

/// Mid-side nodes on a CAD model.
struct GeometryMiddles {
  std::vector<CurvedEdge> edges;  ///< of the surface, sorted by vertices
  /// Number of edges of the surface that stay straight because it is not clear what they are on, or because that is
  /// farther from the midpoint than a quarter of the edge.
  std::int64_t off_geometry = 0;
};

/// Projects the midpoints of a straight mesh's surface onto the edges and faces of the model that the mesh's edges are
/// on. Throws as Geometry::match() does.
GeometryMiddles find_geometry_middles(const TetMesh& mesh, const Geometry& geometry);

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "boundary/vertex_dof.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// The places of the vertices of a mesh on a surface. Unused vertices of an element are -1.
struct PlacesOnSurface {
  /// Per vertex: the vertices of the triangle, edge or vertex of the surface on which it is now.
  std::vector<std::array<Index, 3>> surface_point;
  /// The checked surface (DeviationBound): per vertex its position and surface point. Empty before the first run. All
  /// runs must have the same bound on the deviation, or none.
  std::vector<Point3> checked_points;
  std::vector<std::array<Index, 3>> checked_surface_point;
};

/// A surface for the vertices of a mesh to slide on that need not be the mesh's own: the surface that the vertices were
/// on before they first moved, while parts of the mesh are optimized in turn. All ids are the mesh's vertices; where
/// the surface reaches beyond the mesh, the mesh has vertices that are in no tetrahedron.
struct SlideSurface : PlacesOnSurface {
  std::vector<Point3> points;              ///< the initial position of each vertex
  std::vector<VertexDof> dof;              ///< per vertex: where it may go
  std::vector<std::array<Index, 2>> line;  ///< per vertex of VertexDof::curve: the next ones along its line
  std::vector<std::array<Index, 3>> triangles;
  std::vector<std::uint8_t> feature_edges;  ///< per triangle: bit k is set where the edge opposite k is a feature edge
};

/// The surface point of a vertex that is not on the surface.
inline constexpr std::array<Index, 3> kNoSurfacePoint{-1, -1, -1};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "boundary/vertex_dofs.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// A surface for the vertices of a mesh to slide on that need not be the mesh's own: the surface that the vertices were
/// on before they first moved, while parts of the mesh are optimized in turn. All ids are the mesh's vertices; where
/// the surface reaches beyond the mesh, the mesh has vertices that are in no tetrahedron.
struct SlideSurface {
  std::vector<Point3> points;              ///< the initial position of each vertex
  std::vector<VertexDof> kind;             ///< per vertex: where it may go
  std::vector<std::array<Index, 2>> line;  ///< per vertex of VertexDof::curve: the next ones along its line
  std::vector<std::array<Index, 3>> site;  ///< per vertex: the vertices of the triangle, edge or vertex of the surface
                                           ///< on which it is now; unused entries are -1
  std::vector<std::array<Index, 3>> triangles;
  std::vector<std::uint8_t> walls;  ///< per triangle: bit k is set where the edge opposite k is a feature edge
};

/// The surface point of a vertex that is not on the surface.
inline constexpr std::array<Index, 3> kNoSite{-1, -1, -1};

/// Makes a given surface the reference surface, and decides where each vertex may go; one that is not on it is fixed.
/// `scale`: coordinates of the work mesh per unit of the caller's.
template <class Backend>
void import_slide_surface(const Backend& backend, const SlideSurface& given, const std::vector<Index>& original2vertex,
                          Span<const std::uint8_t> frozen, double scale, VertexDofs<Backend>& dofs);

/// The surface that the vertices of a mesh slide on at the start: the reference surface in the caller's ids.
template <class Backend>
SlideSurface export_slide_surface(const ReferenceSurface<Backend>& reference, const std::vector<Point3>& points,
                                  const std::vector<Index>& vertex2original);

/// The current surface points of the vertices, as in SlideSurface::site.
template <class Backend>
std::vector<std::array<Index, 3>> export_surface_points(const Backend& backend, const VertexDofs<Backend>& dofs,
                                                        const std::vector<Index>& vertex2original);

}  // namespace tetune

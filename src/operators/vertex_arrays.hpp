// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/sliding/reference_surface.hpp"
#include "boundary/vertex_dof.hpp"
#include "mesh/work_mesh.hpp"

namespace tetune {

/// The arrays of the vertices that operators write which insert or remove some.
struct VertexArrays {
  Span<Index> vertex2original;
  Span<VertexDof> kind;
  Span<Vec3> axis;
  Span<SurfacePoint> surface_point;  ///< empty unless vertices slide
  Span<std::uint8_t> constrained_vertex;

  TETUNE_HD void insert(Index v) const {
    vertex2original[v] = kInserted;
    kind[v] = VertexDof::free;
    axis[v] = {0, 0, 0};
    if (surface_point.size() > 0) surface_point[v] = {};
    constrained_vertex[v] = 0;
  }
};

}  // namespace tetune

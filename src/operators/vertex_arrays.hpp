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
  Span<DisplacementBound> displacement_bound;  ///< may be empty

  /// Initializes a new vertex; `radius` is that of its displacement bound.
  TETUNE_HD void insert(Index v, const Vec3& x, VertexDof dof, const Vec3& direction, double radius) const {
    vertex2original[v] = kInserted;
    kind[v] = dof;
    axis[v] = direction;
    if (surface_point.size() > 0) surface_point[v] = {};
    if (displacement_bound.size() > 0) displacement_bound[v] = {x, radius};
    constrained_vertex[v] = 0;
  }
};

}  // namespace tetune

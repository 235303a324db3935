// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/sliding/reference_surface.hpp"
#include "boundary/vertex_dof.hpp"
#include "mesh/work_mesh.hpp"

namespace tetune {

/// Where a new vertex may go.
struct NewVertexDof {
  VertexDof dof = VertexDof::free;
  Vec3 axis{0, 0, 0};
  double radius = DisplacementBound::kUnbounded;  ///< of its displacement bound
  SurfacePoint surface_point = {};                ///< where it slides: its place on the reference surface
};

/// The vertex arrays that insertion and contraction write.
struct VertexArrays {
  Span<Index> vertex2original;
  Span<VertexDof> dof;
  Span<Vec3> axis;
  Span<SurfacePoint> surface_point;  ///< empty unless vertices slide
  Span<std::uint8_t> constrained_vertex;
  Span<DisplacementBound> displacement_bound;  ///< may be empty
  CheckedSurfaceView checked;                  ///< empty without a bound on the deviation

  /// Initializes a new vertex at x.
  TETUNE_HD void insert(Index v, const Vec3& x, const NewVertexDof& inserted) const {
    vertex2original[v] = kInserted;
    dof[v] = inserted.dof;
    axis[v] = inserted.axis;
    if (surface_point.size() > 0) surface_point[v] = inserted.surface_point;
    if (displacement_bound.size() > 0) displacement_bound[v] = {x, inserted.radius};
    if (checked.points.size() > 0) {
      checked.points[v] = point(x);
      checked.surface_points[v] = inserted.surface_point;
    }
    if (checked.edited_points.size() > 0) {
      checked.edited_points[v] = point(x);
      checked.is_edited[v] = 1;
    }
    constrained_vertex[v] = 0;
  }
};

}  // namespace tetune

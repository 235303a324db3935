// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/sliding/reference_surface.hpp"
#include "boundary/vertex_dof.hpp"

namespace tetune {

/// The part of the bound on the deviation by which vertices may drift from the checked or the edited surface.
inline constexpr double kDriftShare = 1.0 / 3;

/// VertexDofs as kernels access them.
struct DofsView {
  Span<const VertexDof> dof;
  Span<const Vec3> axis;
  Span<SurfacePoint> surface_point;
  ReferenceView reference;
  Span<const DisplacementBound> displacement_bound;
  CheckedSurfaceView checked;
  double max_deviation;
  Span<std::uint8_t> active;
};

/// Where each vertex may go, where it is on the reference surface, and which vertices a sweep visits.
template <class Backend>
struct VertexDofs {
  BufferOf<Backend, VertexDof> dof;
  BufferOf<Backend, Vec3> axis;
  /// The position of each vertex on the reference surface, and that surface; empty unless vertices slide.
  BufferOf<Backend, SurfacePoint> surface_point;
  ReferenceSurface<Backend> reference;
  /// Per vertex; meaningful on the surface. Empty: unbounded.
  BufferOf<Backend, DisplacementBound> displacement_bound;
  /// The largest distance between the mesh's surface and the reference surface by moves of vertices (0: no bound), and
  /// the surface that it is tested on.
  double max_deviation = 0;
  CheckedSurface<Backend> checked;
  /// The active vertices: 1 where at its last visit the vertex, or since then a vertex of its ring, moved by more than
  /// kActivationThreshold at once, or a flip changed its ring.
  BufferOf<Backend, std::uint8_t> active;
  DofsView view() {
    return {dof, axis, surface_point, reference.view(), displacement_bound, checked.view(), max_deviation, active};
  }
  /// The surface whose neighbors color_vertices() must separate: that of the bound on the deviation.
  ReferenceView stars() const { return max_deviation > 0 ? reference.view() : ReferenceView{}; }
};

}  // namespace tetune

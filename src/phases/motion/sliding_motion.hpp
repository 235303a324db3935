// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>

#include "boundary/sliding/trace.hpp"
#include "phases/motion/harmonic_extension.hpp"
#include "phases/working_set.hpp"

/// The motion of vertices that slide on the reference surface (docs/method.md, "Moving a mesh").
namespace tetune {

/// How a motion prescribes a vertex, as bits.
enum VertexMotion : std::uint8_t {
  kPrescribed = 1,  ///< it has a position in a target
  kMoves = 2,       ///< that position differs from the one in the input
};

namespace sliding_motion_detail {

/// Finds the tangent plane or tangent of the reference surface at each vertex that slides; others keep their space of
/// motion.
struct FindTangentSpace {
  ReferenceView reference;
  Span<const SurfacePoint> surface_point;
  Span<const VertexDof> dof;
  Span<const Vec3> axis;
  Span<VertexDof> tangent_dof;
  Span<Vec3> tangent_axis;

  TETUNE_HD void operator()(Size v) const {
    tangent_dof[v] = dof[v];
    tangent_axis[v] = axis[v];
    if (!slides(dof[v])) return;
    const bool on_line = dof[v] == VertexDof::curve;
    const Vec3 direction = on_line ? tangent(surface_point[v]) : normal(surface_point[v]);
    const double length = norm(direction);
    tangent_dof[v] = !(length > 0) ? VertexDof::fixed : on_line ? VertexDof::line : VertexDof::plane;
    if (length > 0) tangent_axis[v] = (1 / length) * direction;
  }

 private:
  TETUNE_HD Vec3 tangent(const SurfacePoint& on) const {
    if (on.kind == SurfacePointKind::vertex) {
      const LineVertex line = reference.line[on.item];
      return reference.point(line.next[1]) - reference.point(line.next[0]);
    }
    const EdgeVertices e = edge_vertices(reference, on);
    return reference.point(e.b) - reference.point(e.a);
  }
  TETUNE_HD Vec3 normal(const SurfacePoint& on) const {
    Vec3 sum{0, 0, 0};
    if (on.kind == SurfacePointKind::vertex) {
      for (Size c = reference.vertex2corner.begin(on.item); c < reference.vertex2corner.end(on.item); ++c) {
        add(reference.vertex2corner.items[c] / 3, sum);
      }
    } else if (on.kind == SurfacePointKind::edge) {
      add(on.item / 3, sum);
      const Index opposite = reference.across[on.item];
      if (opposite != kFeatureEdge) add(opposite / 3, sum);
    } else {
      add(on.item, sum);
    }
    return sum;
  }
  /// Adds the area normal of a triangle. Triangles of interfaces come from either side: all are turned into one half
  /// space.
  TETUNE_HD void add(Size triangle, Vec3& sum) const {
    const SurfaceTriangle t = reference.triangles[triangle];
    const Vec3 x = reference.point(t.v[0]);
    const Vec3 n = cross(reference.point(t.v[1]) - x, reference.point(t.v[2]) - x);
    sum = dot(n, sum) < 0 ? sum - n : sum + n;
  }
};

/// Finds where vertices that slide are after a part of their displacement, which is projected on the reference surface.
struct FindSlidEnd {
  ReferenceView reference;
  Span<const Point> points;
  Span<const Vec3> displacement;
  Span<const VertexDof> dof;
  Span<const SurfacePoint> surface_point;
  double part;
  Span<Vec3> end;
  Span<SurfacePoint> end_point;
  TETUNE_HD void operator()(Size v) const {
    if (!slides(dof[v])) return;
    // A motion may pass many triangles of a fine surface.
    constexpr int kMaxTraceSteps = 4096;
    SurfacePoint on = surface_point[v];
    const Vec3 x = vec(points[v]);
    end[v] = project_on_reference(reference, dof[v], x, x + part * displacement[v], on, kMaxTraceSteps);
    end_point[v] = on;
  }
};

struct SetSurfacePoint {
  Span<const VertexDof> dof;
  Span<const SurfacePoint> end_point;
  Span<SurfacePoint> surface_point;
  TETUNE_HD void operator()(Size v) const {
    if (slides(dof[v])) surface_point[v] = end_point[v];
  }
};

/// Makes the edges of triangles that leave the reference surface walls for the vertices that slide: triangles all of
/// whose vertices are prescribed, and some of which move.
struct CutMovingTriangle {
  Span<const SurfaceTriangle> triangles;
  Span<const std::uint8_t> motion;  ///< per vertex: VertexMotion
  Span<Index> across;
  TETUNE_HD void operator()(Size corner) const {
    const Index opposite = across[corner];
    if (opposite == kFeatureEdge) return;
    if (leaves(corner / 3) || leaves(Size{opposite} / 3)) across[corner] = kFeatureEdge;
  }

 private:
  TETUNE_HD bool leaves(Size triangle) const {
    unsigned all = kPrescribed | kMoves;
    unsigned any = 0;
    for (const Index v : triangles[triangle].v) {
      all &= motion[v];
      any |= motion[v];
    }
    return (all & kPrescribed) != 0 && (any & kMoves) != 0;
  }
};

}  // namespace sliding_motion_detail

/// Takes the triangles all of whose vertices are prescribed, and some of which move, out of the reference surface.
/// `motion`: per vertex, VertexMotion.
template <class Backend>
void cut_moving_triangles(const Backend& backend, Span<const std::uint8_t> motion,
                          ReferenceSurface<Backend>& reference) {
  const Span<Index> across = reference.across.span();
  backend.for_each(across.size(), sliding_motion_detail::CutMovingTriangle{reference.triangles.span(), motion, across});
}

/// The motion of the vertices that slide, in a backend's memory. Empty if none does.
template <class Backend>
class SlidingMotion {
 public:
  /// Finds the spaces in which displacements are to be: tangential for vertices that slide. They are valid until the
  /// next call.
  MotionSpaces find_spaces(const Backend& backend, WorkingSet<Backend>& work) {
    const DofsView dofs = work.dofs.view();
    if (dofs.surface_point.size() == 0) return {dofs.dof, dofs.axis};
    tangent_dof_.resize(backend, work.mesh.vertices());
    tangent_axis_.resize(backend, work.mesh.vertices());
    backend.for_each(work.mesh.vertices(),
                     sliding_motion_detail::FindTangentSpace{dofs.reference, dofs.surface_point, dofs.dof, dofs.axis,
                                                             tangent_dof_.span(), tangent_axis_.span()});
    return {std::as_const(tangent_dof_).span(), std::as_const(tangent_axis_).span()};
  }

  /// Returns the positions of the vertices that slide after a part of their displacement; an empty span if none does.
  Span<const Vec3> find_ends(const Backend& backend, WorkingSet<Backend>& work, Span<const Vec3> displacement,
                             double part) {
    const DofsView dofs = work.dofs.view();
    if (dofs.surface_point.size() == 0) return {};
    end_.resize(backend, work.mesh.vertices());
    end_point_.resize(backend, work.mesh.vertices());
    backend.for_each(work.mesh.vertices(),
                     sliding_motion_detail::FindSlidEnd{dofs.reference, work.mesh.points.span(), displacement, dofs.dof,
                                                        dofs.surface_point, part, end_.span(), end_point_.span()});
    return std::as_const(end_).span();
  }

  /// Sets the surface points of the vertices to those of the last call of find_ends().
  void set_surface_points(const Backend& backend, WorkingSet<Backend>& work) {
    const DofsView dofs = work.dofs.view();
    if (dofs.surface_point.size() == 0) return;
    backend.for_each(work.mesh.vertices(),
                     sliding_motion_detail::SetSurfacePoint{dofs.dof, end_point_.span(), dofs.surface_point});
  }

 private:
  BufferOf<Backend, VertexDof> tangent_dof_;
  BufferOf<Backend, Vec3> tangent_axis_;
  BufferOf<Backend, Vec3> end_;
  BufferOf<Backend, SurfacePoint> end_point_;
};

}  // namespace tetune

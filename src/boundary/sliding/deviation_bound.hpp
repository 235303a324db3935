// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/sliding/fan_deviation.hpp"
#include "boundary/sliding/line_deviation.hpp"
#include "boundary/sliding/triangle_deviation.hpp"

namespace tetune {

/// The bound on the distance between the mesh's surface and the reference surface, for moves of one vertex.
///
/// Over each triangle of the mesh's surface the reference is a height function. It is piecewise linear, so its maximum
/// is at a corner of a reference triangle clipped to the prism over the surface triangle; where all heights are within
/// the bound, so is the distance in both directions. In the wedge between the prisms of two triangles the distance from
/// their common edge is convex, so the reference vertices there are tested. Along feature lines the same is done in one
/// dimension.
///
/// There are two tests of a triangle, neither of which accepts one beyond the bound. FanDeviation is fast: it processes
/// all triangles at a vertex at once, and leaves some undecided. TriangleDeviation decides any triangle. Vertices that
/// slide on the surface take the fast test first, if SurfaceFan::build() succeeds, and the other one for the undecided
/// triangles; vertices on feature lines, and all other fans, take TriangleDeviation alone.
template <class Pack>
class DeviationBound {
 public:
  /// A limit of 0 is no bound.
  TETUNE_HD DeviationBound(const ReferenceView& ref, Span<const Point> points, Span<const SurfacePoint> surface_points,
                           Index vertex, double limit)
      : ref_(ref), points_(points), surface_points_(surface_points), vertex_(vertex), limit_(limit) {}

  /// Whether the vertex may be at x, which is at the surface point `on`.
  TETUNE_HD bool allows(const Vec3& x, const SurfacePoint& on) const {
    if (!(limit_ > 0)) return true;
    if (ref_.dof[vertex_] == VertexDof::curve && !lines_are_within(x, on)) return false;
    const TriangleDeviation triangle_test(ref_, points_, surface_points_, vertex_, limit_);
    if (ref_.dof[vertex_] == VertexDof::surface) {
      SurfaceFan<Pack> fan;
      if (fan.build(ref_, points_, vertex_, x)) {
        FanMask undecided = 0;
        FanDeviation<Pack> fan_test(fan, ref_, surface_points_, triangle_test, limit_);
        if (!fan_test.is_within(on, undecided)) return false;
        for (int i = 0; i < fan.count; ++i) {
          if ((undecided >> i & 1) != 0 && !triangle_test.is_within(fan.corner[i], x, on)) return false;
        }
        return true;
      }
    }
    for (Size c = ref_.vertex2corner.begin(vertex_); c < ref_.vertex2corner.end(vertex_); ++c) {
      if (!triangle_test.is_within(ref_.vertex2corner.items[c], x, on)) return false;
    }
    return true;
  }

 private:
  TETUNE_HD bool lines_are_within(const Vec3& x, const SurfacePoint& on) const {
    const LineDeviation line_test(ref_, limit_);
    for (const Index neighbor : ref_.line[vertex_].next) {
      if (!line_test.is_within(x, on, vec(points_[neighbor]), surface_points_[neighbor])) return false;
    }
    return true;
  }

  const ReferenceView& ref_;
  Span<const Point> points_;
  Span<const SurfacePoint> surface_points_;
  Index vertex_;
  double limit_;
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/sliding/axis_deviation.hpp"
#include "boundary/sliding/fan_deviation.hpp"
#include "boundary/sliding/triangle_deviation.hpp"

namespace tetune {

/// The test whether the reference feature line between a vertex at x and its neighbor on the line is within the bound
/// of the edge between them.
class LineDeviation {
 public:
  TETUNE_HD LineDeviation(const ReferenceView& ref, double limit) : ref_(ref), limit_(limit) {}

  TETUNE_HD bool is_within(const Vec3& x, const SurfacePoint& on, const Vec3& neighbor,
                           const SurfacePoint& neighbor_on) const {
    const Vec3 e = neighbor - x;
    const double length2 = dot(e, e);
    const EdgeVertices goal = interval(neighbor_on);
    const EdgeVertices start = interval(on);
    for (int side = 0; side < 2; ++side) {
      const bool on_vertex = start.a == start.b;
      const Index from = on_vertex || side == 0 ? start.a : start.b;
      const Index to = on_vertex ? ref_.line[start.a].next[side] : side == 0 ? start.b : start.a;
      if (same({from, to}, goal) || reaches(from, to, goal, x, e, length2)) return true;
    }
    return false;
  }

 private:
  static constexpr int kMaxSegments = 64;

  /// Whether the line, from one of its vertices on to the next, reaches the goal while all its vertices are within the
  /// bound of the edge e from x.
  TETUNE_HD bool reaches(Index from, Index at, const EdgeVertices& goal, const Vec3& x, const Vec3& e,
                         double length2) const {
    for (int i = 0; i < kMaxSegments; ++i) {
      if (goal.a == goal.b && at == goal.a) return true;
      const Vec3 d = ref_.point(at) - x;
      double s = length2 > 0 ? dot(d, e) / length2 : 0;
      s = s < 0 ? 0 : s > 1 ? 1 : s;
      const Vec3 off = d - s * e;
      if (!(dot(off, off) <= kDeviationShare * kDeviationShare * limit_ * limit_)) return false;
      if (ref_.dof[at] != VertexDof::curve) return false;
      const LineVertex line = ref_.line[at];
      const Index next = line.next[0] == from ? line.next[1] : line.next[0];
      if (same({at, next}, goal)) return true;
      from = at;
      at = next;
    }
    return false;
  }

  /// The segment of the line that a point is on; a vertex counts as a segment from itself to itself.
  TETUNE_HD EdgeVertices interval(const SurfacePoint& on) const {
    return on.kind == SurfacePointKind::segment ? edge_vertices(ref_, on) : EdgeVertices{on.item, on.item};
  }
  TETUNE_HD static bool same(const EdgeVertices& p, const EdgeVertices& q) {
    return (p.a == q.a && p.b == q.b) || (p.a == q.b && p.b == q.a);
  }

  const ReferenceView& ref_;
  double limit_;
};

/// The test whether a surface with the triangles of the reference is within a distance of it, in both directions, for
/// moves of one vertex. Requires a distance above 0.
///
/// Over each triangle of the tested surface the reference is a height function. It is piecewise linear, so its maximum
/// is at a corner of a reference triangle clipped to the prism over the surface triangle; where all heights are within
/// the bound, so is the distance in both directions. In the wedge between the prisms of two triangles the distance from
/// their common edge is convex, so the reference vertices there are tested. Along feature lines the same is done in one
/// dimension.
///
/// There are three tests, none of which accepts a triangle beyond the bound. AxisDeviation is the fastest: it processes
/// all triangles at a vertex at once, along one direction. FanDeviation does so along their normals. Both leave some
/// undecided; TriangleDeviation decides any triangle. Vertices that slide on the surface take the tests in this order,
/// if SurfaceFan::build() succeeds; vertices on feature lines, and all other fans, take TriangleDeviation alone.
template <class Pack>
class VertexDeviation : DeviationInput {
 public:
  TETUNE_HD explicit VertexDeviation(const DeviationInput& input) : DeviationInput(input) {}

  /// Whether the vertex may go from its position to x, which is at the surface point `on`.
  TETUNE_HD TETUNE_OUTLINE bool allows(const Vec3& from, const Vec3& x, const SurfacePoint& on) const {
    if (ref.dof[vertex] == VertexDof::curve && !lines_are_within(x, on)) return false;
    const FanChange change = change_of_fan(from, x);
    return change == FanChange::none || (change == FanChange::shape && fan_is_within(x, on));
  }

 private:
  /// A distance from a plane that is no more than this part of the bound is a rounding error.
  static constexpr double kFlatShare = 1e-6;

  /// The effect of a move on the triangles at the vertex.
  enum class FanChange {
    none,  ///< the triangles cover the same points, as the vertex stays in the plane of each of them
    shape,
    outline,  ///< the vertex crosses an edge opposite it
  };
  /// Compares the triangles at the vertex before and after a move. A vertex may not cross an edge opposite it, as it
  /// could at a rim that is no feature: the reference on the side that it leaves would be over no triangle of the new
  /// fan, and beside triangles that do not change and so are not tested. A folded triangle does not unfold for the same
  /// reason.
  TETUNE_HD FanChange change_of_fan(const Vec3& from, const Vec3& x) const {
    const double tolerance2 = kFlatShare * kFlatShare * limit * limit;
    bool changes = false;
    for (Size c = ref.vertex2corner.begin(vertex); c < ref.vertex2corner.end(vertex); ++c) {
      const std::uint32_t corner = ref.vertex2corner.items[c];
      const SurfaceTriangle t = ref.triangles[corner / 3];
      const Vec3 a = vec(points[t.v[(corner + 1) % 3]]);
      const Vec3 e = vec(points[t.v[(corner + 2) % 3]]) - a;
      const Vec3 before = cross(e, from - a);
      const double turned = dot(before, cross(e, x - a));
      if (turned < 0) return FanChange::outline;
      const double off = dot(before, x - from);
      changes = changes || !(turned > 0 && off * off <= tolerance2 * dot(before, before));
    }
    return changes ? FanChange::shape : FanChange::none;
  }
  TETUNE_HD bool fan_is_within(const Vec3& x, const SurfacePoint& on) const {
    const TriangleDeviation triangle_test(*this);
    if (ref.dof[vertex] == VertexDof::surface) {
      SurfaceFan<Pack> fan;
      if (fan.build(ref, points, vertex, x)) {
        if (is_within_along_axis(fan, on)) return true;
        FanMask undecided = 0;
        if (!is_within_along_normals(fan, on, undecided)) return false;
        for (int i = 0; i < fan.count; ++i) {
          if ((undecided >> i & 1) != 0 && !triangle_test.is_within(fan.corner[i], x, on)) return false;
        }
        return true;
      }
    }
    for (Size c = ref.vertex2corner.begin(vertex); c < ref.vertex2corner.end(vertex); ++c) {
      if (!triangle_test.is_within(ref.vertex2corner.items[c], x, on)) return false;
    }
    return true;
  }
  // Two functions out of line, as each test takes some kilobytes of the stack of a device.
  TETUNE_HD TETUNE_OUTLINE bool is_within_along_axis(const SurfaceFan<Pack>& fan, const SurfacePoint& on) const {
    AxisDeviation<Pack> test(fan, *this);
    return test.is_within(on);
  }
  TETUNE_HD TETUNE_OUTLINE bool is_within_along_normals(SurfaceFan<Pack>& fan, const SurfacePoint& on,
                                                        FanMask& undecided) const {
    const TriangleDeviation wedges(*this);
    fan.find_prisms();
    FanDeviation<Pack> test(fan, *this, wedges);
    return test.is_within(on, undecided);
  }
  TETUNE_HD TETUNE_OUTLINE bool lines_are_within(const Vec3& x, const SurfacePoint& on) const {
    const LineDeviation line_test(ref, limit);
    for (const Index neighbor : ref.line[vertex].next) {
      if (!line_test.is_within(x, on, vec(points[neighbor]), surface_points[neighbor])) return false;
    }
    return true;
  }
};

}  // namespace tetune

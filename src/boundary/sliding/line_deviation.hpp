// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/sliding/surface_element.hpp"

namespace tetune {

/// In the corner between a feature line and a triangle both deviations count: each may use this part of the bound.
inline constexpr double kDeviationShare = 0.7;

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

}  // namespace tetune

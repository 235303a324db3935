// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/sliding/deviation_test.hpp"

namespace tetune {

/// The bound on the distance between the mesh's surface and the reference surface, for moves of one vertex.
///
/// DeviationTest is applied to the *checked surface*. It has the triangles of the mesh's surface, and each vertex is at
/// most `max_drift` away from its place there. The map from triangle to triangle moves no point further than that, so
/// the distance of the two surfaces is at most max_drift in both directions, and that of the mesh's surface from the
/// reference at most max_drift more than what was tested. Thus a vertex that stays within max_drift of its place needs
/// no test; where it moves further, so does its place, if the test allows that.
template <class Pack>
class DeviationBound {
 public:
  /// `checked`: the vertex in the checked surface, and `place` its position there. As the threads of a team share the
  /// vertex, one of them reads the place for all.
  TETUNE_HD DeviationBound(const DeviationInput& checked, const Vec3& place, double max_drift)
      : test_(checked), bounded_(checked.limit > 0), max_drift2_(max_drift * max_drift), place_(place) {}

  /// Whether the vertex may move to x, which is at the surface point `on`. If so, its place follows.
  TETUNE_HD bool allows(const Vec3& x, const SurfacePoint& on) {
    if (!bounded_) return true;
    const Vec3 drift = x - place_;
    if (dot(drift, drift) <= max_drift2_) return true;
    if (!test_.allows(place_, x, on)) return false;
    place_ = x;
    place_on_ = on;
    has_moved_ = true;
    return true;
  }

  /// Stores the place of vertex v, after the vertex has moved.
  TETUNE_HD void store(const CheckedSurfaceView& checked, Index v) const {
    if (!has_moved_) return;
    checked.points[v] = point(place_);
    checked.surface_points[v] = place_on_;
  }

 private:
  DeviationTest<Pack> test_;
  bool bounded_;
  bool has_moved_ = false;
  double max_drift2_;
  Vec3 place_;
  SurfacePoint place_on_{};
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/team.hpp"
#include "boundary/sliding/vertex_deviation.hpp"
#include "boundary/vertex_dofs.hpp"

namespace tetune {

/// The bound on the distance between the mesh's surface and the reference surface, for moves of one vertex.
///
/// VertexDeviation is applied to the *checked surface*. It has the triangles of the reference surface. Where these are
/// also those of the mesh's surface, each vertex of the mesh is at most a share of the bound, its drift, away from its
/// position there. The map from triangle to triangle moves no point farther than that, so the distance of the two
/// surfaces is at most the drift in both directions, and that of the mesh's surface from the reference at most the
/// drift more than what was tested. Thus a vertex that stays within the drift of its checked position needs no test. It
/// may move beyond that if the test, with the rest of the bound, allows the checked surface to have it there.
///
/// Operations that change the triangles of the mesh's surface change those of a copy of the checked surface, the
/// *edited surface*, and bound the distance between the two (BendLimit). The vertices of such triangles keep their
/// checked positions, so that this bound holds while others move, and can only drift, from the edited surface
/// (CheckedSurface::is_edited).
template <class Pack>
class DeviationBound {
 public:
  /// `checked`: the vertex in the checked surface, with the whole bound as limit, and `position` its position there; or
  /// that in the edited surface, if the vertex is marked (CheckedSurface::is_edited).
  TETUNE_HD DeviationBound(const DeviationInput& checked, const Vec3& position, bool is_edited = false,
                           double drift_share = kDriftShare)
      : test_({checked.ref, checked.points, checked.surface_points, checked.vertex, (1 - drift_share) * checked.limit}),
        bounded_(checked.limit > 0),
        is_edited_(is_edited),
        max_drift_(drift_share * checked.limit),
        position_(position) {}

  /// Whether the vertex may move to x, which is at the surface point `on`. If so and this needs a test, its checked
  /// position follows.
  TETUNE_HD bool allows(const Vec3& x, const SurfacePoint& on) {
    if (!bounded_) return true;
    const Vec3 drift = x - position_;
    if (dot(drift, drift) <= max_drift_ * max_drift_) return true;
    if (is_edited_ || !test_.allows(position_, x, on)) return false;
    position_ = x;
    surface_point_ = on;
    has_moved_ = true;
    return true;
  }

  /// Stores the checked position of vertex v, after the vertex has moved.
  TETUNE_HD void store(const CheckedSurfaceView& checked, Index v) const {
    if (!has_moved_) return;
    checked.points[v] = point(position_);
    if (checked.edited_points.size() > 0) checked.edited_points[v] = point(position_);
    checked.surface_points[v] = surface_point_;
  }

 private:
  VertexDeviation<Pack> test_;
  bool bounded_;
  bool is_edited_;
  bool has_moved_ = false;
  double max_drift_;
  Vec3 position_;
  SurfacePoint surface_point_{};
};

/// The bound for vertex v, which the threads of a team share.
template <class Pack, class Team>
TETUNE_HD DeviationBound<Pack> deviation_bound(const DofsView& dofs, const Team& team, Index v) {
  const CheckedSurfaceView& checked = dofs.checked;
  const DeviationInput input{dofs.reference, checked.points, checked.surface_points, v, dofs.max_deviation};
  if (!(dofs.max_deviation > 0)) return {input, Vec3{}};
  const bool edits = checked.edited_points.size() > 0;
  return {input, vec(backend::read_once(team, edits ? checked.edited_points[v] : checked.points[v])),
          edits && backend::read_once(team, checked.is_edited[v]) != 0};
}

}  // namespace tetune

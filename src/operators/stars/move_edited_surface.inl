// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/stars/move_edited_surface.hpp"
#include "operators/stars/surface_bend.hpp"
#include "relocation/reduce_colors.hpp"

namespace tetune {
namespace move_edited_surface_detail {

/// Vertices move whose drift is more than this part of what is allowed.
inline constexpr double kMinDrift = 0.5;

struct MoveEdited {
  static constexpr Size kGrain = 32;
  Span<const Point> points;
  Span<const VertexDof> dof;
  Span<const std::uint8_t> active;
  CheckedSurfaceView checked;
  Span<BoundaryTriangle> triangles;
  CsrView vertex2corner;
  BendLimit limit;
  double min_drift;
  Span<const Index> vertices = {};

  TETUNE_HD Sum<Size> operator()(Size i) const {
    const Index v = vertices[i];
    if (active[v] == 0 || dof[v] != VertexDof::surface || checked.is_edited[v] == 0) return {};
    const Vec3 x = vec(points[v]);
    const Vec3 drift = x - vec(checked.edited_points[v]);
    ReplacedTriangles at;
    if (!(dot(drift, drift) > min_drift * min_drift) || !find_triangles(v, at)) return {};
    const double deviation = SurfaceBend(limit.edited, triangles, limit).after_motion(v, x, at);
    if (!(deviation < kInfeasible)) return {};
    for (int k = 0; k < at.count; ++k) {
      triangles[at.triangle[k]].deviation = deviation;
      mark_edited(triangles[at.triangle[k]], checked.is_edited);
    }
    checked.edited_points[v] = points[v];
    return {1};
  }

 private:
  /// The triangles at a vertex; false where there are more than an operation may replace.
  TETUNE_HD bool find_triangles(Index v, ReplacedTriangles& at) const {
    at.count = to_index(vertex2corner.size(v));
    if (at.count == 0 || at.count > kMaxStarTriangles) return false;
    for (int k = 0; k < at.count; ++k) {
      at.triangle[k] = to_index(vertex2corner.items[vertex2corner.begin(v) + k] / 3);
    }
    return true;
  }
};

}  // namespace move_edited_surface_detail

template <class Backend>
ResultOf<Backend, Sum<Size>> move_edited_surface(const Backend& backend, WorkMesh<Backend>& mesh,
                                                 VertexDofs<Backend>& dofs, BoundaryTriangles<Backend>& boundary,
                                                 const Coloring<Backend>& coloring) {
  using namespace move_edited_surface_detail;
  list_corners(backend, mesh, boundary);
  const CheckedSurfaceView checked = dofs.checked.view();
  return reduce_colors<Sum<Size>>(backend, coloring,
                                  MoveEdited{.points = mesh.points.span(),
                                             .dof = dofs.dof.span(),
                                             .active = dofs.active.span(),
                                             .checked = checked,
                                             .triangles = boundary.triangles.span(),
                                             .vertex2corner = boundary.vertex2corner.view(),
                                             .limit = {boundary.max_bend, checked.edited_points},
                                             .min_drift = kMinDrift * kDriftShare * dofs.max_deviation});
}

}  // namespace tetune

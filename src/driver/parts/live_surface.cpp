// SPDX-License-Identifier: Apache-2.0
#include "driver/parts/live_surface.hpp"

#include "backend/span.hpp"
#include "driver/move_job.hpp"
#include "mesh/id_maps.hpp"

namespace tetune {

void leave_surface(SlideSurface& surface, const VertexTargets& target, const std::vector<std::uint8_t>& moves) {
  constexpr std::uint8_t kAllEdges = 7;
  for (Size t = 0; t < std::ssize(surface.triangles); ++t) {
    bool is_prescribed = true;
    bool leaves = false;
    for (const Index v : span_of(surface.triangles)[t]) {
      is_prescribed = is_prescribed && !is_free(span_of(target)[v]);
      leaves = leaves || span_of(target)[v] != span_of(surface.points)[v];
    }
    if (!is_prescribed || !leaves) continue;
    span_of(surface.feature_edges)[t] = kAllEdges;
    for (const Index v : span_of(surface.triangles)[t]) span_of(surface.dof)[v] = VertexDof::fixed;
  }
  for (Size v = 0; v < std::ssize(moves); ++v) {
    if (span_of(moves)[v] != 0) span_of(surface.surface_point)[v] = kNoSurfacePoint;
  }
}

void renumber_surface(SlideSurface& surface, const std::vector<Index>& vertex2original,
                      const std::vector<Point3>& points) {
  if (vertex2original.empty()) return;
  const std::vector<Index> original2vertex = inverse_map(vertex2original, surface.points.size());
  SlideSurface result;
  result.points = points;
  result.dof = gather_entries_or(surface.dof, vertex2original, VertexDof::free);
  const auto renumber = [&](auto ids) {
    for (Index& id : ids) id = id < 0 ? id : span_of(original2vertex)[id];
    return ids;
  };
  result.line.resize(points.size(), {-1, -1});
  result.surface_point.resize(points.size(), kNoSurfacePoint);
  for (Size original = 0; original < std::ssize(original2vertex); ++original) {
    const Index v = span_of(original2vertex)[original];
    if (v < 0) continue;
    span_of(result.points)[v] = span_of(surface.points)[original];
    span_of(result.line)[v] = renumber(span_of(surface.line)[original]);
    span_of(result.surface_point)[v] = renumber(span_of(surface.surface_point)[original]);
  }
  for (const auto& triangle : surface.triangles) result.triangles.push_back(renumber(triangle));
  result.feature_edges = surface.feature_edges;
  surface = std::move(result);
}

}  // namespace tetune

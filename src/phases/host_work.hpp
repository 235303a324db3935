// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "phases/working_set.hpp"

namespace tetune {

/// The part of a working set from which neighborhoods are taken, in the host's memory: mesh, degrees of freedom,
/// boundary and constrained edges.
struct HostWork {
  std::vector<Point> points;
  std::vector<Tet> tet2vertex;
  std::vector<FaceAdjacency> tet2tet;
  std::vector<Index> tet2original, vertex2original;
  std::vector<Index> free_slots;

  std::vector<VertexDof> dof;
  std::vector<Vec3> axis;
  std::vector<SurfacePoint> surface_point;            ///< empty unless vertices slide
  std::vector<DisplacementBound> displacement_bound;  ///< empty: unbounded
  double max_deviation = 0;

  std::vector<BoundaryTriangle> triangles;
  double flat = 0;
  bool bends = false;

  std::vector<std::uint64_t> constrained_keys;
  std::vector<std::uint8_t> constrained_vertex;

  /// The reference surface; empty unless vertices slide.
  struct {
    std::vector<Point> points;
    std::vector<SurfaceTriangle> triangles;
    std::vector<Index> across;
    std::vector<std::uint32_t> offsets, corners;
    std::vector<LineVertex> line;
    std::vector<VertexDof> dof;
  } reference;

  Size vertices() const { return std::ssize(points); }
  Size slots() const { return std::ssize(tet2vertex); }
  Size tets() const { return slots() - std::ssize(free_slots); }
  void erase_removed_triangles() {
    std::erase_if(triangles, [](const BoundaryTriangle& t) { return t.v[0] == kRemoved; });
  }
  bool alive(Size slot) const { return span_of(tet2vertex)[slot].v[0] != kFreeSlot; }
};

template <class Backend>
HostWork download_work(const WorkingSet<Backend>& work) {
  HostWork host;
  host.points = work.mesh.points.download();
  host.tet2vertex = work.mesh.tet2vertex.download();
  host.tet2tet = work.mesh.tet2tet.download();
  host.tet2original = work.mesh.tet2original.download();
  host.vertex2original = work.mesh.vertex2original.download();
  host.free_slots = work.mesh.free_slots.download();
  host.free_slots.resize(to_size_t(work.mesh.free_count));
  host.dof = work.dofs.dof.download();
  host.axis = work.dofs.axis.download();
  host.surface_point = work.dofs.surface_point.download();
  host.displacement_bound = work.dofs.displacement_bound.download();
  host.max_deviation = work.dofs.max_deviation;
  host.triangles = work.boundary.triangles.download();
  host.flat = work.boundary.flat;
  host.bends = work.boundary.bends;
  host.constrained_keys = work.flips.constrained_keys.download();
  host.constrained_vertex = work.flips.constrained_vertex.download();
  const ReferenceSurface<Backend>& reference = work.dofs.reference;
  host.reference = {reference.points.download(),
                    reference.triangles.download(),
                    reference.across.download(),
                    reference.vertex2corner.offsets.download(),
                    reference.vertex2corner.items.download(),
                    reference.line.download(),
                    reference.dof.download()};
  return host;
}

/// Uploads what restarts change: the mesh, degrees of freedom, boundary triangles and constrained vertices. Energies,
/// rings and the coloring are out of date afterwards.
template <class Backend>
void upload_work(const Backend& backend, const HostWork& host, WorkingSet<Backend>& work) {
  work.mesh.points.upload(backend, host.points);
  work.mesh.tet2vertex.upload(backend, host.tet2vertex);
  work.mesh.tet2tet.upload(backend, host.tet2tet);
  work.mesh.tet2original.upload(backend, host.tet2original);
  work.mesh.vertex2original.upload(backend, host.vertex2original);
  work.mesh.free_slots.upload(backend, host.free_slots);
  work.mesh.free_count = std::ssize(host.free_slots);
  work.dofs.dof.upload(backend, host.dof);
  work.dofs.axis.upload(backend, host.axis);
  work.dofs.surface_point.upload(backend, host.surface_point);
  work.dofs.displacement_bound.upload(backend, host.displacement_bound);
  work.dofs.active.resize(backend, work.mesh.vertices());
  work.boundary.triangles.upload(backend, host.triangles);
  work.boundary.stale = true;
  work.flips.constrained_vertex.upload(backend, host.constrained_vertex);
  work.flips.slack.resize(backend, work.mesh.slots());
  backend.fill(work.flips.slack.span(), kUnknownSlack);
}

}  // namespace tetune

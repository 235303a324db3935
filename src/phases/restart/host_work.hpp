// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/host_mesh.hpp"
#include "phases/working_set.hpp"

namespace tetune {

/// The part of a working set from which neighborhoods are taken, in the host's memory: mesh, degrees of freedom,
/// boundary and constrained edges.
struct HostWork : MeshSnapshot {
  std::vector<VertexDof> dof;
  std::vector<Vec3> axis;
  std::vector<SurfacePoint> surface_point;            ///< empty unless vertices slide
  std::vector<DisplacementBound> displacement_bound;  ///< empty: unbounded
  std::vector<std::uint8_t> constrained_vertex;

  double max_deviation = 0;
  CheckedSurfaceOnHost checked;  ///< empty without a bound on the deviation

  std::vector<BoundaryTriangle> triangles;
  bool bends = false;
  double max_bend = kInfeasible;

  std::vector<std::uint64_t> constrained_keys;

  ReferenceSurfaceOnHost reference;  ///< empty unless vertices slide

  HostWork() = default;
  template <class Backend>
  explicit HostWork(const WorkingSet<Backend>& work)
      : MeshSnapshot(work.mesh),
        max_deviation(work.dofs.max_deviation),
        triangles(work.boundary.triangles.download()),
        bends(work.boundary.bends),
        max_bend(work.boundary.max_bend),
        constrained_keys(work.flips.constrained_keys.download()),
        reference(work.dofs.reference.download()) {
    for_each_dof_array(*this, work, [](auto& array, const auto& buffer) { array = buffer.download(); });
  }

  /// Calls f(array, buffer) for each array with an entry per vertex, and its buffer in a working set.
  template <class Host, class Work, class F>
  static void for_each_vertex_array(Host& host, Work& work, const F& f) {
    f(host.points, work.mesh.points);
    f(host.vertex2original, work.mesh.vertex2original);
    for_each_dof_array(host, work, f);
  }
  /// Same, without the arrays of MeshSnapshot.
  template <class Host, class Work, class F>
  static void for_each_dof_array(Host& host, Work& work, const F& f) {
    f(host.dof, work.dofs.dof);
    f(host.axis, work.dofs.axis);
    f(host.surface_point, work.dofs.surface_point);
    f(host.displacement_bound, work.dofs.displacement_bound);
    f(host.checked.points, work.dofs.checked.points);
    f(host.checked.surface_points, work.dofs.checked.surface_points);
    f(host.checked.is_edited, work.dofs.checked.is_edited);
    f(host.checked.edited_points, work.dofs.checked.edited_points);
    f(host.constrained_vertex, work.flips.constrained_vertex);
  }

  Size vertices() const { return std::ssize(points); }
  Size slots() const { return std::ssize(tet2vertex); }
  Size tets() const { return slots() - std::ssize(free_slots); }
  void erase_removed_triangles() {
    std::erase_if(triangles, [](const BoundaryTriangle& t) { return t.v[0] == kRemoved; });
  }
  bool alive(Size slot) const { return span_of(tet2vertex)[slot].v[0] != kFreeSlot; }
};

/// Uploads what restarts change: the mesh, degrees of freedom, boundary triangles and constrained vertices. Energies,
/// rings and the coloring are out of date afterwards.
template <class Backend>
void upload_work(const Backend& backend, const HostWork& host, WorkingSet<Backend>& work) {
  host.upload(backend, work.mesh);
  HostWork::for_each_dof_array(host, work,
                               [&backend](const auto& array, auto& buffer) { buffer.upload(backend, array); });
  work.dofs.active.resize(backend, work.mesh.vertices());
  work.boundary.triangles.upload(backend, host.triangles);
  work.boundary.stale = true;
  work.flips.slack.resize(backend, work.mesh.slots());
  backend.fill(work.flips.slack.span(), kUnknownSlack);
}

}  // namespace tetune

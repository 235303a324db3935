// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "boundary/sliding/slide_surface.inl"
#include "boundary/vertex_dof.hpp"
#include "driver/place_tracker.hpp"
#include "driver/report/targets.hpp"
#include "driver/result_mesh.hpp"
#include "mesh/connect.hpp"
#include "mesh/sort_mesh.hpp"
#include "phases/working_set.hpp"
#include "tetune/optimize.hpp"

namespace tetune {
namespace export_mesh_detail {

/// Renumbers the vertices of each tetrahedron.
struct RenumberVertices {
  Span<const Index> old2new;
  Span<Tet> tets;
  TETUNE_HD void operator()(Size t) const {
    Tet tet = tets[t];
    for (int k = 0; k < 4; ++k) tet[k] = old2new[tet[k]];
    tets[t] = tet;
  }
};

}  // namespace export_mesh_detail

/// The work mesh on the host, for report_targets(). Vertices that move with their images have the degrees of freedom
/// that they have together.
template <class Backend>
ConstrainedMesh constrained_mesh(WorkingSet<Backend>& work, const TetMesh& mesh) {
  work.vertex_constraints.resize(to_size_t(work.mesh.vertices()), VertexConstraint::none);
  std::vector<VertexDof> dof = work.dofs.dof.download();
  const std::vector<MotionSpace> spaces = work.periodic.space.download();
  const std::vector<Index> vertex2class = work.periodic.images.vertex2class.download();
  for (std::size_t v = 0; v < vertex2class.size(); ++v) {
    if (vertex2class[v] < 0) continue;
    dof[v] = span_of(spaces)[vertex2class[v]].dof;
    work.vertex_constraints[v] = VertexConstraint::none;
  }
  return {work.mesh.points.download(),
          work.mesh.tet2vertex.download(),
          work.mesh.tet2tet.download(),
          regions_of(work.mesh.tet2original.download(), mesh),
          number_vertices(work.mesh.vertex2original.download(), mesh.points.size()).work2new(),
          std::move(dof),
          work.vertex_constraints,
          work.required_slots,
          work.scale};
}

/// Where the vertices are in the input, in the numbers of the result. `vertices`: the number of the caller's.
template <class Backend>
std::vector<MeshPlace> places_of(const PlaceTracker& tracker, const WorkingSet<Backend>& work, std::size_t vertices) {
  return tracker.places(number_vertices(work.mesh.vertex2original.download(), vertices).work2new());
}

/// Replaces the caller's mesh by the result, and updates the places of the vertices on the surface that they slide on.
/// Reports which entities were kept. When it throws, mesh and surface are as before; the working set is consumed in any
/// case.
template <class Backend>
void export_mesh(const Backend& backend, WorkingSet<Backend>& work, const ExportRules& rules, TetMesh& mesh,
                 SlideSurface* surface, Report& report) {
  // Makes room for the result.
  work.rings = {};
  work.coloring = {};
  work.flips = {};
  HostResult result;
  result.slot_of_tet = compact_slots(backend, work.mesh).download();
  // Flips in a mesh that overlaps itself can make a face of three or more tetrahedra.
  result.is_manifold = build_adjacency(backend, work.mesh).ok();
  result.numbering = number_vertices(work.mesh.vertex2original.download(), mesh.points.size());
  work.mesh.vertex2original.upload(backend, result.numbering.work2extended);
  backend.for_each(work.mesh.slots(),
                   export_mesh_detail::RenumberVertices{work.mesh.vertex2original, work.mesh.tet2vertex});
  result.tets.resize(to_size_t(work.mesh.slots()));
  backend.memory().download(result.tets.data(), work.mesh.tet2vertex.span().data(), result.tets.size() * sizeof(Tet));
  result.tet2original = work.mesh.tet2original.download();
  result.points = work.mesh.points.download();
  result.boundary = work.boundary.triangles.download();
  result.listed_boundary = std::move(work.listed_boundary);
  result.required_slots = std::move(work.required_slots);
  result.listed_triangles = std::move(work.listed_triangles);
  result.scale = work.scale;
  PlacesOnSurface places;
  if (surface != nullptr) places = export_places(backend, work.dofs, result.numbering.work2extended, work.scale);
  replace_mesh(mesh, std::move(result), rules, report);
  if (surface != nullptr) surface->PlacesOnSurface::operator=(std::move(places));
}

}  // namespace tetune

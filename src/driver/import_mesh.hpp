// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <functional>

#include "backend/atomic.hpp"
#include "boundary/boundary_triangles.hpp"
#include "boundary/classify.hpp"
#include "boundary/constraints.hpp"
#include "boundary/find_dofs.hpp"
#include "driver/import_periodic.hpp"
#include "mesh/connect.hpp"
#include "mesh/id_maps.hpp"
#include "mesh/sort_mesh.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "mesh/validate_arrays.hpp"
#include "mesh/work_mesh.hpp"
#include "phases/element_selection.hpp"
#include "phases/tuning.hpp"
#include "phases/working_set.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "tetune/validate.hpp"

namespace tetune {

/// The treatment of the vertices of periodic links.
enum class LinkedVertices : std::uint8_t {
  move,   ///< they move together where moves_periodic() holds
  fixed,  ///< they stay
};

/// The input of import_mesh().
struct ImportInput {
  const TetMesh& mesh;
  const Options& options;
  const SlideSurface* slides_on = nullptr;  ///< the surface for Boundary::slide; null: the mesh's own
  LinkedVertices linked = LinkedVertices::move;
};

namespace import_mesh_detail {

/// Locks the faces of the listed tetrahedra.
struct LockTet {
  MeshView mesh;
  Span<const Index> slots;
  TETUNE_HD void operator()(Size i) const {
    for (int f = 0; f < 4; ++f) {
      const HalfFace across = backend::load_shared(mesh.tet2tet[slots[i]][f]);
      if (across == kNoHalfFace) continue;
      backend::atomic_or(mesh.tet2tet[slots[i]][f], kLocked);
      backend::atomic_or(mesh.tet2tet[tet_of(across)][face_of(across)], kLocked);
    }
  }
};

/// Throws unless every volume is positive, or is to be made positive. Exact arithmetic decides the few volumes whose
/// sign is uncertain after rounding.
template <class Backend>
void check_volumes(const Backend& backend, const TetMesh& mesh, const Options& options, WorkingSet<Backend>& work) {
  BufferOf<Backend, Index> uncertain(backend, work.mesh.slots());
  if (backend.compact(work.mesh.slots(), HasUncertifiedVolume{work.mesh.view()}, uncertain.span()) == 0) return;
  const ValidationReport report = validate(mesh, options.threads);
  for (const Finding& f : report.findings) {
    const bool repairable = f.defect == Defect::inverted_tet || f.defect == Defect::flat_tet;
    if (!options.untangle || !repairable) throw MeshError(report.message(false));
    work.tangled += f.count;
  }
}

/// Uploads the mesh, sorts and connects it, and checks its volumes. Returns the work vertex of each of the caller's.
template <class Backend>
std::vector<Index> import_tets(const Backend& backend, const TetMesh& mesh, const Options& options,
                               WorkingSet<Backend>& work) {
  work.mesh = upload_mesh(backend, mesh, work.scale);
  sort_mesh(backend, work.mesh);
  std::vector<Index> original2vertex = inverse_map(work.mesh.vertex2original.download(), mesh.points.size());
  const AdjacencyReport adjacency = build_adjacency(backend, work.mesh);
  if (adjacency.non_manifold_faces + adjacency.misoriented_faces > 0) {
    throw MeshError(validate(mesh, options.threads).message(false));
  }
  check_volumes(backend, mesh, options, work);
  return original2vertex;
}

/// Locks the interfaces between regions and the tetrahedra that must stay, of which the required ones come first.
template <class Backend>
void lock_tets(const Backend& backend, const TetMesh& mesh, const std::vector<Index>& tets, WorkingSet<Backend>& work) {
  if (std::adjacent_find(mesh.tet_tags.begin(), mesh.tet_tags.end(), std::not_equal_to<>()) != mesh.tet_tags.end()) {
    const DeviceViewOf<Backend, int> regions(backend, mesh.tet_tags);
    lock_interfaces(backend, work.mesh, regions.span());
  }
  if (tets.empty()) return;
  const std::vector<Index> original2slot = inverse_map(work.mesh.tet2original.download(), mesh.tets.size());
  std::vector<Index> locked;
  locked.reserve(tets.size());
  for (const Index t : tets) locked.push_back(span_of(original2slot)[t]);
  BufferOf<Backend, Index> slots;
  slots.upload(backend, locked);
  backend.for_each(slots.size(), LockTet{work.mesh.view(), slots});
  locked.resize(mesh.required_tets.size());
  work.required_slots = std::move(locked);
}

/// The constraint on each work vertex, given those of the caller's. The vertices of listed triangles that are not
/// faces are frozen.
inline std::vector<VertexConstraint> work_constraints(const TetMesh& mesh,
                                                      const std::vector<VertexConstraint>& by_original,
                                                      const std::vector<Index>& original2vertex,
                                                      const std::vector<Listed>& listed_triangles) {
  std::vector<VertexConstraint> result(by_original.size(), VertexConstraint::none);
  const Span<VertexConstraint> constraints = span_of(result);
  const Span<const Index> to_work = span_of(original2vertex);
  for (Size v = 0; v < constraints.size(); ++v) constraints[to_work[v]] = span_of(by_original)[v];
  auto state = listed_triangles.begin();
  for (const auto& triangle : mesh.triangles) {
    if (*state++ != Listed::absent) continue;
    for (const Index v : triangle) constraints[to_work[v]] = VertexConstraint::frozen;
  }
  return result;
}

/// Lets operations bend the surface, which is the reference surface, within the part of the bound that is left to them
/// (bend_share()).
template <class Backend>
void let_surface_bend(const Backend& backend, const Options& options, WorkingSet<Backend>& work) {
  VertexDofs<Backend>& dofs = work.dofs;
  link_to_reference(backend, dofs.reference.across.span(), work.boundary);
  if (!has_deviation_bound(options)) return;
  const double share = bend_share(options);
  work.boundary.max_bend = share / (1 - share) * dofs.max_deviation;
  dofs.checked.is_edited.resize(backend, work.mesh.vertices());
  backend.fill(dofs.checked.is_edited.span(), std::uint8_t{0});
  dofs.checked.edited_points.assign(backend, dofs.checked.points);
}

/// Whether motion and flips in flat patches of the surface need no test of the bound on the deviation. Operations on
/// the surface have a part of the bound instead; and a given surface may be a part of one, of whose patches some
/// triangles are not known.
inline bool keeps_flat_patches(const ImportInput& source) {
  return has_deviation_bound(source.options) && !edits_surface(source.options) && source.slides_on == nullptr;
}

/// Whether alternate() flips edges of the surface, of all patches or of flat ones.
inline bool flips_surface(const ImportInput& source) {
  return flips_boundary(source.options) && (!has_deviation_bound(source.options) || keeps_flat_patches(source));
}

/// Whether a whole mesh is optimized on its own surface: it is no part of a larger one, and follows no targets.
inline bool is_whole(const ImportInput& source) {
  return source.slides_on == nullptr && source.linked == LinkedVertices::move;
}

/// Whether vertices of thin sheets move as with Boundary::preserve: sliding could make such a sheet several times as
/// thick. A bound on the deviation limits that, too.
inline bool keeps_thin_sheets(const ImportInput& source) {
  return source.options.boundary == Boundary::slide && !has_deviation_bound(source.options) && is_whole(source);
}

/// Lets edges be flipped in flat patches alone where there is a bound on the deviation, as the vertices of other
/// triangles that flip could only drift; and lets the triangles of thin sheets change within their planes alone.
template <class Backend>
void hold_triangles(const Backend& backend, const HeldParts& held, bool in_flat_patches,
                    BoundaryTriangles<Backend>& boundary) {
  if (!in_flat_patches && held.thin.empty()) return;
  std::vector<BoundaryTriangle> triangles = boundary.triangles.download();
  for (Index t = 0; t < std::ssize(triangles); ++t) {
    std::uint16_t& stays = span_of(triangles)[t].stays;
    if (in_flat_patches && !held.flat.contains(t)) stays = kStays;
    if (!held.thin.empty() && span_of(held.thin)[t] != 0 && stays == 0) stays = kFlipsInPlane;
  }
  boundary.triangles.upload(backend, triangles);
}

/// The entries of the caller's list that triangles of the boundary have.
inline std::vector<Index> listed_entries(const std::vector<BoundaryTriangle>& triangles) {
  std::vector<Index> entries;
  for (const BoundaryTriangle& t : triangles) {
    if (t.listed >= 0) entries.push_back(t.listed);
  }
  return entries;
}

/// Finds the surface and decides where its vertices may go.
template <class Backend>
void import_surface(const Backend& backend, const ImportInput& source, const Constraints& constraints,
                    const std::vector<Index>& original2vertex, WorkingSet<Backend>& work, Report& report) {
  const TetMesh& mesh = source.mesh;
  const Options& options = source.options;
  const DeviceViewOf<Backend, std::array<Index, 3>> triangles(backend, mesh.triangles);
  const DeviceViewOf<Backend, int> tags(backend, mesh.triangle_tags);
  const DeviceViewOf<Backend, std::uint8_t> required_view(backend, constraints.required_triangles);
  const DeviceViewOf<Backend, int> frozen_patches(backend, options.frozen_patches);
  const DeviceViewOf<Backend, Index> original2vertex_view(backend, original2vertex);
  const ListedTriangles listed{{reinterpret_cast<const Index*>(triangles.span().data()), 3 * triangles.span().size()},
                               tags.span(),
                               required_view.span(),
                               frozen_patches.span(),
                               original2vertex_view.span(),
                               options.open_boundaries};
  BufferOf<Backend, Listed> listed_state;
  Surface<Backend> surface;
  build_surface(backend, work.mesh, listed, listed_state, surface);
  work.listed_triangles = listed_state.download();

  work.vertex_constraints = work_constraints(mesh, constraints.vertices, original2vertex, work.listed_triangles);
  const bool moves = is_whole(source) && moves_periodic(mesh, options);
  const std::vector<VertexConstraint> without_links =
      moves ? work_constraints(mesh, constraints.vertices_without_links, original2vertex, work.listed_triangles)
            : work.vertex_constraints;
  if (flips_surface(source) || edits_surface(options)) {
    const DeviceViewOf<Backend, VertexConstraint> view(backend, without_links);
    build_boundary(backend, surface, listed, view.span(), work.boundary);
    work.boundary.bends = bends_surface(options);
  }
  if (edits_surface(options)) work.listed_boundary = listed_entries(work.boundary.triangles.download());

  // All listed edges constrain flips.
  std::vector<Index> ends;
  for (const auto& edge : constraints.edges) {
    for (const Index v : edge) ends.push_back(span_of(original2vertex)[v]);
  }
  EdgeSet<Backend> edges(backend, ends, work.mesh.vertices());
  const DofInput<Backend> input{.options = options,
                                .surface = surface,
                                .edge_ends = ends,
                                .ridges = constraints.ridges,
                                .edges = edges,
                                .constraints = work.vertex_constraints,
                                .scale = work.scale,
                                .max_deviation = (1 - bend_share(options)) * options.max_deviation,
                                .slides_on = source.slides_on,
                                .keeps_flat_patches = keeps_flat_patches(source),
                                .keeps_thin_sheets = keeps_thin_sheets(source),
                                .original2vertex = original2vertex};
  const HeldParts held = find_dofs(backend, work.mesh, input, work.dofs, report);
  if (moves) import_periodic(backend, mesh, input, without_links, work, report);
  // After the triangles of periodic faces, which flip with their images alone.
  hold_triangles(backend, held, keeps_flat_patches(source), work.boundary);
  if (bends_surface(options)) let_surface_bend(backend, options, work);
  work.flips.constrained_keys.swap(edges.keys);
  work.flips.constrained_vertex.swap(edges.on_vertex);
}

}  // namespace import_mesh_detail

/// Builds the working set of a mesh: checks the mesh, renumbers it, finds its surface and decides where each vertex may
/// go. Requires WorkingSet::scale. Throws MeshError and OptionError.
template <class Backend>
void import_mesh(const Backend& backend, const ImportInput& source, WorkingSet<Backend>& work, Report& report) {
  using namespace import_mesh_detail;
  require_arrays(source.mesh);
  const Constraints constraints = find_constraints(source.mesh, source.options);
  const std::vector<Index> original2vertex = import_tets(backend, source.mesh, source.options, work);
  lock_tets(backend, source.mesh, constraints.locked_tets, work);
  import_surface(backend, source, constraints, original2vertex, work, report);
}

}  // namespace tetune

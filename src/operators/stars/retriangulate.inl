// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/engine/application.hpp"
#include "operators/stars/cavity_retriangulation.hpp"
#include "operators/stars/composite_removal.hpp"
#include "operators/stars/retriangulate.hpp"
#include "operators/stars/surface_contraction.hpp"
#include "operators/stars/surface_insertion.hpp"
#include "operators/stars/vertex_contraction.hpp"
#include "operators/stars/vertex_insertion.hpp"

namespace tetune {
namespace retriangulate_detail {

/// All operators that retriangulate a cavity from one point.
using AllOperators = StarOperators<CompositeRemoval, CavityRetriangulation, VertexInsertion, VertexContraction,
                                   SurfaceInsertion, SurfaceContraction>;
/// Where vertices are not edited, composite removals alone are proposed.
inline constexpr int kRemovalChoices = CompositeRemoval::kChoices;
/// The first choice that inserts or removes a vertex.
inline constexpr int kFirstEdit = StarOperators<CompositeRemoval, CavityRetriangulation>::kChoices;
/// The choices without those that insert and remove vertices of the surface.
inline constexpr int kSurfaceKeepingChoices =
    StarOperators<CompositeRemoval, CavityRetriangulation, VertexInsertion, VertexContraction>::kChoices;

/// The first tetrahedra of a list: at most as many as have proposals whose ids fit 32 bits.
inline Span<const Index> proposing(Span<const Index> tets, int choices) {
  const Size max_tets = (Size{1} << 32) / choices;
  return {tets.data(), tets.size() < max_tets ? tets.size() : max_tets};
}

/// Marks the tetrahedra with an angle that costs more than `vertex_cost`.
struct MarkEditors {
  RatedMesh mesh;
  Span<const Index> tets;
  double vertex_cost;
  Span<std::uint8_t> is_editor;
  TETUNE_HD void operator()(Size i) const {
    is_editor[i] = dihedral_cots(mesh, tets[i]).cost(mesh.obtuse_weight) > vertex_cost ? 1 : 0;
  }
};

/// Room for inserted vertices in the arrays of all vertices.
template <class Backend>
VertexArrays grow_vertices(const Backend& backend, const EditableMesh<Backend>& editable, Size count) {
  WorkMesh<Backend>& mesh = editable.mesh;
  VertexDofs<Backend>& dofs = editable.dofs;
  mesh.points.grow(backend, count);
  mesh.vertex2original.grow(backend, count);
  editable.flips.constrained_vertex.grow(backend, count);
  dofs.dof.grow(backend, count);
  dofs.axis.grow(backend, count);
  dofs.active.grow(backend, count);
  if (dofs.surface_point.size() > 0) dofs.surface_point.grow(backend, count);
  if (dofs.displacement_bound.size() > 0) dofs.displacement_bound.grow(backend, count);
  if (dofs.checked.points.size() > 0) {
    dofs.checked.points.grow(backend, count);
    dofs.checked.surface_points.grow(backend, count);
  }
  if (dofs.checked.edited_points.size() > 0) {
    dofs.checked.edited_points.grow(backend, count);
    dofs.checked.is_edited.grow(backend, count);
  }
  return {mesh.vertex2original.span(),
          dofs.dof.span(),
          dofs.axis.span(),
          dofs.surface_point.span(),
          editable.flips.constrained_vertex.span(),
          dofs.displacement_bound.span(),
          dofs.checked.view()};
}

/// Whether the mesh may have as many tetrahedra as these changes leave.
template <class Backend>
bool has_room(const WorkMesh<Backend>& mesh, const ChangeCounts& total, const RetriangulationLimits& limits) {
  const bool is_within_limit = total.taken <= total.freed || mesh.tets() + total.taken - total.freed <= limits.max_tets;
  return is_within_limit && SlotChange(mesh, total).needed <= kMaxSlots;
}

/// Selects candidates; again without removal, without insertion, or without both where a limit is exceeded.
template <class Backend, class P>
auto select_within(const Backend& backend, WorkMesh<Backend>& mesh, Size count, P& proposals, FlipState<Backend>& flips,
                   const RetriangulationLimits& limits) {
  for (;;) {
    auto selection = select_candidates(backend, mesh, count, proposals, flips);
    const ChangeCounts& total = selection.total;
    if (proposals.removes && Size{total.removed} - Size{total.inserted} > limits.max_removed) {
      proposals.removes = false;
    } else if (proposals.inserts && !has_room(mesh, total, limits)) {
      proposals.inserts = false;
    } else {
      return selection;
    }
  }
}

}  // namespace retriangulate_detail

template <class Backend>
RetriangulationReport retriangulate_worst(const Backend& backend, const EditableMesh<Backend>& editable,
                                          const Criterion& criterion, Span<const Index> worst,
                                          const RetriangulationLimits& limits) {
  using namespace retriangulate_detail;
  WorkMesh<Backend>& mesh = editable.mesh;
  FlipState<Backend>& flips = editable.flips;
  VertexDofs<Backend>& dofs = editable.dofs;
  BoundaryTriangles<Backend>* const boundary = editable.boundary;
  const bool lowers_mean = limits.mean_energy > 0;
  const bool edits_vertices = lowers_mean || limits.vertex_cost < kInfeasible;
  const int first_choice = lowers_mean ? kFirstEdit : 0;
  const int end_choice = !edits_vertices       ? kRemovalChoices
                         : boundary == nullptr ? kSurfaceKeepingChoices
                                               : AllOperators::kChoices;
  const int choices = end_choice - first_choice;
  const Span<const Index> tets = proposing(worst, choices);
  SurfaceTriangles triangles{};
  if (boundary != nullptr) {
    list_corners(backend, mesh, *boundary);
    triangles = {.triangles = boundary->triangles.span(),
                 .vertex2corner = boundary->vertex2corner.view(),
                 .bends = boundary->bends,
                 .limit = {boundary->max_bend, dofs.checked.edited_points.span()},
                 .reference = dofs.reference.view(),
                 .surface_point = dofs.surface_point.span()};
  }
  const Size count = choices * tets.size();
  BufferOf<Backend, std::uint8_t> is_editor(backend, edits_vertices && !lowers_mean ? tets.size() : 0);
  backend.for_each(is_editor.size(), MarkEditors{rated(mesh, criterion), tets, limits.vertex_cost, is_editor.span()});
  const StarContext context{.mesh = rated(mesh, criterion),
                            .constrained = flips.constrained(),
                            .dof = dofs.dof.span(),
                            .axis = dofs.axis.span(),
                            .surface = triangles,
                            .max_ring = flips.max_ring,
                            .min_gain = limits.min_gain,
                            .inserts = edits_vertices,
                            .removes = edits_vertices,
                            .proposers = edits_vertices ? tets : Span<const Index>{},
                            .is_editor = is_editor.span(),
                            .mean_energy = limits.mean_energy,
                            .is_selective = limits.is_selective};
  StarProposals<AllOperators, typename Backend::Pack> proposals{context, tets, first_choice, choices};
  BufferOf<Backend, MoveCosts> moves;
  if constexpr (Backend::kIsAsynchronous) {
    if (!lowers_mean) moves.resize(backend, CompositeRemoval::kMoves * tets.size());
    backend.for_each(moves.size(), EvaluateMoves{context, tets, moves.span()});
    proposals.moves = moves.span();
  }
  auto selection = select_within(backend, mesh, count, proposals, flips, limits);
  if (selection.size() == 0 || !has_room(mesh, selection.total, limits)) return {};
  const ChangeCounts& total = selection.total;
  const VertexArrays vertices = grow_vertices(backend, editable, mesh.vertices() + total.inserted);
  apply_selection(backend, mesh, criterion, flips, selection,
                  ApplicationOutput{.changed = dofs.active.span(), .vertices = vertices});
  if (boundary != nullptr) replace_triangles(backend, selection, dofs.checked.is_edited.span(), *boundary);
  return {total.inserted, total.removed, selection.size() - total.inserted - total.removed};
}

}  // namespace tetune

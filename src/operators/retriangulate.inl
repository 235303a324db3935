// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "operators/application.hpp"
#include "operators/composite_removal.hpp"
#include "operators/retriangulate.hpp"
#include "operators/vertex_contraction.hpp"
#include "operators/vertex_insertion.hpp"

namespace tetune {
namespace retriangulate_detail {

/// All operators that retriangulate a cavity from one point. The first ones keep the number of vertices.
using AllOperators = StarOperators<CompositeRemoval, VertexInsertion, VertexContraction>;
inline constexpr int kVertexKeepingChoices = CompositeRemoval::kChoices;

/// At most kMinProposers + tets / kMinProposers tetrahedra are processed per pass: in structured meshes all elements
/// tie for the worst angle.
inline constexpr Size kMinProposers = 250;

/// Room for inserted vertices in the arrays of all vertices.
template <class Backend>
VertexArrays grow_vertices(const Backend& backend, WorkMesh<Backend>& mesh, FlipState<Backend>& flips,
                           VertexDofs<Backend>& dofs, Size count) {
  mesh.points.grow(backend, count);
  mesh.vertex2original.grow(backend, count);
  flips.constrained_vertex.grow(backend, count);
  dofs.dof.grow(backend, count);
  dofs.axis.grow(backend, count);
  dofs.active.grow(backend, count);
  if (dofs.surface_point.size() > 0) dofs.surface_point.grow(backend, count);
  return {mesh.vertex2original.span(), dofs.dof.span(), dofs.axis.span(), dofs.surface_point.span(),
          flips.constrained_vertex.span()};
}

}  // namespace retriangulate_detail

template <class Backend>
RetriangulationReport retriangulate_worst(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                                          FlipState<Backend>& flips, VertexDofs<Backend>& dofs, Span<const Index> tets,
                                          Size max_tets, double vertex_cot) {
  using namespace retriangulate_detail;
  const int choices = vertex_cot < kInfeasible ? AllOperators::kChoices : kVertexKeepingChoices;
  const Size count = choices * std::min(tets.size(), kMinProposers + mesh.tets() / kMinProposers);
  const StarProposals<AllOperators> proposals{
      rated(mesh, criterion), flips.constrained(), dofs.dof.span(), tets, choices, flips.max_ring, vertex_cot};
  auto selection = select_candidates(backend, mesh, count, proposals, flips.tet2bid);
  const ChangeCounts& total = selection.total;
  if (selection.size() == 0 || mesh.tets() + total.taken - total.freed > max_tets ||
      SlotChange(mesh, total).needed > kMaxSlots) {
    return {};
  }
  const VertexArrays vertices = grow_vertices(backend, mesh, flips, dofs, mesh.vertices() + total.inserted);
  apply_selection(backend, mesh, criterion, flips, selection, dofs.active.span(), vertices);
  return {total.inserted, total.removed, selection.size() - total.inserted - total.removed};
}

}  // namespace tetune

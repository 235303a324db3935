// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <utility>

#include "operators/flips/boundary_flip.hpp"
#include "operators/flips/face_removal.hpp"
#include "operators/flips/flip_pass.hpp"
#include "operators/stars/retriangulate.hpp"
#include "phases/element_selection.hpp"
#include "phases/optimizer.hpp"

/// Steps that the phases after alternate() share.
namespace tetune {

/// Flips edges of the boundary with an active end. Returns the number of flips.
template <class Backend>
Size flip_boundary_at_active(Optimizer<Backend>& optimizer, const Criterion& criterion) {
  WorkingSet<Backend>& work = optimizer.work;
  if (work.boundary.triangles.size() == 0) return 0;
  // The pass examines the edges of the vertices that it is given.
  optimizer.changed.assign(optimizer.backend, work.dofs.active);
  const FlipCounts made = boundary_flip_pass(optimizer.backend, work.mesh, criterion, work.flips, work.boundary,
                                             work.dofs.checked.view(), optimizer.changed.output())
                              .counts;
  activate(optimizer.backend, optimizer.changed, work.dofs);
  optimizer.record_flips(made);
  return made.flips();
}

/// Face removals, then other flips until there are none, from the active tetrahedra on. Activates the vertices whose
/// ring changes. Returns the number of flips.
template <class Backend>
Size flip_until_none_active(Optimizer<Backend>& optimizer, const Criterion& criterion) {
  if (!optimizer.options.flips) return 0;
  const Backend& backend = optimizer.backend;
  WorkingSet<Backend>& work = optimizer.work;
  optimizer.changed.clear(backend, work.mesh.vertices());
  const Span<std::uint8_t> changed = optimizer.changed.output();
  FlipCounts flips = face_removal_pass(backend, work.mesh, criterion, work.flips, changed).counts;
  flips += flip_until_none(backend, work.mesh, criterion, work.flips, changed);
  activate(backend, optimizer.changed, work.dofs);
  optimizer.record_flips(flips);
  return flips.flips();
}

namespace improve_around_detail {

/// At most kMinProposers + kProposingFraction * tets tetrahedra are processed per pass: in structured meshes all
/// elements tie for the worst angle.
inline constexpr Size kMinProposers = 250;
inline constexpr double kProposingFraction = 4e-3;

/// Retriangulates around the listed tetrahedra; adds inserted and removed vertices to `r`, and all other changes as
/// flips.
template <class Backend>
void retriangulate(Optimizer<Backend>& optimizer, const Criterion& criterion, Span<const Index> tets,
                   RetriangulationLimits limits, WorstReport& r) {
  Report& report = optimizer.report;
  const Options& options = optimizer.options;
  WorkingSet<Backend>& work = optimizer.work;
  if (limits.mean_energy == 0) {
    const auto max_proposers = kMinProposers + static_cast<Size>(kProposingFraction * selection_scale(options) *
                                                                 static_cast<double>(work.mesh.tets()));
    tets = {tets.data(), std::min(tets.size(), max_proposers)};
  }
  limits.max_removed = work.removable;
  const RetriangulationReport changes =
      retriangulate_worst(optimizer.backend,
                          EditableMesh<Backend>{.mesh = work.mesh,
                                                .flips = work.flips,
                                                .dofs = work.dofs,
                                                .boundary = edits_surface(options) ? &work.boundary : nullptr},
                          criterion, tets, limits);
  r.inserted = changes.inserted;
  r.removed = changes.removed;
  r.flips = changes.others;
  report.vertices_inserted += changes.inserted;
  report.vertices_removed += changes.removed;
  report.compound_flips += changes.others;
  work.removable -= changes.removed - changes.inserted;
}

/// Flips from the tetrahedra on that have an edge between active vertices. Returns the number of flips.
template <class Backend>
Size flip_around_active(Optimizer<Backend>& optimizer, const Criterion& criterion) {
  if (!optimizer.options.flips) return 0;
  WorkingSet<Backend>& work = optimizer.work;
  activate_around(optimizer.backend, work.mesh, work.flips, Span<const std::uint8_t>(work.dofs.active.span()));
  const Size flips = flip_boundary_at_active(optimizer, criterion);
  return flips + flip_until_none_active(optimizer, criterion);
}

}  // namespace improve_around_detail

/// The limits of a retriangulation. Vertices are inserted and removed at angles whose cost is above `vertex_cost`
/// (kInfeasible: nowhere). `max_fraction`: a bound on the fraction of the growth of the mesh that retriangulation may
/// use up.
template <class Backend>
RetriangulationLimits retriangulation_limits(const Optimizer<Backend>& optimizer, double vertex_cost,
                                             double max_fraction = 1) {
  const auto tets = static_cast<double>(optimizer.report.tets_before);
  const double max_added = (optimizer.options.max_growth - 1) * tets;
  // Does not depend on Options::restarts: the result before restarts is the same with any number of them, so that they
  // do no harm.
  const bool may_be_restarted = !optimizer.work.is_neighborhood && optimizer.tuning.restart.rounds > 0;
  const double fraction =
      std::min(max_fraction,
               may_be_restarted ? inserted_fraction_before(optimizer.tuning.restart, max_added) : kInsertedFraction);
  const auto max_tets = static_cast<Size>(tets + fraction * max_added);
  return {.max_tets = max_tets - optimizer.work.outside,
          .vertex_cost = vertex_cost,
          .min_gain = optimizer.tuning.angles.min_cost_gain};
}

/// The result of improve_around().
template <class Backend>
struct Improved {
  BufferOf<Backend, Index> affected;  ///< the tetrahedra with a vertex that may have moved
  typename Optimizer<Backend>::Swept swept;
};

/// Improves the neighborhood of the listed tetrahedra: retriangulates around the `proposers` among them, flips, and
/// moves their vertices and the neighbors of these. The energies of the slots are up to date before and afterwards.
/// Only the vertices that may have moved have rings afterwards.
template <class Backend>
Improved<Backend> improve_around(Optimizer<Backend>& optimizer, const Criterion& criterion, Span<const Index> tets,
                                 Span<const Index> proposers, const RetriangulationLimits& limits, WorstReport& r) {
  using namespace improve_around_detail;
  const Backend& backend = optimizer.backend;
  WorkingSet<Backend>& work = optimizer.work;
  backend.fill(work.dofs.active.span(), std::uint8_t{0});
  flag_vertices(backend, work.mesh, tets, work.dofs.active.span());
  if (!backend.stop_requested()) retriangulate(optimizer, criterion, proposers, limits, r);
  r.flips += flip_around_active(optimizer, criterion);
  const Span<std::uint8_t> active = work.dofs.active.span();
  flag_neighbors(backend, work.mesh, active);
  flag_images(backend, work.periodic, active);
  auto affected = tets_with_flagged_vertex(backend, work.mesh, Span<const std::uint8_t>(active));
  optimizer.refresh_rings_of_active(affected.span());
  const auto swept = optimizer.sweep_once(criterion, SweepScope::selection);
  refresh_energy_of(backend, work.mesh, criterion, work.flips.energies, std::as_const(affected).span());
  return {std::move(affected), swept};
}

/// Same, with all listed tetrahedra as proposers.
template <class Backend>
Improved<Backend> improve_around(Optimizer<Backend>& optimizer, const Criterion& criterion, Span<const Index> tets,
                                 const RetriangulationLimits& limits, WorstReport& r) {
  return improve_around(optimizer, criterion, tets, tets, limits, r);
}

}  // namespace tetune

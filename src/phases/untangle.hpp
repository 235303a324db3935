// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "operators/flip_pass.hpp"
#include "phases/element_selection.hpp"
#include "phases/optimizer.hpp"
#include "phases/surface_folds.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace untangle_detail {

/// Makes the vertices of tangled tetrahedra the active ones. Returns the number of these tetrahedra.
template <class Backend>
Size activate_tangled(const Backend& backend, WorkingSet<Backend>& work) {
  const auto tets = find_tets(backend, work.mesh, HasUncertifiedVolume{work.mesh.view()});
  const Span<std::uint8_t> active = work.dofs.active.span();
  backend.fill(active, std::uint8_t{0});
  flag_vertices(backend, work.mesh, tets.span(), active);
  return tets.size();
}

/// Flips around active vertices until there are no more flips.
template <class Backend>
void flip_around_active(const Backend& backend, WorkingSet<Backend>& work) {
  const Criterion criterion{kShapeObjective};
  refresh_energy(backend, work.mesh, criterion, work.flips.energies);
  activate_all(backend, work.mesh, criterion, work.flips);
  activate_around(backend, work.mesh, work.flips, Span<const std::uint8_t>(work.dofs.active.span()));
  flip_until_none(backend, work.mesh, criterion, work.flips, {});
}

/// Rounds of soft sweeps and flips. Stops when no tetrahedron is tangled or the caller cancels.
template <class Backend>
void run_rounds(Optimizer<Backend>& optimizer) {
  const UntangleParameters& p = optimizer.tuning.untangle;
  const Backend& backend = optimizer.backend;
  WorkingSet<Backend>& work = optimizer.work;
  Size tangled = activate_tangled(backend, work);
  bool go_on = true;
  for (int round = 0; round < p.max_rounds && tangled > 0 && go_on; ++round) {
    if (round >= p.first_flip_round && work.flips.max_ring > 0) {
      flip_around_active(backend, work);
      tangled = activate_tangled(backend, work);
    }
    build_rings(backend, work.mesh, work.rings);
    color_vertices(backend, work.rings.view(), work.dofs.dof.span(), work.coloring, work.dofs.stars());
    Criterion criterion{kShapeObjective};
    criterion.objective.regularization = p.regularizations[backend::to_size_t(round) % p.regularizations.size()];
    for (int i = 0; i < p.max_sweeps && tangled > 0 && go_on; ++i) {
      flag_neighbors(backend, work.mesh, work.dofs.active.span());
      sweep<RegularizedRing>(backend, work.mesh, criterion, work.rings.view(), work.coloring, work.dofs,
                             NewtonStep{1, optimizer.tuning.relocation.min_gain}, SweepScope::selection);
      tangled = activate_tangled(backend, work);
      criterion.objective.regularization *= p.regularization_decay;
      go_on = optimizer.proceed(Phase::untangling, 0);
    }
  }
  backend.fill(work.dofs.active.span(), std::uint8_t{1});
}

/// Returns the slots whose volume is still not positive, or where the surface has become folded.
template <class Backend>
std::vector<Index> untangle_slots(Optimizer<Backend>& optimizer) {
  WorkMesh<Backend>& mesh = optimizer.work.mesh;
  const std::vector<VertexDof> kind = optimizer.work.dofs.dof.download();
  const std::vector<std::uint8_t> folded = folded_vertices(HostMesh(mesh), kind);
  run_rounds(optimizer);
  const HostMesh result(mesh);
  const std::vector<Index> left =
      exactly_tangled(result, find_tets(optimizer.backend, mesh, HasUncertifiedVolume{mesh.view()}).download());
  return left.empty() ? newly_folded(result, kind, folded) : left;
}

}  // namespace untangle_detail

/// Makes all volumes positive: vertices move under an energy that stays finite where a volume vanishes (docs/method.md,
/// "Untangling"). Throws UntangleError if tetrahedra remain that are not positive, or if the surface would fold.
template <class Backend>
void untangle(Optimizer<Backend>& optimizer) {
  std::vector<Index> left;
  optimizer.timer.measure(Phase::untangling, [&] { left = untangle_detail::untangle_slots(optimizer); });
  optimizer.report.tets_untangled = optimizer.work.tangled;
  if (left.empty()) return;
  const std::vector<Index> tet2original = optimizer.work.mesh.tet2original.download();
  for (Index& t : left) t = backend::span_of(tet2original)[t];
  std::sort(left.begin(), left.end());
  left.erase(std::unique(left.begin(), left.end()), left.end());
  using Reason = UntangleError::Reason;
  throw UntangleError(optimizer.work.tangled, std::move(left),
                      optimizer.backend.stop_requested()              ? Reason::stopped
                      : optimizer.options.boundary == Boundary::slide ? Reason::no_room_though_sliding
                                                                      : Reason::no_room);
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "phases/lower_mean_energy.hpp"

namespace tetune {

/// Lowers an objective over the whole mesh, which work on a few tetrahedra has raised: by inserted and removed vertices
/// (lower_mean_energy()), then by sweeps, the first ones with flips. No tetrahedron becomes worse than the present
/// worst, and no angle goes beyond those that `reached` allows. Returns false when the caller cancels.
template <class Backend>
bool polish(Optimizer<Backend>& optimizer, const Objective& objective, const QualityFloor& reached) {
  const PolishParameters& p = optimizer.tuning.polish;
  if (p.sweeps == 0) return true;
  const Backend& backend = optimizer.backend;
  WorkingSet<Backend>& work = optimizer.work;
  Criterion criterion{objective};
  optimizer.timer.measure(Phase::angles, [&] {
    optimizer.sum_energy(kShapeObjective);
    const AngleParameters& angles = optimizer.tuning.angles;
    criterion.floor =
        find_floor(backend, work.mesh, optimizer.slot_energies(), -angles.min_cost / angles.obtuse_weight);
    const AngleExtremes<Backend> extremes(backend, work.mesh, optimizer.slot_energies(), angles.min_cost,
                                          angles.obtuse_weight);
    criterion.floor.limit_cost((1 + QualityFloor::kTolerance) * extremes.largest(), angles.obtuse_weight);
    criterion.floor.limit_angles(reached.extremes());
  });
  if (!lower_mean_energy(optimizer, p.mean, criterion)) return false;
  backend.fill(work.dofs.active.span(), std::uint8_t{1});
  for (int sweep = 1; sweep <= p.sweeps; ++sweep) {
    const bool ready = optimizer.refresh_rings();
    optimizer.timer.measure(Phase::angles, [&] {
      if (!ready) return;
      optimizer.sweep_once(criterion, SweepScope::mesh);
      if (sweep > p.sweeps_with_flips) return;
      optimizer.release_rings();
      if (sweep == 1) {
        optimizer.sum_energy(criterion.objective);
        activate_all(backend, work.mesh, criterion, work.flips);
      } else {
        activate_drifted(backend, work.mesh, criterion, work.flips);
      }
      if (work.boundary.flips_bend) flip_boundary_at_active(optimizer, criterion);
      flip_until_none_active(optimizer, criterion);
    });
    optimizer.progress.estimate.finish_polish_sweep(sweep, p.sweeps);
    if (!optimizer.proceed(Phase::angles, optimizer.iteration())) return false;
  }
  return true;
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "phases/flip_until_stable.hpp"
#include "phases/optimizer.hpp"
#include "phases/schedule.hpp"

namespace tetune {
namespace alternate_detail {

/// One sweep over the active vertices.
template <class Backend>
const SweepReport& relocate(Optimizer<Backend>& optimizer, const Criterion& criterion, int iteration) {
  SweepReport r;
  r.iteration = iteration;
  r.energy_before = optimizer.in_callers_unit(optimizer.energy());
  // The paper's sweep visits all vertices.
  if (optimizer.options.termination == Termination::paper) {
    optimizer.backend.fill(optimizer.work.dofs.active.span(), std::uint8_t{1});
  }
  SweepSum sum;
  if (optimizer.refresh_rings()) {
    r.seconds =
        optimizer.timer.measure(Phase::sweeps, [&] { sum = optimizer.sweep_once(criterion, SweepScope::mesh).get(); });
  }
  optimizer.decrease_energy(sum.decrease, criterion.objective);
  r.decrease = optimizer.in_callers_unit(sum.decrease);
  r.gradient_norm2 = sum.gradient2;
  r.moved = sum.moved;
  r.dihedral_min = optimizer.traced_angle();
  optimizer.report.sweeps.push_back(r);
  return optimizer.report.sweeps.back();
}

}  // namespace alternate_detail

/// Alternates flips and sweeps until the energy no longer decreases by a relevant part (Sect. 4.5). Reports
/// Report::sweeps and Report::flip_passes. Requires the energies of all slots. Returns false when the caller cancels.
template <class Backend>
bool alternate(Optimizer<Backend>& optimizer, const Criterion& criterion) {
  using namespace alternate_detail;
  const Backend& backend = optimizer.backend;
  const Options& options = optimizer.options;
  WorkingSet<Backend>& work = optimizer.work;
  FlipUntilStable<Backend> flips(optimizer, criterion);
  const bool sweeps_follow = options.termination == Termination::relative && options.max_iterations > 0;
  activate_all(backend, work.mesh, criterion, work.flips,
               sweeps_follow && options.energy == Energy::shape ? optimizer.tuning.alternation.first_flip_energy : 0);
  if (!flips.run(0)) return false;
  Schedule schedule(options);
  optimizer.report.stop = StopReason::iteration_limit;
  double last_energy = optimizer.energy();
  for (int iteration = 1; iteration <= options.max_iterations; ++iteration) {
    const double energy_before_round = optimizer.energy();
    const SweepReport& sweep = relocate(optimizer, criterion, iteration);
    optimizer.progress.estimate.finish_sweep(iteration, 1 - optimizer.energy() / last_energy);
    last_energy = optimizer.energy();
    if (!optimizer.proceed(Phase::sweeps, iteration)) return false;
    if (options.flips && schedule.flips_due(iteration)) {
      optimizer.timer.measure(Phase::flips, [&] {
        optimizer.release_rings();
        optimizer.set_energy(activate_drifted(backend, work.mesh, criterion, work.flips, flips.min_energy()));
      });
      const double energy_before_flips = optimizer.energy();
      const std::optional<Size> made = flips.run(iteration);
      if (!made) return false;
      schedule.record_flips(iteration, *made, 1 - optimizer.energy() / energy_before_flips);
    }
    if (schedule.stop(sweep, energy_before_round, optimizer.energy(), optimizer.report.stop)) break;
  }
  return true;
}

}  // namespace tetune

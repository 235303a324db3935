// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/elementary.hpp"
#include "phases/improve_around.hpp"

namespace tetune {

/// Improves the neighborhood of the tetrahedra of the largest energy, in rounds, under a power of the shape energy that
/// they dominate. Reports Report::worst_rounds. Returns false when the caller cancels.
template <class Backend>
bool improve_worst(Optimizer<Backend>& optimizer, const QualityFloor& floor) {
  const WorstParameters& p = optimizer.tuning.worst;
  const Backend& backend = optimizer.backend;
  WorkingSet<Backend>& work = optimizer.work;
  const Criterion criterion{shape_objective(p.log2_power), floor};
  const RetriangulationLimits limits = retriangulation_limits(optimizer, kInfeasible);
  const auto tets = static_cast<double>(work.mesh.tets());
  Size budget = static_cast<Size>(p.budget) + static_cast<Size>(p.budget_fraction * tets);
  double bound = 0;
  double last_energy = 0;
  optimizer.timer.measure(Phase::worst, [&] {
    optimizer.sum_energy(kShapeObjective);
    const double quantile = upper_quantile(backend, optimizer.slot_energies(), p.max_fraction * tets);
    bound = elementary::repeated_square(std::max(p.min_energy, quantile), p.log2_power);
    last_energy = refresh_energy(backend, work.mesh, criterion, work.flips.energies);
  });
  for (int round = 1; round <= p.max_rounds; ++round) {
    WorstReport r;
    r.work = "worst";
    r.round = round;
    double energy = last_energy;
    r.seconds = optimizer.timer.measure(Phase::worst, [&] {
      const auto worst = tets_above(backend, work.mesh, optimizer.slot_energies(), bound);
      r.worst = worst.size();
      if (r.worst == 0) return;
      const auto improved = improve_around(optimizer, criterion, worst.span(), limits, r);
      energy = sum_energy(backend, work.flips.energies);
      r.moved = improved.swept.get().moved;
    });
    if (r.worst == 0) break;
    r.dihedral_min = optimizer.traced_angle();
    optimizer.report.worst_rounds.push_back(r);
    optimizer.progress.estimate.finish_worst_round(round);
    if (!optimizer.proceed(Phase::worst, optimizer.iteration())) return false;
    budget -= r.worst;
    if (energy > (1 - p.min_decrease) * last_energy || (p.has_budget && budget < 0)) break;
    last_energy = energy;
  }
  return true;
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "phases/improve_around.hpp"

namespace tetune {
namespace lower_mean_energy_detail {

/// One round. Returns by which part of what it is above that of regular tetrahedra the mean energy fell.
template <class Backend>
double lower_once(Optimizer<Backend>& optimizer, const Criterion& criterion, RetriangulationLimits limits,
                  WorstReport& r) {
  const Backend& backend = optimizer.backend;
  WorkingSet<Backend>& work = optimizer.work;
  const auto mean_energy = [&] { return optimizer.energy() / static_cast<double>(work.mesh.tets()); };
  limits.mean_energy = mean_energy();
  const double max_above = optimizer.tuning.mean.max_part * static_cast<double>(work.mesh.tets());
  const double bound = upper_quantile(backend, optimizer.slot_energies(), max_above);
  const auto worst = tets_above(backend, work.mesh, optimizer.slot_energies(), bound);
  r.worst = worst.size();
  const auto improved = improve_around(optimizer, criterion, worst.span(), limits, r);
  optimizer.set_energy(sum_energy(backend, work.flips.energies));
  r.moved = improved.swept.get().moved;
  return (limits.mean_energy - mean_energy()) / (limits.mean_energy - 1);
}

}  // namespace lower_mean_energy_detail

/// Inserts and removes vertices where that lowers the mean energy of the mesh, in rounds around its tetrahedra of the
/// largest energies. Reports Report::worst_rounds. Returns false when the caller cancels.
template <class Backend>
bool lower_mean_energy(Optimizer<Backend>& optimizer, const QualityFloor& floor) {
  const MeanParameters& p = optimizer.tuning.mean;
  if (!edits_vertices(optimizer.options)) return true;
  const Criterion criterion{kShapeObjective, floor};
  RetriangulationLimits limits = retriangulation_limits(optimizer, kInfeasible, p.growth_part);
  limits.min_gain = p.min_gain;
  const Report& report = optimizer.report;
  const auto max_removed =
      static_cast<std::int64_t>(p.max_removed * static_cast<double>(optimizer.work.mesh.vertices()));
  optimizer.timer.measure(Phase::worst, [&] { optimizer.sum_energy(kShapeObjective); });
  double fall = 1;
  for (int round = 1; round <= p.max_rounds && fall > p.min_fall; ++round) {
    if (report.vertices_removed - report.vertices_inserted > max_removed) break;
    WorstReport r;
    r.round = round;
    r.seconds = optimizer.timer.measure(
        Phase::worst, [&] { fall = lower_mean_energy_detail::lower_once(optimizer, criterion, limits, r); });
    r.dihedral_min = optimizer.traced_angle();
    optimizer.report.worst_rounds.push_back(r);
    if (!optimizer.proceed(Phase::worst, optimizer.iteration())) return false;
  }
  return true;
}

}  // namespace tetune

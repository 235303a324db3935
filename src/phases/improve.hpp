// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "phases/alternate.hpp"
#include "phases/improve_angles.hpp"
#include "phases/improve_worst.hpp"
#include "phases/lower_mean_energy.hpp"
#include "phases/polish.hpp"
#include "phases/restart/restart_worst.hpp"

namespace tetune {
namespace improve_detail {

/// Computes the energies of the mesh, and its quality floor.
template <class Backend>
Criterion measure_mesh(Optimizer<Backend>& optimizer) {
  Criterion criterion{optimizer.objective()};
  const bool has_floor = optimizer.options.energy == Energy::shape;
  const double seconds = optimizer.timer.measure(Phase::load, [&] {
    optimizer.sum_energy(criterion.objective);
    if (has_floor) {
      criterion.floor = find_floor(optimizer.backend, optimizer.work.mesh, optimizer.slot_energies());
    }
  });
  if (has_floor) optimizer.progress.set_smallest_angle(criterion.floor.max_cot, seconds);
  if (optimizer.report.energy_before == 0)
    optimizer.report.energy_before = optimizer.in_callers_unit(optimizer.energy());
  return criterion;
}

}  // namespace improve_detail

/// Improves a mesh of positive volumes: the phases after untangling, in order. Returns false when the caller cancels.
template <class Backend>
bool improve(Optimizer<Backend>& optimizer) {
  Criterion criterion = improve_detail::measure_mesh(optimizer);
  if (!optimizer.proceed(Phase::load, 0) || !alternate(optimizer, criterion)) return false;
  if (!improves_worst(optimizer.options)) return true;
  optimizer.work.boundary.flips_bend = false;
  optimizer.work.removable = removable_vertices(optimizer.report.vertices);
  const Objective objective = mean_objective(optimizer);
  if (!lower_mean_energy(optimizer, optimizer.tuning.mean, {objective, criterion.floor}) ||
      !improve_worst(optimizer, criterion.floor))
    return false;
  criterion.floor.relax_mean_ratio(optimizer.tuning.angles.mean_ratio_fraction);
  const QualityFloor input_floor = criterion.floor;
  return improve_angles(optimizer, criterion.floor) && restart_worst(optimizer, input_floor, criterion.floor) &&
         polish(optimizer, objective, criterion.floor);
}

}  // namespace tetune

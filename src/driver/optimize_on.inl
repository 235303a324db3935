// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "driver/devices.hpp"
#include "driver/export_mesh.hpp"
#include "driver/import_mesh.inl"
#include "driver/targets.hpp"
#include "phases/alternate.hpp"
#include "phases/improve_angles.hpp"
#include "phases/improve_worst.hpp"
#include "phases/polish.hpp"
#include "phases/untangle.hpp"

namespace tetune {
namespace optimize_on_detail {

/// Computes the energies of the mesh, and the floor below which no later phase takes a tetrahedron.
template <class Backend>
Criterion measure_input(Optimizer<Backend>& optimizer) {
  Criterion criterion{optimizer.objective()};
  const bool has_floor = optimizer.options.energy == Energy::shape;
  const double seconds = optimizer.timer.measure(Phase::load, [&] {
    optimizer.sum_energy(criterion.objective);
    if (has_floor) {
      criterion.floor = find_floor(optimizer.backend, optimizer.work.mesh, optimizer.slot_energies());
    }
  });
  if (has_floor) optimizer.progress.set_smallest_angle(criterion.floor.max_cot, seconds);
  optimizer.report.energy_before = optimizer.in_callers_unit(optimizer.energy());
  return criterion;
}

/// Runs the phases in order, until one is cancelled.
template <class Backend>
void run_phases(Optimizer<Backend>& optimizer) {
  if (optimizer.work.tangled > 0) untangle(optimizer);
  Criterion criterion = measure_input(optimizer);
  if (!optimizer.proceed(Phase::load, 0) || !alternate(optimizer, criterion)) return;
  if (!improves_worst(optimizer.options)) return;
  if (!improve_worst(optimizer, criterion.floor)) return;
  if (!improve_angles(optimizer, criterion.floor)) return;
  polish(optimizer, criterion.floor);
}

}  // namespace optimize_on_detail

template <class Backend>
Report optimize_on(const Backend& backend, TetMesh& mesh, const Options& options, const Context& context,
                   SlideSurface* surface) {
  const auto start = PhaseTimer::SteadyClock::now();
  Report report;
  PhaseTimer timer(report);
  report.vertices = std::ssize(mesh.points);
  report.tets_before = std::ssize(mesh.tets);
  WorkingSet<Backend> work;
  timer.measure(Phase::load, [&] { import_mesh(backend, mesh, options, surface, work, report); });

  Optimizer<Backend> optimizer(backend, work, options, context, report, timer, start);
  optimize_on_detail::run_phases(optimizer);
  optimizer.sum_energy(optimizer.objective());
  report.energy_after = optimizer.in_callers_unit(optimizer.energy());

  if (!options.targets.empty()) {
    timer.measure(Phase::targets, [&] { report.targets = report_targets(outcome_of(work, mesh), options); });
  }
  timer.measure(Phase::store, [&] { export_mesh(backend, work, options, mesh, surface, report); });
  report.tets_after = std::ssize(mesh.tets);
  return report;
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "phases/improve_around.hpp"
#include "relocation/minimize_angle_cost.hpp"

namespace tetune {
namespace improve_angles_detail {

/// One round. Returns the number of changes.
template <class Backend>
Size improve_once(Optimizer<Backend>& optimizer, QualityFloor& floor, WorstReport& r) {
  const AngleParameters& p = optimizer.tuning.angles;
  const Backend& backend = optimizer.backend;
  WorkingSet<Backend>& work = optimizer.work;
  const AngleExtremes<Backend> extremes(backend, work.mesh, optimizer.slot_energies(), p.min_cost, p.obtuse_weight);
  const double selectable = selection_scale(optimizer.options) * static_cast<double>(work.mesh.tets());
  const auto cost_of = [&](double part, double min_count) {
    const double max_above = std::max(part * selectable, min_count);
    return std::max(p.min_cost, upper_cost_quantile(backend, extremes.values.span(), max_above));
  };
  const double cost = cost_of(p.max_part, p.min_count);
  const auto extreme = tets_above(backend, work.mesh, extremes.values.span(), std::sqrt(1 + cost * cost));
  r.worst = extreme.size();
  // From now on no angle may cost more than the worst at present; shapes may become worse in between.
  floor.limit_cost((1 + QualityFloor::kTolerance) * extremes.max_cost, p.obtuse_weight);
  const Criterion criterion{kShapeObjective, floor, p.obtuse_weight};
  const AngleParameters& vertices = p.max_vertex_part > 0 ? p : tuning_of(Effort::best).angles;
  const double vertex_cost =
      edits_vertices(optimizer.options) ? cost_of(vertices.max_vertex_part, vertices.min_vertex_count) : kInfeasible;
  const auto affected = improve_around(optimizer, criterion, extreme.span(), vertex_cost, r);
  VertexMask<Backend> selected(backend, work.mesh.vertices());
  backend.fill(selected.span(), std::uint8_t{0});
  flag_vertices_of_extreme(backend, work.mesh, criterion, affected.span(), cost, selected.span());
  Size moved = 0;
  for (int pass = 0; pass < p.opening_passes; ++pass) {
    moved += minimize_angle_cost(backend, work.mesh, criterion, work.rings.view(), work.coloring, work.dofs,
                                 Span<const std::uint8_t>(selected.span()), cost);
    if (work.periodic.classes() == 0) continue;
    moved += minimize_periodic_cost(backend, work.mesh, criterion, work.rings.view(), work.periodic,
                                    Span<const std::uint8_t>(selected.span()), cost);
  }
  refresh_energy_of(backend, work.mesh, criterion, work.flips.energies, affected.span());
  optimizer.set_energy(sum_energy(backend, work.flips.energies));
  r.moved += moved;
  return r.inserted + r.removed + r.flips + moved;
}

}  // namespace improve_angles_detail

/// Lowers the largest cost of the dihedral angles (DihedralCots::cost()), in rounds: the neighborhood of their
/// tetrahedra is improved, with Effort::best by inserted and removed vertices too, and vertices are moved to where the
/// largest cost around them is lowest. Tightens `floor` to the angles of each round. Reports Report::worst_rounds.
/// Returns false when the caller cancels.
template <class Backend>
bool improve_angles(Optimizer<Backend>& optimizer, QualityFloor& floor) {
  const int rounds = optimizer.tuning.angles.max_rounds;
  // Not earlier: flips that lower the energy would use up the bound that the worst angles need.
  optimizer.work.boundary.bends = bends_surface(optimizer.options);
  optimizer.timer.measure(Phase::angles, [&] { optimizer.sum_energy(kShapeObjective); });
  for (int round = 1; round <= rounds; ++round) {
    WorstReport r;
    r.round = round;
    Size changes = 0;
    r.seconds = optimizer.timer.measure(Phase::angles,
                                        [&] { changes = improve_angles_detail::improve_once(optimizer, floor, r); });
    r.dihedral_min = optimizer.traced_angle();
    optimizer.report.worst_rounds.push_back(r);
    optimizer.progress.estimate.finish_angle_step(round, rounds + optimizer.tuning.polish.sweeps);
    if (!optimizer.proceed(Phase::angles, optimizer.iteration())) return false;
    if (changes == 0) break;
  }
  return true;
}

}  // namespace tetune

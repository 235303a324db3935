// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "phases/improve_around.hpp"
#include "relocation/minimize_angle_cost.hpp"

namespace tetune {
namespace improve_angles_detail {

/// The parameters of the last rounds.
inline AngleParameters last_parameters(AngleParameters p) {
  constexpr double kResolution = 5e-4;
  p.max_fraction = p.max_vertex_fraction = 0;
  p.min_count = p.min_vertex_count = p.last_count;
  p.cost_resolution = kResolution;
  p.moves_neighbors = true;
  return p;
}

/// Whether many tetrahedra have about the largest cost, and it is above `tied_cost`.
template <class Backend>
bool has_many_tied(Optimizer<Backend>& optimizer, const AngleExtremes<Backend>& extremes) {
  const AngleParameters& p = optimizer.tuning.angles;
  const auto above_tied_cost = static_cast<double>(extremes.count_above(optimizer.backend, p.tied_cost));
  if (above_tied_cost <= p.min_tied) return false;
  const double of_tied = extremes.quantile(optimizer.backend, p.min_tied, p.cost_resolution);
  const double fraction = extremes.largest() > p.thin_cost ? p.thin_tied_fraction : p.tied_fraction;
  return of_tied >= (1 - fraction) * extremes.largest();
}

/// The result of improve_once().
template <class Backend>
struct AngleRound {
  Size changes = 0;
  BufferOf<Backend, Index> affected;  ///< the tetrahedra that may have changed
};

/// One round, on the tetrahedra of the largest costs in `extremes`.
template <class Backend>
AngleRound<Backend> improve_once(Optimizer<Backend>& optimizer, const AngleParameters& p,
                                 const AngleExtremes<Backend>& extremes, QualityFloor& floor, WorstReport& r) {
  const Backend& backend = optimizer.backend;
  WorkingSet<Backend>& work = optimizer.work;
  const double selectable = selection_scale(optimizer.options) * static_cast<double>(work.mesh.tets());
  const auto cost_of = [&](double max_above) { return extremes.quantile(backend, max_above, p.cost_resolution); };
  const double cost =
      cost_of(std::max(p.max_fraction * selectable, std::min(p.min_count, p.small_mesh_fraction * selectable)));
  const auto extreme = tets_above(backend, work.mesh, extremes.costs(), cost);
  r.worst = extreme.size();
  // From now on no angle may cost more than the worst at present; shapes may become worse in between.
  floor.limit_cost((1 + QualityFloor::kTolerance) * extremes.largest(), p.obtuse_weight);
  const Criterion criterion{kShapeObjective, floor, p.obtuse_weight};
  const AngleParameters& vertices = p.min_vertex_count > 0 ? p : tuning_of(Effort::best).angles;
  const double vertex_cost =
      edits_vertices(optimizer.options)
          ? cost_of(std::max(vertices.max_vertex_fraction * selectable, vertices.min_vertex_count))
          : kInfeasible;
  auto improved =
      improve_around(optimizer, criterion, extreme.span(), retriangulation_limits(optimizer, vertex_cost), r);
  VertexMask<Backend> selected(backend, work.mesh.vertices());
  backend.fill(selected.span(), std::uint8_t{0});
  flag_vertices_of_extreme(backend, work.mesh, criterion, improved.affected.span(), cost, selected.span());
  if (p.moves_neighbors) flag_neighbors(backend, work.mesh, selected.span());
  const double target = p.moves_neighbors ? p.min_cost : cost;
  std::vector<ResultOf<Backend, Sum<Size>>> moved;
  for (int pass = 0; pass < p.opening_passes; ++pass) {
    moved.push_back(minimize_angle_cost(backend, work.mesh, criterion, work.movable_vertices(),
                                        Span<const std::uint8_t>(selected.span()), target));
    if (work.periodic.classes() == 0) continue;
    moved.push_back(minimize_periodic_cost(backend, work.mesh, criterion, work.movable_classes(),
                                           Span<const std::uint8_t>(selected.span()), target));
  }
  refresh_energy_of(backend, work.mesh, criterion, work.flips.energies, improved.affected.span());
  optimizer.set_energy(sum_energy(backend, work.flips.energies));
  Size opened = 0;
  for (const auto& m : moved) opened += m.get().value;
  r.moved = improved.swept.get().moved + opened;
  return {r.inserted + r.removed + r.flips + opened, std::move(improved.affected)};
}

}  // namespace improve_angles_detail

/// Lowers the largest cost of the dihedral angles (DihedralCots::cost()), in rounds: the neighborhood of their
/// tetrahedra is improved, with Effort::best by inserted and removed vertices too, and vertices are moved to where the
/// largest cost around them is lowest. Further rounds follow where many tetrahedra have about the largest cost; the
/// last ones work on a few. Tightens `floor` to the angles before each round. Reports Report::worst_rounds. Returns
/// false when the caller cancels.
template <class Backend>
bool improve_angles(Optimizer<Backend>& optimizer, QualityFloor& floor) {
  using namespace improve_angles_detail;
  const AngleParameters& parameters = optimizer.tuning.angles;
  const int rounds = parameters.rounds();
  optimizer.work.boundary.flips_bend = optimizer.work.boundary.bends;
  std::optional<AngleExtremes<Backend>> extremes;
  optimizer.timer.measure(Phase::angles, [&] {
    optimizer.sum_energy(kShapeObjective);
    extremes.emplace(optimizer.backend, optimizer.work.mesh, optimizer.slot_energies(), parameters.min_cost,
                     parameters.obtuse_weight);
  });
  int round = 0, stalls = 0;
  double worked_on = 0;
  const auto run_rounds = [&](int limit, const AngleParameters& p, const auto& follows) {
    stalls = 0;
    for (int i = 0; i < limit && follows(); ++i) {
      const double cost_before = floor.max_cot;
      WorstReport r;
      r.work = "angles";
      r.round = ++round;
      Size changes = 0;
      r.seconds = optimizer.timer.measure(Phase::angles, [&] {
        const auto made = improve_once(optimizer, p, *extremes, floor, r);
        extremes->update(optimizer.backend, optimizer.work.mesh, optimizer.slot_energies(), made.affected.span());
        changes = made.changes;
      });
      r.dihedral_min = optimizer.traced_angle();
      worked_on += static_cast<double>(r.worst);
      optimizer.report.worst_rounds.push_back(r);
      optimizer.progress.estimate.finish_angle_round(round, rounds);
      if (!optimizer.proceed(Phase::angles, optimizer.iteration())) return false;
      if (changes == 0) break;
      stalls = floor.max_cot > (1 - p.min_fall) * cost_before ? stalls + 1 : 0;
    }
    return true;
  };
  const auto has_fallen = [&] { return stalls < parameters.max_stalls; };
  const auto has_many_tied_left = [&] {
    bool has = false;
    if (has_fallen()) optimizer.timer.measure(Phase::angles, [&] { has = has_many_tied(optimizer, *extremes); });
    return has;
  };
  const auto has_budget = [&] { return worked_on < parameters.budget; };
  if (!run_rounds(parameters.max_rounds, parameters, has_budget)) return false;
  if (!run_rounds(parameters.tied_rounds, parameters, has_many_tied_left)) return false;
  return run_rounds(parameters.last_rounds, last_parameters(parameters), has_fallen);
}

}  // namespace tetune

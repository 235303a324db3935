// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "phases/improve_angles.hpp"

namespace tetune {
namespace restart_worst_detail {

/// The mesh before a restart.
template <class Backend>
class SavedMesh {
 public:
  void save(const Backend& backend, const WorkingSet<Backend>& work) {
    mesh_.assign(backend, work.mesh);
    dofs_.assign_vertices(backend, work.dofs);
    triangles_.assign(backend, work.boundary.triangles);
    constrained_vertex_.assign(backend, work.flips.constrained_vertex);
    coloring_.assign(backend, work.coloring);
  }
  /// The energies and rings have to be computed again, and the coloring brought up to date.
  void restore(const Backend& backend, WorkingSet<Backend>& work) const {
    work.mesh.assign(backend, mesh_);
    work.dofs.assign_vertices(backend, dofs_);
    work.boundary.triangles.assign(backend, triangles_);
    work.boundary.stale = true;
    work.flips.constrained_vertex.assign(backend, constrained_vertex_);
    work.coloring.assign(backend, coloring_);
    work.flips.slack.resize(backend, work.mesh.slots());
    backend.fill(work.flips.slack.span(), kUnknownSlack);
  }

 private:
  WorkMesh<Backend> mesh_;
  VertexDofs<Backend> dofs_;
  BufferOf<Backend, BoundaryTriangle> triangles_;
  BufferOf<Backend, std::uint8_t> constrained_vertex_;
  Coloring<Backend> coloring_;
};

/// Vertices around some tetrahedra. Vertices that are inserted later belong to them.
template <class Backend>
class Region {
 public:
  Region(const Backend& backend, WorkMesh<Backend>& mesh, Span<const Index> tets, int rings)
      : flags_(backend, mesh.vertices()) {
    backend.fill(flags_.span(), std::uint8_t{0});
    flag_vertices(backend, mesh, tets, flags_.span());
    flag_neighbors(backend, mesh, flags_.span(), rings);
  }
  Span<const std::uint8_t> flags(const Backend& backend, const WorkMesh<Backend>& mesh) {
    const Size before = flags_.size();
    flags_.grow(backend, mesh.vertices());
    backend.fill(Span<std::uint8_t>(flags_.span().data() + before, flags_.size() - before), std::uint8_t{1});
    return std::as_const(flags_).span();
  }

 private:
  VertexMask<Backend> flags_;
};

inline void add(const WorstReport& round, WorstReport& sum) {
  sum.inserted += round.inserted;
  sum.removed += round.removed;
  sum.flips += round.flips;
  sum.moved += round.moved;
}

/// Restarts one after the other.
template <class Backend>
class Restarts {
 public:
  Restarts(Optimizer<Backend>& optimizer, const QualityFloor& of_input, QualityFloor& floor)
      : optimizer_(optimizer),
        p_(optimizer.tuning.restart),
        angles_(improve_angles_detail::last_parameters(optimizer.tuning.angles)),
        of_input_(of_input),
        floor_(floor) {
    angles_.min_count = angles_.min_vertex_count = p_.count;
  }

  /// One restart. Returns false if no element is left that it would improve.
  bool restart(WorstReport& r) {
    const Backend& backend = optimizer_.backend;
    WorkingSet<Backend>& work = optimizer_.work;
    const auto before = extremes();
    if (before.max_cost <= angles_.min_cost) return false;
    const double limit =
        std::max((1 - p_.tie) * before.max_cost,
                 upper_cost_quantile(backend, before.values.span(), p_.max_worst, angles_.cost_resolution));
    const auto worst = tets_above(backend, work.mesh, before.values.span(), std::sqrt(1 + limit * limit));
    if (worst.size() == 0) return false;
    // After a failure the mesh is the saved one.
    if (failures_ == 0) saved_.save(backend, work);
    const OperationCounts counts = optimizer_.report;
    r.worst = worst.size();
    const RestartParameters::Perturbation& perturbation = p_.perturbations[std::size_t(failures_)];
    Region<Backend> inner(backend, work.mesh, worst.span(), perturbation.rings);
    Region<Backend> outer(backend, work.mesh, worst.span(), perturbation.rings + p_.angle_rings);
    lower_energy(inner, perturbation, r);
    enlarge_angles(outer, r);
    const double after = extremes().max_cost;
    if (after < (1 - p_.min_fall) * before.max_cost && !backend.stop_requested()) {
      floor_.limit_cost((1 + QualityFloor::kTolerance) * after, angles_.obtuse_weight);
      failures_ = 0;
      ++optimizer_.report.restarts_kept;
    } else {
      saved_.restore(backend, work);
      OperationCounts& of_report = optimizer_.report;
      of_report = counts;
      optimizer_.invalidate_rings();
      optimizer_.sum_energy(kShapeObjective);
      r = {};
      ++failures_;
    }
    ++optimizer_.report.restarts;
    return true;
  }
  int failures() const { return failures_; }

 private:
  AngleExtremes<Backend> extremes() {
    return {optimizer_.backend, optimizer_.work.mesh, optimizer_.slot_energies(), angles_.min_cost,
            angles_.obtuse_weight};
  }

  /// Lowers the energy, and then the mean energy, as before any work on the worst elements.
  void lower_energy(Region<Backend>& region, const RestartParameters::Perturbation& perturbation, WorstReport& r) {
    const Backend& backend = optimizer_.backend;
    WorkingSet<Backend>& work = optimizer_.work;
    const Criterion criterion{kShapeObjective, of_input_, angles_.obtuse_weight};
    const int rounds = perturbation.energy_rounds + (edits_vertices(optimizer_.options) ? perturbation.mean_rounds : 0);
    for (int i = 0; i < rounds && !backend.stop_requested(); ++i) {
      RetriangulationLimits limits = retriangulation_limits(optimizer_, kInfeasible);
      if (i >= perturbation.energy_rounds) {
        limits.mean_energy = optimizer_.energy() / double(work.mesh.tets());
        limits.min_gain = optimizer_.tuning.mean.min_gain;
      }
      const auto flags = region.flags(backend, work.mesh);
      const auto tets = tets_with_flagged_vertex(backend, work.mesh, flags);
      BufferOf<Backend, Index> extreme;
      if (i < perturbation.energy_rounds) extreme = extreme_tets(flags);
      const Span<const Index> proposers = i < perturbation.energy_rounds ? std::as_const(extreme).span() : tets.span();
      WorstReport round;
      round.moved = improve_around(optimizer_, criterion, tets.span(), proposers, limits, round).swept.get().moved;
      add(round, r);
      optimizer_.set_energy(sum_energy(backend, work.flips.energies));
    }
  }

  /// The tetrahedra with a flagged vertex, and with an angle that is worked on.
  BufferOf<Backend, Index> extreme_tets(Span<const std::uint8_t> flags) {
    WorkMesh<Backend>& mesh = optimizer_.work.mesh;
    auto found = extremes();
    clear_outside(optimizer_.backend, mesh, flags, found.values.span());
    return tets_above(optimizer_.backend, mesh, std::as_const(found.values).span(), 0);
  }

  void enlarge_angles(Region<Backend>& region, WorstReport& r) {
    QualityFloor floor = of_input_;
    for (int i = 0, stalls = 0; i < p_.angle_rounds && stalls < angles_.max_stalls; ++i) {
      if (optimizer_.backend.stop_requested()) return;
      const double before = floor.max_cot;
      WorstReport round;
      improve_angles_detail::improve_once(optimizer_, angles_, floor, round,
                                          region.flags(optimizer_.backend, optimizer_.work.mesh));
      add(round, r);
      stalls = floor.max_cot > (1 - angles_.min_fall) * before ? stalls + 1 : 0;
    }
  }

  Optimizer<Backend>& optimizer_;
  const RestartParameters& p_;
  AngleParameters angles_;
  const QualityFloor of_input_;
  QualityFloor& floor_;
  SavedMesh<Backend> saved_;
  int failures_ = 0;
};

}  // namespace restart_worst_detail

/// Improves the worst element where improve_angles() is stuck, by iterated local search (Lourenço, Martin and Stützle,
/// 2003): its neighborhood is optimized again, where angles may be as in the input (`of_input`), and the result is kept
/// if the largest cost of the mesh has fallen; then `floor` is tightened. Reports Report::worst_rounds. Returns false
/// when the caller cancels.
template <class Backend>
bool restart_worst(Optimizer<Backend>& optimizer, const QualityFloor& of_input, QualityFloor& floor) {
  const int restarts = max_restarts(optimizer.options, double(optimizer.work.mesh.tets()));
  if (restarts == 0) return true;
  restart_worst_detail::Restarts<Backend> search(optimizer, of_input, floor);
  optimizer.timer.measure(Phase::restarts, [&] { optimizer.sum_energy(kShapeObjective); });
  const auto perturbations = std::ssize(optimizer.tuning.restart.perturbations);
  for (int i = 1; i <= restarts && search.failures() < perturbations; ++i) {
    WorstReport r;
    bool has_worst = false;
    r.seconds = optimizer.timer.measure(Phase::restarts, [&] { has_worst = search.restart(r); });
    if (!has_worst) break;
    r.round = i;
    r.dihedral_min = optimizer.traced_angle();
    optimizer.report.worst_rounds.push_back(r);
    optimizer.progress.estimate.finish_restart(i, restarts);
    if (!optimizer.proceed(Phase::restarts, optimizer.iteration())) return false;
  }
  return true;
}

}  // namespace tetune

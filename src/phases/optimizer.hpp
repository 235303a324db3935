// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "energy/mesh_energy.hpp"
#include "operators/stars/move_edited_surface.hpp"
#include "phases/progress/phase_timer.hpp"
#include "phases/progress/progress_reporter.hpp"
#include "phases/quality_extremes.hpp"
#include "phases/tuning.hpp"
#include "phases/vertex_sets.hpp"
#include "phases/working_set.hpp"
#include "relocation/move_periodic.hpp"
#include "relocation/sweep.hpp"

namespace tetune {

/// The state that the phases of one optimization share.
template <class Backend>
class Optimizer {
 public:
  Optimizer(const Backend& on, WorkingSet<Backend>& set, const Options& given, const Context& context,
            PhaseTimer& phase_timer)
      : backend(on),
        work(set),
        options(given),
        tuning(tuning_of(given.effort)),
        report(phase_timer.report()),
        timer(phase_timer),
        progress(context, given, phase_timer.start()),
        unit_(given.energy == Energy::harmonic ? 1 / set.scale : 1) {
    work.flips.max_ring = options.flips ? options.max_ring : 0;
  }

  const Backend& backend;
  WorkingSet<Backend>& work;
  const Options& options;
  const Tuning& tuning;
  Report& report;
  PhaseTimer& timer;
  ProgressReporter progress;
  ChangedVertices<Backend> changed;

  Objective objective() const { return options.energy == Energy::shape ? kShapeObjective : kHarmonicObjective; }

  /// The energy of the mesh, up to date after each step.
  double energy() const { return energy_; }
  /// A scaled energy in the caller's unit.
  double in_callers_unit(double energy) const { return unit_ * energy; }
  /// The energy of each slot, as last computed.
  Span<const double> slot_energies() const { return std::as_const(work.flips.energies).span(); }
  /// Computes the energies of all slots. Returns their sum, which becomes the energy of the mesh unless the objective
  /// is a power or a root of the shape energy.
  double sum_energy(const Objective& objective) {
    const double sum = refresh_energy(backend, work.mesh, {objective}, work.flips.energies);
    if (objective.log2_power == 0) set_energy(sum);
    return sum;
  }
  void set_energy(double sum) { energy_ = last_sum_ = sum; }
  /// Subtracts the decrease by one step.
  void decrease_energy(double decrease, const Objective& objective) {
    energy_ -= decrease;
    if (energy_ < tuning.resum_fraction * last_sum_) timer.measure(Phase::sums, [&] { sum_energy(objective); });
  }

  /// Adds the flips of one pass to the report.
  void record_flips(const FlipCounts& flips) {
    FlipCounts& total = report;
    total += flips;
    rings_stale_ = rings_stale_ || flips.flips() > 0;
  }

  /// Call this after degrees of freedom have changed or the mesh was uploaded.
  void invalidate_rings() { rings_stale_ = true; }
  /// Call this before flips: rings and active tetrahedra take turns in the memory of a pool.
  void release_rings() {
    if constexpr (Backend::Memory::kIsPool) work.rings = {};
  }
  /// Builds the rings of all vertices, and colors them, if they are out of date. Returns false if a requested stop
  /// prevented it. Call an activation before flips that follow.
  bool refresh_rings() {
    if (!rings_stale_ && work.rings.offsets.size() > 0) return true;
    if constexpr (Backend::Memory::kIsPool) work.flips.release_active();
    timer.measure(Phase::rings, [&] { build_rings(backend, work.mesh, work.rings); });
    if (backend.stop_requested()) return false;
    if (!rings_stale_) return true;
    rings_stale_ = false;
    timer.measure(Phase::coloring, [&] { color(); });
    report.colors = work.coloring.colors();
    return true;
  }
  /// Builds the rings of the active vertices, all of whose tetrahedra are `tets`. The other vertices have no ring until
  /// the next refresh_rings().
  void refresh_rings_of_active(Span<const Index> tets) {
    rings_stale_ = true;
    build_rings_of(backend, work.mesh, tets, std::as_const(work.dofs.active).span(), work.rings);
    color();
  }

  /// A sweep over vertices and periodic classes. The result is pending.
  struct Swept {
    ResultOf<Backend, SweepSum> vertices, classes;
    SweepSum get() const {
      SweepSum sum = vertices.get();
      sum.merge(classes.get());
      return sum;
    }
  };
  Swept sweep_once(const Criterion& criterion, SweepScope scope) {
    const RelocationParameters& p = tuning.relocation;
    // Vertices of a bounded surface that have drifted far can move on afterwards.
    if (work.dofs.checked.edited_points.size() > 0) {
      move_edited_surface(backend, work.mesh, work.dofs, work.boundary, work.coloring);
    }
    const auto sweep_with = [&](const auto& step) {
      Swept swept;
      swept.vertices = sweep<SweepRing<Backend>>(backend, work.mesh, criterion, work.movable_vertices(), step, scope);
      if (work.periodic.classes() > 0) {
        swept.classes = sweep_periodic(backend, work.mesh, criterion, work.movable_classes(), step, scope);
      }
      return swept;
    };
    return options.relocation == Relocation::newton ? sweep_with(NewtonStep{p.relaxation, p.min_gain})
                                                    : sweep_with(GradientStep{p.min_gradient});
  }

  /// The smallest dihedral angle in degrees with Options::trace_angles, else 0.
  double traced_angle() {
    if (!options.trace_angles) return 0;
    double cot = 0;
    timer.measure(Phase::trace, [&] { cot = find_max_cot(backend, work.mesh); });
    return ProgressReporter::degrees(cot);
  }

  /// The number of the last sweep; 0 before the first.
  int iteration() const { return report.sweeps.empty() ? 0 : report.sweeps.back().iteration; }

  /// Reports progress. Returns false, and sets Report::stop, when the caller cancels.
  bool proceed(Phase phase, int iteration) {
    const auto find_cot = [this] { return find_max_cot(backend, work.mesh); };
    if (progress.proceed(phase, iteration, unit_ * energy_, report.energy_before, find_cot)) return true;
    report.stop = StopReason::cancelled;
    return false;
  }

 private:
  void color() {
    color_vertices(backend, work.rings.view(), work.dofs.dof.span(), work.coloring, work.dofs.stars());
    refresh_periodic(backend, work.rings.view(), work.periodic);
  }

  double unit_;  ///< the caller's unit of energy relative to that of the scaled mesh
  double energy_ = 0;
  double last_sum_ = 0;
  bool rings_stale_ = true;
};

}  // namespace tetune

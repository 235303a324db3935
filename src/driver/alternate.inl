// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "driver/alternate.hpp"
#include "driver/clock.hpp"
#include "driver/schedule.hpp"
#include "driver/targets.hpp"
#include "driver/working_set.inl"
#include "driver/worst.inl"
#include "vertices/open_angles.hpp"
#include "vertices/revise.hpp"

namespace tetune {
namespace alternate_detail {

/// Over-relaxation of the Newton step: docs/benchmarks/cpu.md, "Relaxation".
inline constexpr double kRelaxation = 1.6;
/// Newton steps that promise to take away less than this part of the ring's energy are not taken.
inline constexpr double kMinGain = 1e-10;
/// The paper's eps_g.
inline constexpr double kMinGradient = 1e-5;
/// Below this part of its last sum, the energy is summed up anew.
inline constexpr double kStale = 0.1;
/// The worst tetrahedra are this part of all, and those only that are worse than good.
inline constexpr double kWorstPart = 1e-4;
inline constexpr double kGood = 2;
/// Flips of boundary edges end when a pass takes away less than this part of the energy.
inline constexpr double kLittleOnBoundary = 1e-4;
/// The work on them is done under the shape energy squared so many times.
inline constexpr int kWorstSquarings = 2;
inline constexpr int kWorstRounds = 10;
/// It ends when a round takes away less than this part of that.
inline constexpr double kWorstDecrease = 1e-2;
/// The tetrahedra with the smallest angles are this part of all, and those only that are below about 40 degrees.
inline constexpr double kSharpPart = 6e-4;
inline constexpr double kOpenCot = 1.2;
inline constexpr int kAngleRounds = 6;
inline constexpr int kOpenings = 2;
/// Sweeps at the end; the first half of them with flips.
inline constexpr int kLastSweeps = 4;
/// Vertices are inserted until there are this many times the tetrahedra of the input.
inline constexpr double kMostTets = 1.1;
/// Far above what any mesh needs: each pass lowers the energy, so this bounds a run in which rounding says otherwise.
inline constexpr int kMaxFlipPasses = 1000;

/// The alternation of Sect. 4.5 on one backend.
template <class Backend>
class Alternation {
 public:
  Alternation(const Backend& par, WorkingSet<Backend>& work, const Options& options, const Context& context,
              Report& report)
      : par_(par),
        work_(work),
        options_(options),
        context_(context),
        report_(report),
        clock_(report),
        unit_(options.energy == Energy::harmonic ? 1 / work.scale : 1),
        flips_boundary_(work.boundary.triangles.size() > 0) {}

  void run() {
    const bool whole = options_.effort != Effort::fast && options_.termination == Termination::relative &&
                       options_.energy == Energy::shape && options_.max_iterations > 0;
    if (!alternate() || !whole || !improve_worst()) return;
    if (options_.effort == Effort::best && open_smallest_angles()) lower_energy_above_floor();
  }

  /// After the last step, in the caller's unit.
  double energy() { return unit_ * refresh_energy(par_, work_.mesh, work_.flips); }

 private:
  /// Flips and sweeps in turn, until the energy falls no more. False when the caller cancelled.
  bool alternate() {
    work_.flips.max_ring = options_.max_ring;
    if (options_.energy == Energy::shape) {
      clock_.measure("load", [&] { work_.mesh.floor = find_floor(par_, work_.mesh); });
    }
    sum_up();
    report_.energy_before = unit_ * energy_;
    activate_all(par_, work_.mesh, work_.flips);
    if (flip_until_stable(0) < 0) return false;
    Schedule schedule(options_);
    report_.stop = StopReason::iteration_limit;
    for (int iteration = 1; iteration <= options_.max_iterations; ++iteration) {
      const double energy_before_round = energy_;
      const SweepReport& swept = relocate(iteration);
      if (!proceed("sweep", iteration)) return false;
      if (schedule.flips_due(iteration)) {
        clock_.measure("flips", [&] { energy_ = last_sum_ = activate_drifted(par_, work_.mesh, work_.flips); });
        const double energy_before_flips = energy_;
        const Size flips = flip_until_stable(iteration);
        if (flips < 0) return false;
        schedule.flips_found(iteration, flips, 1 - energy_ / energy_before_flips);
      }
      if (schedule.stop(swept, energy_before_round, energy_, report_.stop)) break;
    }
    return true;
  }

  /// Works on the worst tetrahedra and around them alone, under a power of the energy that sees little else. False when
  /// the caller cancelled.
  bool improve_worst() {
    clock_.measure("worst", [&] { sum_up(); });
    const double worst = std::max(kGood, quantile_above(par_, work_.flips.eta.span(), kWorstPart, work_.mesh.tets()));
    work_.mesh.law = shape_law(kWorstSquarings);
    work_.mobilities.local = true;
    double last = refresh_energy(par_, work_.mesh, work_.flips);
    const Span<std::uint8_t> awake = work_.mobilities.awake.span();
    bool go_on = true;
    for (int round = 1; round <= kWorstRounds; ++round) {
      WorstReport r;
      r.round = round;
      double now = last;
      r.seconds = clock_.measure("worst", [&] {
        r.worst = flag_worst(par_, work_.mesh, worst, awake);
        r.flips = flip_around(awake);
      });
      if (r.worst == 0) break;
      refresh_rings();
      r.seconds += clock_.measure("worst", [&] {
        flag_neighbours(par_, work_.mesh, awake);
        r.moved = sweep_once().moved;
        now = refresh_energy(par_, work_.mesh, work_.flips);
      });
      report_.worst_rounds.push_back(r);
      go_on = proceed("worst", iteration());
      if (!go_on || now > (1 - kWorstDecrease) * last) break;
      last = now;
    }
    work_.mesh.law = kShapeLaw;
    return go_on;
  }

  /// Opens the smallest dihedral angles: vertices are inserted, removed and moved, and flips made around them. False
  /// when the caller cancelled.
  bool open_smallest_angles() {
    const auto most_tets = static_cast<Size>(kMostTets * static_cast<double>(report_.tets_before));
    const double worst_shape = work_.mesh.floor.worst_shape;
    for (int round = 1; round <= kAngleRounds; ++round) {
      WorstReport r;
      r.round = round;
      double cot = 0;
      r.seconds = clock_.measure("angles", [&] {
        // No angle falls below the smallest any more; shapes may become worse on the way.
        work_.mesh.floor = find_floor(par_, work_.mesh);
        work_.mesh.floor.worst_shape = worst_shape;
        work_.mesh.floor.settle();
        cot = std::max(kOpenCot, sharp_cot(par_, work_.mesh, kSharpPart));
        par_.fill(work_.mobilities.awake.span(), std::uint8_t{0});
        if (!options_.keep_vertices) revise(cot, most_tets, r);
        r.worst = flag_sharp(par_, work_.mesh, cot, work_.mobilities.awake.span());
        refresh_energy(par_, work_.mesh, work_.flips);
        r.flips = flip_around(work_.mobilities.awake.span());
      });
      refresh_rings();
      r.seconds += clock_.measure("angles", [&] {
        sweep_once();
        const Span<std::uint8_t> sharp = work_.mobilities.awake.span();
        par_.fill(sharp, std::uint8_t{0});
        flag_sharp(par_, work_.mesh, cot, sharp);
        for (int turn = 0; turn < kOpenings; ++turn) {
          r.moved += open_angles(par_, work_.mesh, work_.rings.view(), work_.coloring, work_.mobilities,
                                 Span<const std::uint8_t>(sharp), cot);
        }
        sum_up();
      });
      report_.worst_rounds.push_back(r);
      if (!proceed("angles", iteration())) return false;
      if (r.worst == 0 || r.inserted + r.removed + r.flips + r.moved == 0) break;
    }
    return true;
  }

  void revise(double cot, Size most_tets, WorstReport& r) {
    const ReviseReport changed = revise_vertices(par_, work_.mesh, work_.flips, work_.mobilities, cot, most_tets);
    r.inserted = changed.inserted;
    r.removed = changed.removed;
    report_.vertices_inserted += r.inserted;
    report_.vertices_removed += r.removed;
    rings_stale_ = rings_stale_ || r.inserted + r.removed > 0;
  }

  /// What was done for the few worst has raised the energy; lowers it again, and lets no tetrahedron become worse than
  /// the worst now.
  void lower_energy_above_floor() {
    clock_.measure("angles", [&] {
      work_.mesh.floor = find_floor(par_, work_.mesh);
      work_.mobilities.local = false;
      par_.fill(work_.mobilities.awake.span(), std::uint8_t{1});
    });
    for (int sweep = 1; sweep <= kLastSweeps; ++sweep) {
      refresh_rings();
      clock_.measure("angles", [&] {
        sweep_once();
        if (sweep > kLastSweeps / 2) return;
        if (sweep == 1) {
          sum_up();
          activate_all(par_, work_.mesh, work_.flips);
        } else {
          activate_drifted(par_, work_.mesh, work_.flips);
        }
        flip_active(work_.mobilities.awake.span());
      });
      if (!proceed("angles", iteration())) return;
    }
  }

  /// Flips from the tetrahedra on that have an edge between flagged vertices; flags those whose ring changes. Returns
  /// their number.
  Size flip_around(Span<std::uint8_t> flags) {
    activate_around(par_, work_.mesh, work_.flips, Span<const std::uint8_t>(flags));
    Size all = 0;
    if (work_.boundary.triangles.size() > 0) {
      const FlipReport f = boundary_flip_pass(par_, work_.mesh, work_.flips, work_.boundary, flags);
      count(f);
      all = f.flips();
    }
    return all + flip_active(flags);
  }
  Size flip_active(Span<std::uint8_t> flags) {
    Size all = 0;
    for (Size flips = 1; flips > 0 && work_.flips.active.size() > 0; all += flips) {
      const FlipReport f = flip_pass(par_, work_.mesh, work_.flips, flags);
      count(f);
      flips = f.flips();
    }
    return all;
  }

  int iteration() const { return report_.sweeps.empty() ? 0 : report_.sweeps.back().iteration; }

  /// Rings and colours, where flips have changed the mesh since they were made.
  void refresh_rings() {
    if (!rings_stale_) return;
    rings_stale_ = false;
    clock_.measure("rings", [&] { build_rings(par_, work_.mesh, work_.rings); });
    clock_.measure("colouring",
                   [&] { color_vertices(par_, work_.rings.view(), work_.mobilities.kind.span(), work_.coloring); });
    report_.colors = work_.coloring.colors();
  }

  const SweepReport& relocate(int iteration) {
    SweepReport r;
    r.iteration = iteration;
    r.energy_before = unit_ * energy_;
    if (options_.termination == Termination::paper) par_.fill(work_.mobilities.awake.span(), std::uint8_t{1});
    refresh_rings();
    SweepSum sum;
    r.seconds = clock_.measure("sweeps", [&] { sum = sweep_once(); });
    energy_ -= sum.decrease;
    settle();
    r.decrease = unit_ * sum.decrease;
    r.gradient_norm = sum.gradient2;
    r.moved = sum.moved;
    report_.sweeps.push_back(r);
    return report_.sweeps.back();
  }

  SweepSum sweep_once() {
    const RingsView rings = work_.rings.view();
    return options_.relocation == Relocation::newton
               ? sweep(par_, work_.mesh, rings, work_.coloring, work_.mobilities, NewtonStep{kRelaxation, kMinGain})
               : sweep(par_, work_.mesh, rings, work_.coloring, work_.mobilities, GradientStep{kMinGradient});
  }

  /// Flips from the active set on; returns their number, or -1 when the caller cancelled.
  Size flip_until_stable(int iteration) {
    Size flips = 0;
    bool on_boundary = flips_boundary_ && iteration > 0;  // slivers must have gone before
    for (int pass = 1; pass <= kMaxFlipPasses && (on_boundary || work_.flips.active.size() > 0); ++pass) {
      FlipReport r;
      const double seconds = clock_.measure(on_boundary ? "boundary flips" : "flips", [&] {
        const Span<std::uint8_t> awake = work_.mobilities.awake.span();
        r = on_boundary ? boundary_flip_pass(par_, work_.mesh, work_.flips, work_.boundary, awake)
                        : flip_pass(par_, work_.mesh, work_.flips, awake);
      });
      energy_ -= r.decrease;
      settle();
      r.iteration = iteration;
      r.pass = pass;
      r.seconds = seconds;
      r.decrease *= unit_;
      count(r);
      report_.flip_passes.push_back(r);
      flips += r.flips();
      if (!proceed("flips", iteration)) return -1;
      if (r.flips() == 0 && !on_boundary) break;
      if (on_boundary && r.decrease < kLittleOnBoundary * unit_ * energy_) flips_boundary_ = false;
      on_boundary = false;
    }
    return flips;
  }

  void count(const FlipReport& r) {
    report_.flips23 += r.flips23;
    report_.flips32 += r.flips32;
    report_.edge_removals += r.edge_removals;
    report_.boundary_flips += r.boundary_flips;
    rings_stale_ = rings_stale_ || r.flips() > 0;
  }

  void sum_up() { energy_ = last_sum_ = refresh_energy(par_, work_.mesh, work_.flips); }
  /// Sums the energy up anew where what is left is small next to what was taken away: rounding hides it.
  void settle() {
    if (energy_ < kStale * last_sum_) clock_.measure("sums", [&] { sum_up(); });
  }

  bool proceed(const char* phase, int iteration) {
    if (!context_.progress) return true;
    if (context_.progress({phase, iteration, unit_ * energy_, report_.energy_before})) return true;
    report_.stop = StopReason::cancelled;
    return false;
  }

  const Backend& par_;
  WorkingSet<Backend>& work_;
  const Options& options_;
  const Context& context_;
  Report& report_;
  Clock clock_;
  double unit_;  ///< of the energy inside, in the caller's
  double energy_ = 0;
  double last_sum_ = 0;
  bool rings_stale_ = true;
  bool flips_boundary_;  ///< while it is worth it
};

}  // namespace alternate_detail

template <class Backend>
Report optimize_on(const Backend& par, TetMesh& mesh, const Options& options, const Context& context) {
  Report report;
  Clock clock(report);
  report.vertices = static_cast<std::int64_t>(mesh.points.size());
  report.tets_before = static_cast<std::int64_t>(mesh.tets.size());
  WorkingSet<Backend> work;
  clock.measure("load", [&] { load(par, mesh, options, work, report); });
  alternate_detail::Alternation<Backend> alternation(par, work, options, context, report);
  alternation.run();
  report.energy_after = alternation.energy();
  if (!options.targets.empty()) {
    clock.measure("targets", [&] {
      using namespace working_set_detail;
      work.frozen.resize(static_cast<std::size_t>(work.mesh.vertices()), kMovable);
      const VertexIds ids = vertex_ids(work.mesh.vertex2original.download(), mesh.points.size());
      const Outcome outcome{work.mesh.points.download(),
                            work.mesh.tet2vertex.download(),
                            work.mesh.tet2tet.download(),
                            work.mesh.tet_tags.download(),
                            ids.work2new(),
                            work.mobilities.kind.download(),
                            work.frozen,
                            work.required_slots,
                            work.scale};
      report.targets = report_targets(outcome, options);
    });
  }
  clock.measure("store", [&] { store(par, work, mesh, report); });
  report.tets_after = static_cast<std::int64_t>(mesh.tets.size());
  return report;
}

}  // namespace tetune

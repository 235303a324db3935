// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "driver/alternate.hpp"
#include "driver/clock.hpp"
#include "driver/monitor.hpp"
#include "driver/schedule.hpp"
#include "driver/targets.hpp"
#include "driver/untangle.inl"
#include "driver/working_set.inl"
#include "driver/worst.inl"
#include "flips/face_removals.hpp"
#include "vertices/open_angles.hpp"
#include "vertices/revise.hpp"

namespace tetune {
namespace alternate_detail {

/// Over-relaxation of the Newton step: docs/benchmarks/cpu.md, "Relaxation".
inline constexpr double kRelaxation = 1.7;
/// Newton steps that promise to take away less than this part of the ring's energy are not taken.
inline constexpr double kMinGain = 1e-10;
/// The paper's eps_g.
inline constexpr double kMinGradient = 1e-5;
/// Below this part of its last sum, the energy is summed up anew.
inline constexpr double kStale = 0.1;
/// Before the first sweep, tetrahedra look for flips that are worse than this: sweeps move all others first, and end
/// lower than flips before them (docs/benchmarks/cpu.md, "The first flips").
inline constexpr double kFirstLook = 8;
/// And after it, with Effort::fast.
inline constexpr double kFastLook = 1.5;
/// Flips end when a pass takes away less than this part of the energy, those of boundary edges and removals of faces
/// for good.
inline constexpr double kLittle = 5e-4;
inline constexpr double kBestLittle = 1e-4;
/// The worst tetrahedra are this part of all, and those only that are worse than good.
inline constexpr double kWorstPart = 3e-4;
inline constexpr double kGood = 2;
/// The work on them is done under the shape energy squared so many times.
inline constexpr int kWorstSquarings = 2;
inline constexpr int kWorstRounds = 10;
/// It ends when a round takes away less than this part of that.
inline constexpr double kWorstDecrease = 1e-2;
/// Or when the tetrahedra worked on, summed over the rounds, are more than so many and this part of all: where many are
/// equally bad, as in an even layer.
inline constexpr Size kWorstWork = 300;
inline constexpr double kWorstWorkPart = 1e-2;
/// The tetrahedra with the smallest angles are this part of all, and those only that are below about 40 degrees.
inline constexpr double kSharpPart = 3e-4;
inline constexpr double kBestSharpPart = 4e-3;
inline constexpr double kVertexPart = 6e-4;
inline constexpr double kOpenCot = 1.2;
inline constexpr int kAngleRounds = 1;
inline constexpr int kBestAngleRounds = 6;
inline constexpr int kOpenings = 2;
/// Sweeps at the end; the first half of them with flips.
inline constexpr int kLastSweeps = 4;
/// Vertices are inserted until there are this many times the tetrahedra of the input.
inline constexpr double kMostTets = 1.1;

/// The alternation of Sect. 4.5 on one backend.
template <class Backend>
class Alternation {
 public:
  Alternation(const Backend& par, WorkingSet<Backend>& work, const Options& options, const Context& context,
              Report& report, Monitor::Time::time_point start)
      : par_(par),
        work_(work),
        options_(options),
        report_(report),
        clock_(report),
        monitor_(context, options, works_on_worst(), start),
        unit_(options.energy == Energy::harmonic ? 1 / work.scale : 1),
        flips_boundary_(work.boundary.triangles.size() > 0) {}

  void run() {
    work_.flips.max_ring = options_.flips ? options_.max_ring : 0;
    if (work_.tangled > 0) untangle_all();
    if (!alternate() || !works_on_worst() || !improve_worst() || !open_smallest_angles()) return;
    if (options_.effort == Effort::best) lower_energy_above_floor();
  }

  /// After the last step, in the caller's unit.
  double energy() { return unit_ * refresh_energy(par_, work_.mesh, work_.flips); }

 private:
  using Ids = typename Backend::template Buffer<Index>;

  /// Whether passes go on until no tetrahedron has a flip that lowers the energy. Otherwise a few may be left that lie
  /// near others, but not beside them.
  bool to_the_last_flip() const { return options_.termination == Termination::paper || options_.max_iterations == 0; }
  bool works_on_worst() const {
    return options_.effort != Effort::fast && options_.termination == Termination::relative &&
           options_.energy == Energy::shape && options_.max_iterations > 0;
  }

  /// Makes all volumes positive, or throws.
  void untangle_all() {
    std::vector<Index> left;
    clock_.measure("untangling", [&] { left = untangle(par_, work_, [this] { return proceed("untangling", 0); }); });
    report_.tets_untangled = work_.tangled;
    if (left.empty()) return;
    const std::vector<Index> tet2original = work_.mesh.tet2original.download();
    for (Index& t : left) t = tet2original[static_cast<std::size_t>(t)];
    std::sort(left.begin(), left.end());
    left.erase(std::unique(left.begin(), left.end()), left.end());
    using Reason = UntangleError::Reason;
    throw UntangleError(work_.tangled, std::move(left),
                        par_.stop_requested()                  ? Reason::stopped
                        : options_.boundary == Boundary::slide ? Reason::no_room_though_sliding
                                                               : Reason::no_room);
  }

  /// Flips and sweeps in turn, until the energy falls no more. False when the caller cancelled.
  bool alternate() {
    const bool floor = options_.energy == Energy::shape;
    const double seconds = clock_.measure("load", [&] {
      sum_up();
      if (floor) work_.mesh.floor = find_floor(par_, work_.mesh, shapes());
    });
    if (floor) monitor_.set_worst(work_.mesh.floor.most_cot, seconds);
    report_.energy_before = unit_ * energy_;
    if (!proceed("load", 0)) return false;
    const bool sweeps = options_.termination == Termination::relative && options_.max_iterations > 0;
    activate_all(par_, work_.mesh, work_.flips, sweeps && options_.energy == Energy::shape ? kFirstLook : 0);
    if (flip_until_stable(0) < 0) return false;
    Schedule schedule(options_);
    report_.stop = StopReason::iteration_limit;
    double last_energy = energy_;
    for (int iteration = 1; iteration <= options_.max_iterations; ++iteration) {
      const double energy_before_round = energy_;
      const SweepReport& swept = relocate(iteration);
      monitor_.course.sweep(iteration, 1 - energy_ / last_energy);
      last_energy = energy_;
      if (!proceed("sweep", iteration)) return false;
      if (options_.flips && schedule.flips_due(iteration)) {
        clock_.measure("flips",
                       [&] { energy_ = last_sum_ = activate_drifted(par_, work_.mesh, work_.flips, look_above()); });
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
    double bound = 0;
    double last = 0;
    Size left = kWorstWork + static_cast<Size>(kWorstWorkPart * static_cast<double>(work_.mesh.tets()));
    clock_.measure("worst", [&] {
      sum_up();
      bound = std::pow(std::max(kGood, quantile_above(par_, shapes(), kWorstPart, work_.mesh.tets())),
                       1 << kWorstSquarings);
      work_.mesh.law = shape_law(kWorstSquarings);
      work_.mobilities.local = true;
      last = refresh_energy(par_, work_.mesh, work_.flips);
    });
    bool go_on = true;
    for (int round = 1; round <= kWorstRounds; ++round) {
      WorstReport r;
      r.round = round;
      double now = last;
      r.seconds = clock_.measure("worst", [&] {
        const auto worst = tets_above(par_, work_.mesh, shapes(), bound);
        r.worst = worst.size();
        if (r.worst == 0) return;
        work_around(worst.span(), kNever, r);
        now = sum_energy(par_, work_.flips);
      });
      if (r.worst == 0) break;
      r.dihedral_min = traced_angle();
      report_.worst_rounds.push_back(r);
      monitor_.course.worst(round);
      go_on = proceed("worst", iteration());
      left -= r.worst;
      if (!go_on || now > (1 - kWorstDecrease) * last || (left < 0 && options_.effort != Effort::best)) break;
      last = now;
    }
    work_.mesh.law = kShapeLaw;
    return go_on;
  }

  /// Opens the smallest dihedral angles: vertices are moved, edges removed, with Effort::best vertices inserted and
  /// removed, and flips made around them. False when the caller cancelled.
  bool open_smallest_angles() {
    const bool best = options_.effort == Effort::best;
    clock_.measure("angles", [&] { sum_up(); });
    for (int round = 1; round <= (best ? kBestAngleRounds : kAngleRounds); ++round) {
      WorstReport r;
      r.round = round;
      Size opened = 0;
      r.seconds = clock_.measure("angles", [&] {
        const Sharpness<Backend> sharpness(par_, work_.mesh, shapes(), kOpenCot);
        const auto cot_of = [&](double part) {
          return std::max(kOpenCot, sharp_cot(par_, sharpness.values.span(), part, work_.mesh.tets()));
        };
        const double cot = cot_of(best ? kBestSharpPart : kSharpPart);
        const Ids sharp = tets_above(par_, work_.mesh, sharpness.values.span(), std::sqrt(1 + cot * cot));
        r.worst = sharp.size();
        // No angle falls below the smallest any more; shapes may become worse on the way.
        QualityFloor& floor = work_.mesh.floor;
        floor.limit_cot((1 + QualityFloor::kRounding) * sharpness.most_cot);
        const bool keep = !best || options_.keep_vertices;
        const Ids changed = work_around(sharp.span(), keep ? kNever : cot_of(kVertexPart), r);
        const Span<std::uint8_t> flags = work_.mobilities.awake.span();
        par_.fill(flags, std::uint8_t{0});
        flag_sharp(par_, work_.mesh, changed.span(), cot, flags);
        for (int turn = 0; turn < kOpenings; ++turn) {
          opened += open_angles(par_, work_.mesh, work_.rings.view(), work_.coloring, work_.mobilities,
                                Span<const std::uint8_t>(flags), cot);
        }
        refresh_energy_of(par_, work_.mesh, work_.flips, changed.span());
        energy_ = last_sum_ = sum_energy(par_, work_.flips);
      });
      r.moved += opened;
      r.dihedral_min = traced_angle();
      report_.worst_rounds.push_back(r);
      monitor_.course.angles(round, best ? kBestAngleRounds + kLastSweeps : kAngleRounds);
      if (!proceed("angles", iteration())) return false;
      if (r.inserted + r.removed + r.flips + opened == 0) break;
    }
    return true;
  }

  /// Revises vertices around some tetrahedra, flips, and moves the vertices there and their neighbours; the energies
  /// are up to date before and afterwards. Returns the tetrahedra with a vertex that may have moved; those vertices
  /// alone have rings.
  Ids work_around(Span<const Index> tets, double vertex_cot, WorstReport& r) {
    par_.fill(work_.mobilities.awake.span(), std::uint8_t{0});
    flag_corners(par_, work_.mesh, tets, work_.mobilities.awake.span());
    if (!par_.stop_requested()) revise(tets, vertex_cot, r);
    const Span<std::uint8_t> flags = work_.mobilities.awake.span();
    r.flips += flip_around(flags);
    flag_neighbours(par_, work_.mesh, flags);
    Ids near = flagged_tets(par_, work_.mesh, flags);
    refresh_rings_of(near.span(), flags);
    r.moved = sweep_once().moved;
    refresh_energy_of(par_, work_.mesh, work_.flips, near.span());
    return near;
  }

  /// Counts the edges that go as flips.
  void revise(Span<const Index> around, double vertex_cot, WorstReport& r) {
    const auto most_tets = static_cast<Size>(kMostTets * static_cast<double>(report_.tets_before));
    const ReviseReport changed =
        revise_vertices(par_, work_.mesh, work_.flips, work_.mobilities, around, most_tets, vertex_cot);
    r.inserted = changed.inserted;
    r.removed = changed.removed;
    r.flips = changed.edges;
    report_.vertices_inserted += r.inserted;
    report_.vertices_removed += r.removed;
    report_.compound_flips += changed.edges;
    rings_stale_ = rings_stale_ || changed.inserted + changed.removed + changed.edges > 0;
  }

  /// What was done for the few worst has raised the energy; lowers it again, and lets no tetrahedron become worse than
  /// the worst now.
  void lower_energy_above_floor() {
    clock_.measure("angles", [&] {
      const double most_cot = work_.mesh.floor.most_cot;
      sum_up();
      work_.mesh.floor = find_floor(par_, work_.mesh, shapes());
      work_.mesh.floor.limit_cot(most_cot);
      work_.mobilities.local = false;
      par_.fill(work_.mobilities.awake.span(), std::uint8_t{1});
    });
    for (int sweep = 1; sweep <= kLastSweeps; ++sweep) {
      const bool ready = refresh_rings();
      clock_.measure("angles", [&] {
        if (!ready) return;
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
      monitor_.course.angles(kBestAngleRounds + sweep, kBestAngleRounds + kLastSweeps);
      if (!proceed("angles", iteration())) return;
    }
  }

  /// Flips from the tetrahedra on that have an edge between flagged vertices; flags those whose ring changes. Returns
  /// their number.
  Size flip_around(Span<std::uint8_t> flags) {
    if (!options_.flips) return 0;
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
    if (!options_.flips) return 0;
    const FlipReport faces = face_removal_pass(par_, work_.mesh, work_.flips, flags);
    count(faces);
    const FlipReport others = flip_until_none(par_, work_.mesh, work_.flips, flags);
    count(others);
    return faces.flips() + others.flips();
  }

  /// Tetrahedra look for flips after a sweep that are worse than this.
  double look_above() const {
    return options_.effort == Effort::fast && options_.energy == Energy::shape && !to_the_last_flip() ? kFastLook : 0;
  }
  /// With to_the_last_flip() all vertices are awake for a sweep, whatever the flags say: they tell where flips were
  /// made.
  void forget_flips() {
    if (to_the_last_flip()) par_.fill(work_.mobilities.awake.span(), std::uint8_t{0});
  }
  /// With to_the_last_flip(), all that may own a candidate with a tetrahedron made by those flips look again. False
  /// where there is none.
  bool look_around_flips(bool& flipped) {
    if (!flipped || !to_the_last_flip()) return false;
    clock_.measure("flips", [&] {
      activate_around(par_, work_.mesh, work_.flips, Span<const std::uint8_t>(work_.mobilities.awake.span()));
    });
    forget_flips();
    flipped = false;
    return work_.flips.active.size() > 0;
  }

  int iteration() const { return report_.sweeps.empty() ? 0 : report_.sweeps.back().iteration; }

  /// Rings and colours, where flips have changed the mesh since they were made. False where a stop left them undone.
  bool refresh_rings() {
    if (!rings_stale_) return true;
    clock_.measure("rings", [&] { build_rings(par_, work_.mesh, work_.rings); });
    if (par_.stop_requested()) return false;
    rings_stale_ = false;
    clock_.measure("colouring", [&] { color(); });
    report_.colors = work_.coloring.colors();
    return true;
  }

  /// The same of the flagged vertices alone, all of whose tetrahedra are given; others have no ring until the next
  /// refresh_rings().
  void refresh_rings_of(Span<const Index> near, Span<const std::uint8_t> flags) {
    rings_stale_ = true;
    build_rings_of(par_, work_.mesh, near, flags, work_.rings);
    color();
  }
  void color() {
    const Mobilities<Backend>& m = work_.mobilities;
    color_vertices(par_, work_.rings.view(), m.kind.span(), work_.coloring, m.stars());
  }

  const SweepReport& relocate(int iteration) {
    SweepReport r;
    r.iteration = iteration;
    r.energy_before = unit_ * energy_;
    if (options_.termination == Termination::paper) par_.fill(work_.mobilities.awake.span(), std::uint8_t{1});
    SweepSum sum;
    if (refresh_rings()) r.seconds = clock_.measure("sweeps", [&] { sum = sweep_once(); });
    energy_ -= sum.decrease;
    settle();
    r.decrease = unit_ * sum.decrease;
    r.gradient_norm = sum.gradient2;
    r.moved = sum.moved;
    r.dihedral_min = traced_angle();
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
    if (!options_.flips) return 0;
    Size flips = 0;
    // Slivers must have gone before.
    bool on_boundary = flips_boundary_ && iteration > 0;
    bool at_faces = removes_faces_ && iteration > 0;
    bool flipped = false;  // since all around flips looked
    if (!on_boundary) forget_flips();
    for (int pass = 1; pass <= kMaxFlipPasses; ++pass) {
      if (!on_boundary && work_.flips.active.size() == 0 && !look_around_flips(flipped)) break;
      FlipReport r;
      const double seconds = clock_.measure(on_boundary ? "boundary flips" : "flips", [&] {
        const Span<std::uint8_t> awake = work_.mobilities.awake.span();
        r = on_boundary ? boundary_flip_pass(par_, work_.mesh, work_.flips, work_.boundary, awake)
            : at_faces  ? face_removal_pass(par_, work_.mesh, work_.flips, awake)
                        : flip_pass(par_, work_.mesh, work_.flips, awake);
      });
      energy_ -= r.decrease;
      settle();
      const bool little = r.decrease < (options_.effort == Effort::best ? kBestLittle : kLittle) * energy_;
      r.iteration = iteration;
      r.pass = pass;
      r.seconds = seconds;
      r.decrease *= unit_;
      count(r);
      report_.flip_passes.push_back(r);
      flips += r.flips();
      flipped = flipped || r.flips() > 0;
      if (iteration == 0) monitor_.course.first_flips(pass);
      if (!proceed("flips", iteration)) return -1;
      if (on_boundary) {
        flips_boundary_ = !little;
        on_boundary = false;
        // All were flagged for this pass. Where it has made flips, all look once more at the end.
        if (!flipped) forget_flips();
      } else if (at_faces) {
        removes_faces_ = !little;
        at_faces = false;
      } else if (to_the_last_flip() ? r.flips() == 0 && !look_around_flips(flipped) : little) {
        break;
      }
    }
    return flips;
  }

  void count(const FlipReport& r) {
    report_.flips23 += r.flips23;
    report_.flips32 += r.flips32;
    report_.edge_removals += r.edge_removals;
    report_.face_removals += r.face_removals;
    report_.boundary_flips += r.boundary_flips;
    rings_stale_ = rings_stale_ || r.flips() > 0;
  }

  /// Smallest dihedral angle in degrees, where it is asked for.
  double traced_angle() {
    if (!options_.trace_angles) return 0;
    double cot = 0;
    clock_.measure("trace", [&] { cot = find_most_cot(par_, work_.mesh); });
    return Monitor::degrees(cot);
  }

  /// Of all slots, when they are up to date; or under another law its energies.
  Span<const double> shapes() const { return work_.flips.energies.span(); }
  void sum_up() { energy_ = last_sum_ = refresh_energy(par_, work_.mesh, work_.flips); }
  /// Sums the energy up anew where what is left is small next to what was taken away: rounding hides it.
  void settle() {
    if (energy_ < kStale * last_sum_) clock_.measure("sums", [&] { sum_up(); });
  }

  bool proceed(const char* phase, int iteration) {
    const auto find_cot = [this] { return find_most_cot(par_, work_.mesh); };
    if (monitor_.proceed(phase, iteration, unit_ * energy_, report_.energy_before, find_cot)) return true;
    report_.stop = StopReason::cancelled;
    return false;
  }

  const Backend& par_;
  WorkingSet<Backend>& work_;
  const Options& options_;
  Report& report_;
  Clock clock_;
  Monitor monitor_;
  double unit_;  ///< of the energy inside, in the caller's
  double energy_ = 0;
  double last_sum_ = 0;
  bool rings_stale_ = true;
  bool flips_boundary_;        ///< while it is worth it
  bool removes_faces_ = true;  ///< the same
};

}  // namespace alternate_detail

template <class Backend>
Report optimize_on(const Backend& par, TetMesh& mesh, const Options& options, const Context& context,
                   SlideSurface* surface) {
  const auto start = Monitor::Time::now();
  Report report;
  Clock clock(report);
  report.vertices = static_cast<std::int64_t>(mesh.points.size());
  report.tets_before = static_cast<std::int64_t>(mesh.tets.size());
  WorkingSet<Backend> work;
  clock.measure("load", [&] { load(par, mesh, options, surface, work, report); });
  alternate_detail::Alternation<Backend> alternation(par, work, options, context, report, start);
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
                            tags_of(work.mesh.tet2original.download(), mesh),
                            ids.work2new(),
                            work.mobilities.kind.download(),
                            work.frozen,
                            work.required_slots,
                            work.scale};
      report.targets = report_targets(outcome, options);
    });
  }
  clock.measure("store", [&] {
    // Memory for what storing needs.
    work.rings = {};
    work.coloring = {};
    work.flips = {};
    store(par, work, options, mesh, surface, report);
  });
  report.tets_after = static_cast<std::int64_t>(mesh.tets.size());
  return report;
}

}  // namespace tetune

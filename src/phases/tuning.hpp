// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "backend/span.hpp"
#include "tetune/options.hpp"

/// The tuning constants of all phases, one set per effort. Energies without another unit are shape energies of one
/// tetrahedron: 1 for the regular one, larger for all others. A "fraction" is relative to the total that is named.
namespace tetune {

/// untangle(): regularized sweeps in rounds.
struct UntangleParameters {
  /// Regularization at the start of a round, in turn: vertices that are stuck under one value can move under another.
  /// Relative to the cube of the local length.
  std::array<double, 4> regularizations{0.3, 0.9, 3, 0.09};
  /// The regularization is multiplied by this factor after each sweep, so that it vanishes in the limit.
  double regularization_decay = 0.7;
  int max_sweeps = 16;  ///< per round
  int max_rounds = 12;
  /// The first round with flips, counted from 0. Earlier, where many tetrahedra are inverted, flips create tangles that
  /// no position of the vertices resolves.
  int first_flip_round = 2;
  /// Before the first flips, one continuation over all vertices within `rings` of a tetrahedron that was tangled in the
  /// input: its regularization at the start, the factor per sweep, the number of sweeps and their over-relaxation.
  int rings = 8;
  double start = 0.3;
  double decay = 0.97;
  int max_continuation_sweeps = 400;
  double relaxation = 1.7;
};

/// One visit of a vertex by a sweep.
struct RelocationParameters {
  /// Over-relaxation factor of the Newton step (docs/benchmarks/cpu.md, "Relaxation").
  double relaxation = 1.7;
  /// A Newton step is skipped if its predicted decrease is below this fraction of the ring's energy.
  double min_gain = 1e-10;
  /// A gradient step is skipped if the norm of the gradient is below this: eps_g of the paper.
  double min_gradient = 1e-5;
};

/// alternate(): flips and sweeps in turn.
struct AlternationParameters {
  /// A further sweep follows if the last one decreased the energy by more than this fraction
  /// (docs/benchmarks/cpu.md, "When to stop").
  double min_sweep_decrease = 2e-3;
  /// Flips that decrease the energy by less than this fraction double the number of sweeps until the next flips.
  double min_flip_decrease = 3e-3;
  /// A flip pass that decreases the energy by less than this fraction is the last one of its kind: until the next
  /// sweep, or for boundary flips and face removals until the end of the phase.
  double min_pass_decrease = 5e-4;
  /// Before the first sweep only tetrahedra above this energy propose flips. Sweeps improve all others first and reach
  /// a lower energy than flips before them (docs/benchmarks/cpu.md, "The first flips").
  double first_flip_energy = 8;
  /// After a sweep only tetrahedra above this energy propose flips. 0: all of them.
  double flip_energy = 0;
  /// Flips follow one sweep only.
  bool flips_once = false;
};

/// lower_mean_energy(): rounds of inserted and removed vertices.
struct MeanParameters {
  /// Above this mean energy the mean of the energy to the power 2^kLog2Root takes its place (mean_objective()).
  static constexpr double kMaxMean = 20;
  static constexpr int kLog2Root = -3;
  /// 0: the phase is left out.
  int max_rounds = 0;
  /// Vertices are inserted and removed at this fraction of the tetrahedra: those of the largest energies.
  double max_fraction = 0.05;
  /// An operation must lower the energy beyond the mean by this fraction of the energy of as many tetrahedra of mean
  /// energy as its cavity has.
  double min_gain = 1e-3;
  /// A round that lowers the excess of the mean energy over 1 by less than this fraction is the last one.
  double min_fall = 0.01;
  /// The fraction of the growth of the mesh that insertion may use up: the smallest angles need the rest.
  double growth_fraction = 0.4;
  /// Proposals that hardly ever succeed are left out: of the first rounds they are a small part, and in coarse meshes
  /// those few insertions raise the smallest angles.
  bool is_selective = false;
};

/// improve_worst(): rounds of work around the tetrahedra of the largest energy.
struct WorstParameters {
  /// 0: all phases after alternate() are left out (improves_worst()).
  int max_rounds = 10;
  /// About this fraction of the tetrahedra are the worst; those of equal energies are all included.
  double max_fraction = 3e-4;
  /// Only tetrahedra above this energy are among the worst.
  double min_energy = 2;
  /// The objective is the shape energy to the power 2^log2_power, in which the worst tetrahedra dominate the sum.
  int log2_power = 2;
  /// A round that decreases this objective by less than this fraction is the last one.
  double min_decrease = 1e-2;
  /// Work budget: the number of worst tetrahedra, summed over the rounds, is at most `budget` plus this fraction of all
  /// tetrahedra. Thin uniform layers have many equally bad tetrahedra.
  double budget = 300;
  double budget_fraction = 1e-2;
  bool has_budget = true;
};

/// improve_angles(): rounds of work around the tetrahedra whose dihedral angles cost most.
struct AngleParameters {
  int max_rounds = 6;
  /// Rounds follow while those before have worked on fewer tetrahedra than this.
  double budget = 60;
  /// A round works on about the fraction `max_fraction` of the tetrahedra, or in a small mesh on `min_count` of them,
  /// but not on more than the fraction `small_mesh_fraction`; those of equal costs are all included.
  double max_fraction = 3e-4;
  double min_count = 20;
  double small_mesh_fraction = 2e-3;
  /// A round works only on tetrahedra with a dihedral angle whose cost (DihedralCots::cost()) is above this: 1.2 is the
  /// cost of about 40 degrees, 1.01 that of 44.7.
  double min_cost = 1.2;
  /// The weight of large angles in that cost.
  double obtuse_weight = 1;
  /// The smallest mean ratio that these rounds may leave, as a fraction of the smallest one of the input.
  double mean_ratio_fraction = 1;
  /// A retriangulation must lower the largest cost in its cavity by this fraction.
  double min_cost_gain = 0.02;
  /// Passes per round that move vertices to where the largest cost around them is lowest.
  int opening_passes = 2;
  /// Vertices are inserted and removed around about this fraction of the tetrahedra, or this number of them in a small
  /// mesh. 0: the values of Effort::best, where edits_vertices() holds.
  double max_vertex_fraction = 0;
  double min_vertex_count = 0;
  /// The relative accuracy of the cost that a given number of tetrahedra exceed.
  double cost_resolution = 0.01;
  /// Whether neighbors of their vertices move too, where a cost around them is above min_cost, to make room.
  bool moves_neighbors = false;
  /// Maximum number of further rounds while at least `min_tied` tetrahedra have about the largest cost, and that
  /// exceeds `tied_cost` (1.3: 37.6 degrees). Restarts treat only a few tetrahedra.
  int tied_rounds = 0;
  double min_tied = 64;
  double tied_cost = 1.3;
  /// The costs within this fraction of the largest are about the largest; where that exceeds `thin_cost` (3.5: 16
  /// degrees), as in layers that are thinner than their elements are wide, those within `thin_tied_fraction`: there the
  /// gap bounds the angles, and rounds would lower the mean ratio for little gain.
  double tied_fraction = 0.2;
  double thin_cost = 3.5;
  double thin_tied_fraction = 0.05;
  /// Maximum number of last rounds. Each works on about `last_count` of the worst tetrahedra: the few that still need
  /// many operations include the worst one of the mesh.
  int last_rounds = 0;
  double last_count = 0;
  /// Rounds for tied tetrahedra and last rounds end after `max_stalls` successive ones that each lower the largest cost
  /// by less than the fraction `min_fall`.
  int max_stalls = 4;
  double min_fall = 1e-3;

  int rounds() const { return max_rounds + tied_rounds + last_rounds; }
};

/// restart_worst(): the neighborhoods of the worst elements optimized again.
struct RestartParameters {
  /// The number of rounds by default (Options::restarts); one per `tets_per_round` tetrahedra in smaller meshes.
  int rounds = 0;
  double tets_per_round = 400;
  /// Maximum number of spots at which a round restarts.
  int spots = 4;
  /// Maximum number of perturbations that a round tries per spot; the first one in order that succeeds is kept. On
  /// several threads later ones start before the earlier ones have ended.
  int tries = 3;
  /// Spots are at elements whose cost is within this fraction of the largest.
  double worst_fraction = 0.05;
  /// A restart is kept if it lowers the largest cost by the fraction `min_fall`, or leaves it and lowers the sum of the
  /// costs to the power of eight by the fraction `min_fall_of_others`.
  double min_fall = 1e-4;
  double min_fall_of_others = 0.05;
  /// In the rounds that follow for the largest angle its cost exceeds that of the smallest one by this fraction.
  double obtuse_lead = 0.075;
  /// The rounds for the largest angle end after this number of successive ones without a restart that is kept.
  int max_rounds_without = 6;
  /// Where more than `max_worst` elements have a cost within the fraction `tie` of the largest, as in structured
  /// meshes, there are no restarts.
  double tie = 5e-3;
  int max_worst = 16;
  /// A perturbation: the rings of vertices around the element, rounds under the energy, and then under the mean energy.
  struct Perturbation {
    int rings, energy_rounds, mean_rounds;
  };
  /// Each restart that follows a failure takes the next one, which leads elsewhere; after the last one the element is
  /// left as it is.
  std::array<Perturbation, 8> perturbations{
      {{1, 3, 0}, {1, 3, 2}, {1, 0, 2}, {2, 0, 0}, {2, 3, 0}, {1, 1, 2}, {2, 3, 2}, {3, 2, 0}}};
  /// Maximum number of rounds that then enlarge angles.
  int angle_rounds = 10;
  int max_stalls = 3;  ///< see AngleParameters
  /// The number of rings that these rounds work on in addition to those of the perturbation.
  int angle_rings = 2;
  /// About the number of tetrahedra that each of them works on.
  double count = 12;
  /// They work on angles whose cost is above this fraction of the largest.
  double cost_fraction = 0.7;
  /// The number of further rings of the neighborhood, in which vertices may move.
  int margin = 1;
  /// Insertion before the restarts leaves this number of tetrahedra of the growth of the mesh to them and to flips, but
  /// at most the fraction `max_reserved_fraction` of that growth.
  double reserved = 60;
  double max_reserved_fraction = 0.4;
};

/// polish(): lower_mean_energy(), sweeps and flips above the floor of the angles reached.
struct PolishParameters {
  int sweeps = 0;
  int sweeps_with_flips = 0;  ///< the first ones
  /// Work on the extremes has inserted vertices in places where the mean energy can fall again.
  MeanParameters mean;
};

/// TargetFollower: the steps of a motion. A fraction is of the straight way to a target.
struct MotionParameters {
  /// The residual of the harmonic extension, relative to the right-hand side, and a limit on its iterations.
  double solver_tolerance = 1e-6;
  int max_solver_iterations = 5000;
  /// A step is accepted while the energy of each tetrahedron is below this, or has grown by less than this factor.
  double safe_energy = 8;
  double max_energy_growth = 2;
  /// A refused step is repeated at this fraction of its length; after an accepted one the next may be longer by the
  /// factor `step_increase`.
  double step_decrease = 0.75;
  double step_increase = 2;
  /// Steps of less than this fraction are stalls: they are accepted where all volumes stay positive, whatever the
  /// energies. The motion ends after this number of stalls in succession.
  double min_fraction = 1e-3;
  int max_stalls = 4;
};

struct Tuning {
  UntangleParameters untangle;
  RelocationParameters relocation;
  AlternationParameters alternation;
  MeanParameters mean;
  WorstParameters worst;
  AngleParameters angles;
  RestartParameters restart;
  PolishParameters polish;
  MotionParameters motion;
  /// The energy is summed again when it has fallen below this fraction of its last sum: rounding errors of the
  /// decreases subtracted since then are relative to that sum.
  double resum_fraction = 0.1;
};

namespace tuning_detail {

constexpr Tuning fast() {
  Tuning t;
  t.alternation.min_sweep_decrease = 2e-2;
  t.alternation.flip_energy = 1.5;
  t.alternation.flips_once = true;
  t.worst.max_rounds = 0;
  return t;
}

constexpr Tuning best() {
  Tuning t;
  t.alternation.min_sweep_decrease = 1e-4;
  t.alternation.min_flip_decrease = 1e-4;
  t.alternation.min_pass_decrease = 1e-4;
  t.mean.max_rounds = 12;
  t.worst.has_budget = false;
  t.angles.max_rounds = 8;
  t.angles.budget = std::numeric_limits<double>::infinity();
  t.angles.max_fraction = 4e-3;
  t.angles.min_count = 200;
  t.angles.small_mesh_fraction = 1;
  t.angles.obtuse_weight = 1.5;
  t.angles.max_vertex_fraction = 6e-4;
  t.angles.min_vertex_count = 100;
  t.angles.min_cost_gain = 3e-3;
  t.angles.mean_ratio_fraction = 0.25;
  t.angles.tied_rounds = 16;
  t.angles.last_rounds = 4;
  t.angles.last_count = 12;
  t.angles.min_cost = 1.01;  // lattices have many angles of 45 degrees, of cost 1
  t.restart.rounds = 10;
  t.polish = {4, 2, {.max_rounds = 12, .max_fraction = 0.2, .growth_fraction = 1, .is_selective = true}};
  return t;
}

inline constexpr Tuning kFast = fast();
inline constexpr Tuning kStandard{};
inline constexpr Tuning kBest = best();

}  // namespace tuning_detail

inline const Tuning& tuning_of(Effort effort) {
  using namespace tuning_detail;
  return effort == Effort::fast ? kFast : effort == Effort::best ? kBest : kStandard;
}

/// Whether the phases after alternate() run.
inline bool improves_worst(const Options& options) {
  return tuning_of(options.effort).worst.max_rounds > 0 && options.termination == Termination::relative &&
         options.energy == Energy::shape && options.max_iterations > 0;
}

/// Whether vertices are inserted and removed.
inline bool edits_vertices(const Options& options) {
  const bool asked = options.effort == Effort::best || options.surface_vertices == SurfaceVertices::edit;
  return improves_worst(options) && asked && !options.keep_vertices;
}

/// improve_angles() works on the fractions of the tetrahedra in its parameters times this: a mesh that may grow by more
/// than the default does so in as many rounds.
inline double selection_scale(const Options& options) {
  constexpr double kScalePerGrowth = 60;
  return edits_vertices(options) ? 1 + kScalePerGrowth * std::max(0.0, options.max_growth - Options{}.max_growth) : 1;
}

/// The number of rounds of restarts at most.
inline int restart_rounds(const Options& options, double tets) {
  const RestartParameters& p = tuning_of(options.effort).restart;
  if (p.rounds == 0) return 0;
  return options.restarts >= 0 ? options.restarts : int(std::ceil(std::min(double(p.rounds), tets / p.tets_per_round)));
}

/// The fraction of the growth of the mesh that retriangulation may use up: flips that follow add some tetrahedra.
inline constexpr double kInsertedFraction = 0.95;
/// Same, before restarts, which need some of the growth by `max_added` tetrahedra.
inline double inserted_fraction_before(const RestartParameters& restarts, double max_added) {
  return std::min(kInsertedFraction, 1 - std::min(restarts.max_reserved_fraction, restarts.reserved / max_added));
}

/// The number of rounds for the largest angle that follow at most.
inline int largest_angle_rounds(const Options& options) {
  return options.restarts >= 0 ? options.restarts : tuning_of(options.effort).restart.rounds;
}

/// The number of vertices that phases after alternate() may remove beyond those that they insert, of a mesh of a given
/// number.
inline Size removable_vertices(Size vertices) {
  constexpr double kMaxRemoved = 0.1;
  return Size(std::ceil(kMaxRemoved * double(vertices)));
}

/// Whether the distance of the surface from the input's is limited.
inline bool has_deviation_bound(const Options& options) {
  return options.boundary == Boundary::slide && options.max_deviation > 0;
}

/// Whether edges of the surface may be flipped at all.
inline bool may_flip_boundary(const Options& options) {
  return options.flips && options.boundary_flips && options.boundary != Boundary::fixed && options.max_ring > 3;
}

/// Whether vertices of the surface may be inserted and removed.
inline bool edits_surface_vertices(const Options& options) {
  return edits_vertices(options) && options.surface_vertices != SurfaceVertices::keep;
}

/// Whether vertices of the surface are inserted and removed, and its edges flipped in the phases after alternate().
inline bool edits_surface(const Options& options) {
  return edits_surface_vertices(options) && may_flip_boundary(options);
}

/// Whether alternate() flips edges of the surface. With a bound on the deviation and operations on the surface it does
/// not: the vertices of flipped triangles can only drift afterwards (CheckedSurface::is_edited).
inline bool flips_boundary(const Options& options) {
  return may_flip_boundary(options) && !(has_deviation_bound(options) && edits_surface(options));
}

/// The part of a bound on the deviation that is left to operations that change the triangles of the surface.
inline double bend_share(const Options& options) { return edits_surface(options) ? 0.25 : 0; }

/// Whether such operations, and flips of surface edges, may bend the surface within kMaxBend.
inline bool bends_surface(const Options& options) {
  return edits_surface(options) && options.boundary == Boundary::slide;
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "driver/curved/optimize_curved.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "backend/span.hpp"
#include "curved/curved_edges.hpp"
#include "curved/curved_splits.hpp"
#include "curved/held_bound.hpp"
#include "driver/curved/curved_constraints.hpp"
#include "driver/curved/curved_refusal.hpp"
#include "driver/curved/curved_skeleton.hpp"
#include "driver/curved/curved_slide.hpp"
#include "driver/curved/split_elements.hpp"
#include "driver/curved/straighten.hpp"
#include "driver/limit_growth.hpp"
#include "driver/report/dof_counts.hpp"
#include "driver/report/extend_report.hpp"
#include "driver/report/run_warnings.hpp"
#include "driver/report/targets.hpp"
#include "mesh/id_maps.hpp"
#include "mesh/sorted.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "phases/progress/latched_hooks.hpp"
#include "phases/progress/phase_timer.hpp"
#include "tetune/data.hpp"
#include "tetune/error.hpp"
#include "tetune/quality.hpp"

namespace tetune {
namespace {

/// Elements below this scaled Jacobian are relaxed.
constexpr double kRelaxBelow = 0.5;
/// The accuracy of a scaled Jacobian.
constexpr double kAccuracy = 2e-3;

class CurvedOptimizer {
 public:
  CurvedOptimizer(const TetMesh& mesh, const Options& options, const Context& context)
      : input_(mesh),
        caller_(options),
        options_(options),
        context_(context),
        base_(mesh),
        origins_(own_origins(mesh)),
        held_(find_held(mesh, options)),
        max_tets_(options.max_growth * double(mesh.tets.size())) {}

  Report run(TetMesh& mesh) {
    goal_.min_dihedral = quality(base_, options_.threads).dihedral_min;
    goal_.moves_vertices = options_.data == DataTransfer::carry;
    goal_.threads = options_.threads;
    goal_.stop = context_.stop;
    make_base_valid();
    const bool slides = options_.boundary == Boundary::slide;
    const bool runs_twice = slides && !slides_at_once();
    const Surface first = slides && !runs_twice ? Surface::slides : Surface::stays;
    TetMesh result;
    Report report =
        *run_stage(result, first, runs_twice ? scaled_progress(context_, 0, 0.5) : context_, OnStop::complete);
    follow_origins(report);
    report.vertices_inserted += std::ssize(base_.points) - std::ssize(mesh.points);
    if (runs_twice) counts_input_ = false;  // the surface has not slid
    if (runs_twice && !is_stopped()) slide_from(result, report);
    report_whole(result, report);
    mesh = std::move(result);
    return report;
  }

 private:
  /// The tetrahedra that an attempt to optimize locks.
  enum class Locking {
    near_bad,  ///< those around bad elements of the attempts before
    curved,
    all,
  };
  enum class OnStop { complete, give_up };
  enum class Surface { stays, slides };

  /// The number of attempts that lock tetrahedra near bad ones, with a surface that stays or slides. Then curved ones
  /// are locked, and if that does not suffice, all.
  static constexpr int kMaxAttempts = 4;
  static constexpr int kMaxSlidingAttempts = 12;
  static constexpr int kAttemptsPerRing = 4;  ///< later ones lock more around a bad element
  static constexpr int kMaxRounds = 4;        ///< of splits of elements that their held nodes make invalid
  /// The number of tetrahedra that the split of an edge adds, at least.
  static constexpr double kTetsPerSplit = 3;

  /// With other data than carried ones the result has places in the input, which one run alone gives.
  bool slides_at_once() const { return options_.data != DataTransfer::carry; }

  /// Without sweeps and flips mid-side nodes keep their bits too.
  bool changes_nothing() const { return options_.max_iterations == 0 && !options_.flips && !options_.untangle; }

  /// Turns the report on the stages into one on the input and the result.
  void report_whole(const TetMesh& result, Report& report) {
    report.vertices = std::ssize(input_.points);
    report.tets_before = std::ssize(input_.tets);
    const Quality before = quality(input_, caller_.threads), after = quality(result, caller_.threads);
    report.energy_before = energy_of(before);
    report.energy_after = energy_of(after);
    report.straightened = std::move(straightened_);
    if (!counts_input_) count_curved_vertices(input_, caller_, report);
    report.targets = report_curved_targets(result, caller_, report.vertex2original);
    if (caller_.untangle) report.curved_warnings = warn_of_smaller_angle(before, after);
    warn_of_bounded(result, report);
    report.warnings = report.curved_warnings;
  }

  /// Warns of elements whose scaled Jacobian the surface bounds, where only the growth limits their splits.
  void warn_of_bounded(const TetMesh& result, Report& report) const {
    const bool is_full = double(result.tets.size()) + kTetsPerSplit > max_tets_;
    if (!may_insert() || !is_full) return;
    const auto bounded = find_bounded(result, find_held(result, options_of(report)), kSmallBound).size();
    if (bounded == 0) return;
    report.curved_warnings.push_back(
        "the surface bounds the scaled Jacobian of " + std::to_string(bounded) +
        " tetrahedra, which are not split as the mesh may not grow further; a larger max_growth "
        "(--max-growth) allows it");
  }

  /// The energy of the straight tetrahedra.
  double energy_of(const Quality& q) const { return options_.energy == Energy::harmonic ? q.eta_sum : q.shape_sum; }

  /// Optimizes the base; its surface stays, or slides. Returns the report, whose maps lead to the base; with
  /// OnStop::give_up nothing, if a stop is requested before it begins, or while nodes of the surface are lifted.
  std::optional<Report> run_stage(TetMesh& result, Surface surface, const Context& context, OnStop on_stop) {
    std::optional<CurvedSlide> slide;
    if (surface == Surface::slides) slide.emplace(base_, options_.feature_angle);
    floor_ = smallest(base_) - kAccuracy;
    if (on_stop == OnStop::give_up && is_stopped()) return std::nullopt;
    const int max_attempts = slide ? kMaxSlidingAttempts : kMaxAttempts;
    double linear_bound = 0;
    std::vector<Index> locked;
    if (changes_nothing()) locked = identity_map(base_.tets.size());
    Locking locking = Locking::near_bad;
    for (int attempt = 0;; ++attempt) {
      if (locking == Locking::curved) locked = all_curved(base_);
      if (locking == Locking::all) locked = identity_map(base_.tets.size());
      CurvedSkeleton skeleton(base_, held_, locked, slide ? &*slide : nullptr);
      Report report = optimize(skeleton.mesh, linear_options(surface, linear_bound),
                               attempt == 0 ? context : Context{{}, context_.stop});
      LiftedNodes lifted;
      if (slide) {
        // The result of an earlier stop is lifted, and so is the base with all elements locked.
        const bool may_stop = !is_stopped() && locking != Locking::all;
        std::optional<LiftedNodes> nodes =
            slide->lift(skeleton.mesh, report, options_.threads, may_stop ? context_.stop : std::function<bool()>());
        if (!nodes && on_stop == OnStop::give_up) return std::nullopt;
        if (!nodes) {
          locking = Locking::all;
          continue;
        }
        lifted = *std::move(nodes);
      }
      skeleton.restore(report);
      lifted.apply(skeleton.mesh);
      SurfaceDeviation deviation;
      if (slide && options_.max_deviation > 0) {
        deviation = slide->deviation(skeleton.mesh, report, options_, context_.stop);
      }
      const std::vector<Index> bad = relax(skeleton.mesh, report, surface);
      if ((bad.empty() && deviation.vertices.empty()) || locking == Locking::all) {
        split_bounded_of(skeleton.mesh, report);
        report.deviation = deviation.bound + straightened_distance();
        counts_input_ = locked.empty() && base_.points.size() == input_.points.size();
        result = std::move(skeleton.mesh);
        return report;
      }
      // The straight surface moves farther than the curved one, most of all on fine meshes.
      const bool was_bounded = linear_bound == options_.max_deviation;
      if (!deviation.vertices.empty()) linear_bound = (linear_bound == 0 ? 4 : 1) * options_.max_deviation;
      if (!was_bounded) deviation.vertices.clear();
      const bool is_last_near_bad = is_stopped() || attempt + 1 >= max_attempts;
      locking = locking == Locking::curved ? Locking::all : is_last_near_bad ? Locking::curved : Locking::near_bad;
      lock(bad, deviation.vertices, skeleton.mesh, report, 1 + attempt / kAttemptsPerRing, locked);
    }
  }

  /// The largest distance by which straightening has moved the surface: the shape functions of the three mid-side nodes
  /// of a triangle add up to at most 4/3.
  double straightened_distance() const {
    double largest = 0;
    for (const StraightenedEdge& e : straightened_) largest = std::max(largest, e.moved);
    return 4.0 / 3 * largest;
  }

  /// Lets the surface of a result slide, unless the elements are worse on the whole then.
  void slide_from(TetMesh& result, Report& report) {
    options_ = options_of(report);
    base_ = result;
    held_ = find_held(base_, options_);
    goal_.min_dihedral = quality(base_, options_.threads).dihedral_min;
    TetMesh slid;
    std::optional<Report> further =
        run_stage(slid, Surface::slides, scaled_progress(context_, 0.5, 0.5), OnStop::give_up);
    if (!further) return;
    if (quality(slid, options_.threads).shape_sum > quality(result, options_.threads).shape_sum) {
      counts_input_ = false;
      return;
    }
    result = std::move(slid);
    dof_counts(report) = dof_counts(*further);
    extend_report(report, *std::move(further), result);
  }

  /// Composes the maps of the report with origins_, so that they lead to the input.
  void follow_origins(Report& report) const {
    for (Index& t : report.tet2original) t = span_of(origins_.tets)[t];
    if (base_.points.size() == input_.points.size()) return;
    report.vertex2original = compose(origins_.vertices, std::move(report.vertex2original));
  }

  /// Untangles the curved elements of the input with Options::untangle; else refuses them.
  void make_base_valid() {
    const std::vector<Index> invalid = find_invalid(base_, options_.threads);
    if (invalid.empty()) return;
    if (!options_.untangle) throw CurvedError(invalid, TetMeshView(base_).centroid(invalid[0]));
    // The straight tetrahedra have to stay positive; their angles are improved afterwards.
    RelaxationGoal goal = goal_;
    goal.min_dihedral = 0;
    goal.only_valid = true;
    split_held_invalid(invalid);
    // Without straightening, elements with a folded face are refused below, and all others that are not valid counted.
    relax_curved(base_, held_,
                 options_.straighten ? find_unfolded(base_, options_.threads) : find_invalid(base_, options_.threads),
                 goal);
    const std::vector<Index> rest = find_invalid(base_, options_.threads);
    if (!options_.straighten && !with_folded_face(base_, rest).empty()) refuse(std::ssize(invalid), rest);
    if (may_insert()) split_invalid(base_, held_, origins_, goal);
    if (options_.straighten) extend_options();
    if (options_.straighten && !is_stopped()) straightened_ = straighten(base_, held_, options_, goal);
    const std::vector<Index> left = find_invalid(base_, options_.threads);
    if (left.empty() && may_insert()) split_bounded(base_, held_, origins_, goal, max_tets_);
    extend_options();
    if (!left.empty()) refuse(std::ssize(invalid), left);
    goal_.min_dihedral = quality(base_, options_.threads).dihedral_min;
  }

  /// Splits elements that their held nodes alone make invalid: relaxation of these takes long and fails.
  void split_held_invalid(const std::vector<Index>& invalid) {
    const std::vector<Index> folded = with_folded_face(base_, invalid);
    for (int round = 0; round < kMaxRounds && may_insert() && !is_stopped(); ++round) {
      std::vector<Index> tets = find_bounded(base_, held_, 0);
      std::erase_if(
          tets, [&](Index t) { return std::binary_search(folded.begin(), folded.end(), span_of(origins_.tets)[t]); });
      if (tets.empty() || split_edges(base_, held_, tets, kUnlimitedSplits, origins_).empty()) return;
      held_.vertices.resize(base_.points.size(), 0);
    }
  }

  bool may_insert() const {
    return options_.untangle && !options_.keep_vertices && options_.data == DataTransfer::carry;
  }

  /// Inserted vertices have data, and are not frozen.
  void extend_options() {
    if (base_.points.size() == input_.points.size()) return;
    base_.point_data = carry_point_data(base_.point_data, origins_.vertices, base_.points, base_.tets);
    if (!options_.frozen_vertices.empty()) options_.frozen_vertices.resize(base_.points.size(), 0);
    held_ = find_held(base_, options_);
  }

  [[noreturn]] void refuse(std::int64_t invalid, const std::vector<Index>& left) const {
    const auto in_input = [this](const std::vector<Index>& tets) { return translated_ids(tets, origins_.tets); };
    refuse_curved(input_, caller_, {invalid, in_input(left), in_input(with_folded_face(base_, left)), is_stopped()});
  }
  bool is_stopped() const { return context_.stop && context_.stop(); }
  std::vector<CurvedTet> measure(const TetMesh& mesh) const { return measure_curved_tets(mesh, options_.threads); }
  double smallest(const TetMesh& mesh) const {
    double least = 1;
    for (const CurvedTet& t : measure(mesh)) least = std::min(least, t.scaled_jacobian());
    return least;
  }
  static std::vector<Index> all_curved(const TetMesh& mesh) { return curved_tets(mesh, CurvedEdges(mesh)); }

  /// Elements that are below the limit or not valid, or flattened.
  std::vector<Index> find_bad(const TetMesh& mesh, double limit, Surface surface) const {
    std::vector<Index> bad = not_valid_or_below(measure(mesh), limit);
    if (surface == Surface::stays) return bad;
    const std::vector<Index> flat = flatter_than(mesh, goal_.min_dihedral, options_.threads);
    bad.insert(bad.end(), flat.begin(), flat.end());
    sort_unique(bad);
    return bad;
  }

  /// Relaxes the elements of a small scaled Jacobian. Returns those that are not valid or below the floor then.
  std::vector<Index> relax(TetMesh& mesh, const Report& report, Surface surface) const {
    const double limit = options_.max_iterations == 0 ? floor_ : std::max(kRelaxBelow, floor_);
    const std::vector<Index> low = find_bad(mesh, limit, surface);
    if (!low.empty()) relax_curved(mesh, find_held(mesh, options_of(report)), low, goal_);
    return find_bad(mesh, floor_, surface);
  }

  /// Splits elements that flips made with two faces on the surface, unless something is worse then.
  void split_bounded_of(TetMesh& mesh, Report& report) const {
    HeldNodes held = find_held(mesh, options_of(report));
    if (!may_insert() || is_stopped() || find_bounded(mesh, held, kSmallBound).empty()) return;
    TetMesh trial = mesh;
    Origins origins = own_origins(mesh);
    if (!report.tet2original.empty()) origins.tets = report.tet2original;
    if (!report.vertex2original.empty()) origins.vertices = report.vertex2original;
    RelaxationGoal goal = goal_;
    goal.only_valid = true;
    split_bounded(trial, held, origins, goal, max_tets_);
    const std::int64_t inserted = std::ssize(trial.points) - std::ssize(mesh.points);
    if (inserted == 0) return;
    trial.point_data = carry_point_data(base_.point_data, origins.vertices, trial.points, trial.tets);
    relax_curved(trial, held, not_valid_or_below(measure(trial), kRelaxBelow), goal_);
    const bool keeps_angle = quality(trial, options_.threads).dihedral_min >= goal_.min_dihedral;
    if (!keeps_angle || !find_invalid(trial, options_.threads).empty() || smallest(trial) < smallest(mesh)) return;
    mesh = std::move(trial);
    report.tet2original = std::move(origins.tets);
    report.vertex2original = std::move(origins.vertices);
    report.tets_after = std::ssize(mesh.tets);
    report.vertices_inserted += inserted;
  }

  /// Lists the tetrahedra of the base within some rings around bad ones of the result and vertices that are too far.
  void lock(const std::vector<Index>& bad, const std::vector<Index>& far, const TetMesh& mesh, const Report& report,
            int rings, std::vector<Index>& locked) const {
    std::vector<std::uint8_t> is_near(base_.points.size(), 0);
    for (const Index v : far) span_of(is_near)[v] = 1;
    for (const Index t : bad) {
      for (const Index v : span_of(mesh.tets)[t]) {
        const Index original = original_of(report.vertex2original, v);
        if (original >= 0) span_of(is_near)[original] = 1;
      }
    }
    lock_around(base_, is_near, rings, locked);
  }

  Options linear_options(Surface surface, double max_deviation) const {
    const bool slides = surface == Surface::slides;
    Options options = options_;
    options.untangle = false;
    options.max_deviation = max_deviation;
    // CurvedSlide lists the features.
    options.feature_angle = slides ? 180 : Options().feature_angle;
    if (options.boundary == Boundary::slide && !slides) options.boundary = Boundary::preserve;
    // Splits count as growth.
    limit_growth(options, max_tets_, base_);
    if (!slides) return options;
    if (slides_at_once()) {
      // Vertices are inserted inside the mesh only.
      if (options.surface_vertices == SurfaceVertices::edit) {
        options.boundary_flips = false;
      } else {
        options.surface_vertices = SurfaceVertices::keep;
      }
      return options;
    }
    // The run before has inserted and removed vertices.
    options.keep_vertices = true;
    options.surface_vertices = SurfaceVertices::automatic;
    return options;
  }
  Options options_of(const Report& report) const { return follow_vertices(options_, report.vertex2original); }

  const TetMesh& input_;
  const Options& caller_;
  Options options_;  ///< for the vertices of base_
  const Context& context_;
  TetMesh base_;     ///< the input, made valid
  Origins origins_;  ///< of base_ in the input
  HeldNodes held_;
  double max_tets_;  ///< beyond which nothing is split or inserted for better elements
  RelaxationGoal goal_;
  std::vector<StraightenedEdge> straightened_;
  double floor_ = 0;
  bool counts_input_ = true;  ///< the numbers of vertices by degrees of freedom are those of the input
};

}  // namespace

Report optimize_curved(TetMesh& mesh, const Options& options, const Context& context) {
  const auto start = PhaseTimer::SteadyClock::now();
  check_curved_input(mesh, options);
  const LatchedHooks hooks(context);
  RunWarnings warnings(mesh, options);
  Report report = CurvedOptimizer(mesh, options, hooks.context()).run(mesh);
  if (hooks.is_stopped()) report.stop = StopReason::cancelled;
  warnings.add_to(report, std::move(report.warnings));
  report.seconds = PhaseTimer::seconds_since(start);
  add_seconds(report, "curved", report.seconds - seconds_of_phases(report));
  return report;
}

}  // namespace tetune

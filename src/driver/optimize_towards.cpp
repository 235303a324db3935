// SPDX-License-Identifier: Apache-2.0
#include "tetune/optimize_towards.hpp"

#include <algorithm>
#include <compare>
#include <optional>
#include <utility>

#include "backend/span.hpp"
#include "driver/criteria_losses.hpp"
#include "driver/curved/curved_constraints.hpp"
#include "driver/limit_growth.hpp"
#include "driver/parts/optimize_active.hpp"
#include "driver/report/extend_report.hpp"
#include "driver/report/run_warnings.hpp"
#include "driver/report/targets.hpp"
#include "driver/report/unchanged.hpp"
#include "mesh/id_maps.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "phases/progress/latched_hooks.hpp"
#include "phases/progress/phase_timer.hpp"
#include "phases/tuning.hpp"
#include "quality/check_measures.hpp"
#include "quality/find_failed.hpp"
#include "tetune/curved.hpp"
#include "tetune/error.hpp"
#include "tetune/quality.hpp"

namespace tetune {
namespace {

constexpr int kMaxTargetRounds = 4;
/// Rounds on at most this number of tetrahedra are never too long.
constexpr std::ptrdiff_t kLarge = 50'000;
/// The relative error of a smallest mean ratio.
constexpr double kRounding = 1e-9;
/// The parts of the progress of the first run, and of the rounds on its result or on the input.
constexpr double kFirstRun = 0.75;
constexpr double kRounds = (1 - kFirstRun) / 2;

std::string reason_for_no_rounds(const TetMesh& mesh, const Options& options) {
  if (!mesh.curved_edges.empty()) return "the mesh has curved edges";
  if (!options.only_below.empty()) return "only_below chooses the elements that may change";
  if (options.data != DataTransfer::carry) return "with data=interpolate or data=conserve the mesh is optimized once";
  if (options.energy == Energy::harmonic) return "energy=harmonic excludes work on the worst elements";
  if (options.termination == Termination::paper) return "termination=paper excludes work on the worst elements";
  return "";
}

/// The quantities that rounds lower: the number of criteria with a verdict, then that of the tetrahedra that miss their
/// limits.
struct Misses {
  std::int64_t criteria = 0, tets = 0;
  auto operator<=>(const Misses&) const = default;
};

/// The misses of the criteria that fail; with Verdict::warn, of those that warn or fail.
Misses misses_of(const AcceptanceReport& report, Verdict level) {
  Misses misses;
  for (const CriterionResult& r : report.results) {
    if (r.verdict < level) continue;
    ++misses.criteria;
    misses.tets += r.failed + (level == Verdict::warn ? r.warned : 0);
  }
  return misses;
}

/// Returns the target on a dihedral angle that the criterion implies, which an angle of the surface may rule out;
/// nothing for other measures.
std::optional<Target> target_of(const AcceptanceCriterion& criterion) {
  if (criterion.measure < CheckMeasure::volume) return Target{Measure(criterion.measure), *criterion.fail};
  if (criterion.measure == CheckMeasure::equiangle_skew) {
    return Target{Measure::min_dihedral, kRegularDihedral * (1 - *criterion.fail)};
  }
  return std::nullopt;
}

class CriteriaRun {
 public:
  CriteriaRun(const AcceptanceCriteria& criteria, const Options& options, const Context& caller)
      : criteria_(criteria), options_(options), hooks_(caller) {}

  CriteriaReport run(TetMesh& input) {
    report_.before = check(input, criteria_, options_.threads);
    report_.no_rounds = reason_for_no_rounds(input, options_);
    const bool may_limit = input.curved_edges.empty() && options_.only_below.empty();
    TetMesh mesh = input;
    report_.optimization = optimize(mesh, options_, context_for(0, report_.no_rounds.empty() ? kFirstRun : 1));
    report_.after = check(mesh, criteria_, options_.threads);
    const auto start = PhaseTimer::SteadyClock::now();
    const double known = seconds_of_phases(report_.optimization);
    max_tets_ = options_.max_growth * double(input.tets.size());
    if (report_.no_rounds.empty() && report_.after.verdict == Verdict::fail) {
      find_least_mean_ratio(input, mesh);
      make_rounds(mesh);
    }
    if (const std::string losses = losses_in(report_.before, report_.after); !losses.empty() && was_valid(input)) {
      keep_input(input, mesh, losses);
      if (report_.no_rounds.empty()) work_on_input(mesh, losses);
    }
    if (may_limit) find_limits(mesh);
    const double of_rounds = seconds_of_phases(report_.optimization) - known;
    add_seconds(report_.optimization, "criteria", PhaseTimer::seconds_since(start) - of_rounds);
    if (hooks_.is_stopped()) report_.optimization.stop = StopReason::cancelled;
    input = std::move(mesh);
    return std::move(report_);
  }

 private:
  bool is_stopped() const { return report_.optimization.stop == StopReason::cancelled || hooks_.is_stopped(); }

  Context context_for(double done, double fraction) const { return scaled_progress(hooks_.context(), done, fraction); }

  /// An input that had to be untangled is worse than any result.
  bool was_valid(const TetMesh& input) const {
    return !options_.untangle ||
           (report_.optimization.tets_untangled == 0 && measure_curved(input, options_.threads).all_valid());
  }

  void find_least_mean_ratio(const TetMesh& input, const TetMesh& mesh) {
    const double fraction = tuning_of(options_.effort).angles.mean_ratio_fraction;
    least_mean_ratio_ = std::min(fraction * quality(input, options_.threads).mean_ratio_min,
                                 quality(mesh, options_.threads).mean_ratio_min);
  }

  /// Undoes the run, whose objective has lowered measures of criteria; `losses` names what these would lose.
  void keep_input(const TetMesh& input, TetMesh& mesh, const std::string& losses) {
    mesh = input;
    discard_result(mesh, options_, "the mesh is as before: criteria would be met less well afterwards (" + losses + ")",
                   report_.optimization);
    report_.undone = report_.optimization.unchanged;
    if (!mesh.curved_edges.empty()) report_.optimization.targets = report_curved_targets(mesh, options_, {});
    report_.rounds.clear();
    report_.after = report_.before;
    is_input_kept_ = true;
  }

  /// Makes rounds on the input, whose optimization as a whole was undone: where nothing fails, on what warns.
  void work_on_input(TetMesh& mesh, const std::string& losses) {
    if (report_.after.verdict == Verdict::pass) return;
    level_ = report_.after.verdict;
    progress_ += kRounds;
    find_least_mean_ratio(mesh, mesh);
    make_rounds(mesh);
    if (!has_kept_round()) return;
    report_.optimization.unchanged.clear();
    report_.undone =
        "only tetrahedra that miss a limit, and those around them, were changed: optimized as a whole, the "
        "mesh would meet criteria less well than before (" +
        losses + ")";
    // Vertices have moved since the report of the kept input.
    RunWarnings(mesh, options_).add_to(report_.optimization, {report_.undone});
  }

  bool has_kept_round() const {
    return std::any_of(report_.rounds.begin(), report_.rounds.end(), [](const CriteriaRound& r) { return r.kept; });
  }

  /// The caller's options for the vertices of an intermediate mesh.
  Options current_options() const { return options_for_result(options_, report_.optimization.vertex2original); }

  Options round_options(const TetMesh& mesh) const {
    Options options = current_options();
    // The first run slides on the surface of the input; rounds would slide on that of the result before.
    if (options.boundary == Boundary::slide) options.boundary = Boundary::preserve;
    const bool inserts = options_.effort == Effort::best || options_.surface_vertices == SurfaceVertices::edit;
    options.keep_vertices = options_.keep_vertices || !inserts || double(mesh.tets.size()) >= max_tets_;
    if (options.keep_vertices) options.surface_vertices = SurfaceVertices::automatic;
    // Growth is relative to the part of the round, which is at most the mesh.
    if (!options.keep_vertices) options.max_growth = growth_up_to(max_tets_, mesh);
    options.effort = Effort::best;
    options.restarts = 0;  // they would enlarge angles at the expense of other measures
    options.targets.clear();
    options.trace_angles = false;
    return options;
  }

  std::vector<std::uint8_t> failing_tets(const TetMesh& mesh) const {
    std::vector<std::uint8_t> flags(mesh.tets.size(), 0);
    for (const CriterionResult& r : report_.after.results) {
      if (r.verdict < level_) continue;
      AcceptanceCriterion limit = r.criterion;
      if (level_ == Verdict::warn && limit.warn) limit.fail = limit.warn;
      for (const FailedTet& f : find_failed(mesh, limit, options_.threads)) span_of(flags)[f.tet] = 1;
    }
    return flags;
  }

  void make_rounds(TetMesh& mesh) {
    std::int64_t undone = 0;  // size of the part of the last round, if it was undone
    for (int i = 0; i < kMaxTargetRounds && report_.after.verdict >= level_ && !is_stopped(); ++i) {
      const CriteriaRound round = make_round(mesh, i);
      report_.rounds.push_back(round);
      // With a part that more rings do not enlarge, the next round is the same.
      if (!round.kept && (round.active == undone || round.active == std::ssize(mesh.tets))) break;
      undone = round.kept ? 0 : round.active;
      // Where most of a large mesh fails, another round takes as long as the first run.
      const bool is_large = round.active > std::max(kLarge, std::ssize(mesh.tets) / 2);
      constexpr std::int64_t kFailedPerGain = 20;
      const bool gains =
          round.kept && kFailedPerGain * (round.failed_before - round.failed_after) > round.failed_before;
      if (is_large && !gains) break;
    }
  }

  CriteriaRound make_round(TetMesh& mesh, int i) {
    const auto start = PhaseTimer::SteadyClock::now();
    const Misses before = misses_of(report_.after, level_);
    CriteriaRound round;
    round.rings = Options().rings + i;
    round.failed_before = round.failed_after = before.tets;
    TetMesh changed = mesh;
    const Context context = context_for(progress_ + kRounds * i / kMaxTargetRounds, kRounds / kMaxTargetRounds);
    Report report;
    try {
      report = optimize_tets(changed, {failing_tets(mesh), round.rings}, round_options(mesh), context);
    } catch (const OverlapError&) {
      return round;  // not kept
    }
    round.active = report.tets_active;
    AcceptanceReport accepted = check(changed, criteria_, options_.threads);
    const Misses after = misses_of(accepted, level_);
    round.failed_after = after.tets;
    const std::size_t max_tets = std::max(mesh.tets.size(), std::size_t(max_tets_));
    // Each round has a quality floor of its own, which leaves room below its smallest mean ratio.
    round.kept = after < before && !has_worse_value(report_.after, accepted, level_) &&
                 changed.tets.size() <= max_tets && (!is_input_kept_ || losses_in(report_.before, accepted).empty()) &&
                 quality(changed, options_.threads).mean_ratio_min >= (1 - kRounding) * least_mean_ratio_;
    if (round.kept) {
      mesh = std::move(changed);
      report_.after = std::move(accepted);
      extend_report(report_.optimization, std::move(report), mesh);
    }
    round.seconds = PhaseTimer::seconds_since(start);
    return round;
  }

  /// Judges Options::targets after the rounds, and finds the constraints of the elements that fail, unless the caller
  /// has requested a stop.
  void find_limits(const TetMesh& mesh) {
    const bool retargets = (has_kept_round() || is_input_kept_) && !options_.targets.empty();
    const bool limits = report_.after.verdict == Verdict::fail && !is_stopped();
    if (!limits && !retargets) return;
    const Options options = current_options();
    const ImportedMesh imported = imported_mesh(mesh, options);
    if (retargets) report_.optimization.targets = report_targets(imported, options);
    for (const CriterionResult& r : report_.after.results) {
      if (limits && r.verdict == Verdict::fail)
        report_.limits.push_back(limits_of(mesh, r.criterion, imported, options));
    }
  }

  CriterionLimits limits_of(const TetMesh& mesh, const AcceptanceCriterion& criterion, const ImportedMesh& imported,
                            const Options& options) const {
    const std::vector<Index> tet2slot = inverse_map(imported.slot2tet, imported.slot2tet.size());
    CriterionLimits limits;
    limits.criterion = criterion;
    const TetMeshView view(mesh);
    for (const FailedTet& f : find_failed(mesh, criterion, options.threads)) {
      MissedTet missed;
      missed.tet = span_of(tet2slot)[f.tet];
      missed.value = f.value;
      missed.centroid = view.centroid(f.tet);
      limits.worst.push_back(missed);
    }
    find_limiting(imported.mesh, options, target_of(criterion), limits.worst);
    for (MissedTet& m : limits.worst) {
      m.tet = span_of(imported.slot2tet)[m.tet];
      ++limits.held_by[std::size_t(m.held_by)];
    }
    keep_worst(info_of(criterion.measure).larger_is_better, limits.worst);
    return limits;
  }

  const AcceptanceCriteria& criteria_;
  const Options& options_;
  const LatchedHooks hooks_;
  CriteriaReport report_;
  Verdict level_ = Verdict::fail;  ///< of the criteria that rounds work on
  double progress_ = kFirstRun;    ///< before the rounds
  double max_tets_ = 0;
  double least_mean_ratio_ = 0;  ///< a round whose smallest mean ratio is below it is undone
  bool is_input_kept_ = false;
};

}  // namespace

CriteriaReport optimize_towards(TetMesh& mesh, const AcceptanceCriteria& criteria, const Options& options,
                                const Context& context) {
  const auto start = PhaseTimer::SteadyClock::now();
  CriteriaReport report = CriteriaRun(criteria, options, context).run(mesh);
  report.optimization.seconds = PhaseTimer::seconds_since(start);
  return report;
}

}  // namespace tetune

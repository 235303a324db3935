// SPDX-License-Identifier: Apache-2.0
#include "driver/parts/optimize_active.hpp"

#include <algorithm>
#include <atomic>
#include <string_view>

#include "backend/cpu.hpp"
#include "boundary/classify.hpp"
#include "driver/devices.hpp"
#include "driver/parts/active_part.hpp"
#include "driver/report/run_warnings.hpp"
#include "driver/report/unchanged.hpp"
#include "driver/transfer_stop.hpp"
#include "mesh/id_maps.hpp"
#include "mesh/validate_arrays.hpp"
#include "phases/progress/latched_hooks.hpp"
#include "phases/progress/phase.hpp"
#include "phases/progress/phase_timer.hpp"
#include "quality/limits.hpp"
#include "tetune/error.hpp"
#include "tetune/option_table.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// Optimizes the part. Errors name tetrahedra of the whole mesh.
Report run_part(const TetMesh& whole, ActivePart& part, const Context& context) {
  try {
    return run_on_device(part.mesh, part.options, context, nullptr, nullptr);
  } catch (const UntangleError& e) {
    throw UntangleError(e.tangled, translated_ids(e.left, part.tet2whole), e.reason);
  } catch (const OverlapError& e) {
    throw OverlapError(translated_ids(e.tets, part.tet2whole));
  } catch (const MeshError& e) {
    throw error_of_whole(e, part.mesh, whole, part.options.threads);
  }
}

/// The number of vertices that the tagged edges other than ridges and required ones make junctions of lines.
Size count_junctions(const TetMesh& mesh, const Constraints& constraints) {
  std::vector<Index> degree(mesh.points.size(), 0);
  for (std::size_t e = constraints.ridges; e < constraints.edges.size(); ++e) {
    for (const Index v : constraints.edges[e]) ++span_of(degree)[v];
  }
  return std::count_if(degree.begin(), degree.end(), [](Index d) { return d > 2; });
}

/// A run that can be stopped.
struct Run {
  const Options& options;
  const LatchedHooks& hooks;
  PhaseTimer::SteadyClock::time_point start = PhaseTimer::SteadyClock::now();
};

/// The hooks of a run that repeats one whose result is discarded because it lacks vertices. As the first run removed
/// these after its flips and sweeps, a stop takes effect only after those of the second: otherwise nothing would be
/// left of that work, and an inverted mesh would not be untangled.
class RepeatHooks {
 public:
  explicit RepeatHooks(const Context& hooks) : hooks_(hooks) {
    context_.stop = [this] { return is_past_ && hooks_.stop(); };
    context_.progress = [this](const Progress& p) {
      const std::string_view phase = p.phase;
      for (const Phase later : {Phase::worst, Phase::angles, Phase::restarts}) {
        if (phase == progress_name_of(later)) is_past_ = true;
      }
      const bool proceeds = !hooks_.progress || hooks_.progress(p);
      return proceeds || !is_past_;
    };
  }
  RepeatHooks(const RepeatHooks&) = delete;
  RepeatHooks& operator=(const RepeatHooks&) = delete;
  const Context& context() const { return context_; }

 private:
  const Context& hooks_;
  std::atomic<bool> is_past_ = false;
  Context context_;
};

/// change_tets() for known constraints and active tetrahedra.
std::optional<PartMaps> change_active(TetMesh& mesh, const Constraints& constraints, const ActiveTets& active,
                                      const Run& run, const ChangePart& change, Report& report) {
  const Options& options = run.options;
  if (active.count == 0) {
    report = report_unchanged(mesh, options);
    return PartMaps();
  }
  Report whole;
  const ListedFeatures features = find_listed_features(mesh, options, constraints, whole);
  ActivePart part = take_part(mesh, active, constraints, features, options);
  const std::size_t vertices = part.mesh.points.size();
  bool is_taken = change(part, run.hooks.context());
  if (is_taken && part.mesh.points.size() < vertices) {
    // Vertices would get other numbers.
    part = take_part(mesh, active, constraints, features, options);
    part.options.keep_vertices = true;
    const RepeatHooks hooks(run.hooks.context());
    is_taken = change(part, hooks.context());
    if (run.hooks.is_stopped()) report.stop = StopReason::cancelled;
  }
  report.corners_not_held = whole.corners_not_held;
  report.edges_not_held = whole.edges_not_held;
  report.line_ends_not_held = whole.line_ends_not_held;
  report.tets_bad = active.bad;
  report.tets_active = active.count;
  if (!is_taken) return std::nullopt;
  RunWarnings(mesh, options).add_to(report);
  return replace_part(mesh, std::move(part), active, transfer_stop(run.hooks.context().stop, run.start), report);
}

/// The number of tetrahedra that miss a limit; 0 without limits, for which nothing is measured.
std::int64_t count_missing(const TetMesh& mesh, const std::vector<Target>& limits, int threads) {
  if (limits.empty()) return 0;
  const std::vector<std::uint8_t> missing = tets_missing_limits(mesh, limits, threads);
  return std::count(missing.begin(), missing.end(), 1);
}

Report optimize_active_tets(TetMesh& mesh, const Constraints& constraints, const ActiveTets& active,
                            const Options& options, const Context& caller) {
  const LatchedHooks hooks(caller);
  const Run run{options, hooks};
  Report report;
  std::int64_t before = 0, after = 0;
  const auto change = [&](ActivePart& part, const Context& context) {
    before = count_missing(part.mesh, options.only_below, options.threads);
    report = run_part(mesh, part, context);
    after = count_missing(part.mesh, options.only_below, options.threads);
    // An input that had to be untangled is worse than any result.
    return after <= before || report.tets_untangled > 0;
  };
  if (change_active(mesh, constraints, active, run, change, report)) return report;
  // The objective may lower other measures than those of the floor.
  discard_result(mesh, options,
                 "the mesh is as before: " + std::to_string(after) + " tetrahedra would miss the limits afterwards, " +
                     std::to_string(before) + " do so now",
                 report);
  return report;
}

}  // namespace

MeshError error_of_whole(const MeshError& of_part, const TetMesh& part, const TetMesh& whole, int threads) {
  if (of_part.what() != validate(part, threads).message(false)) return of_part;
  const ValidationReport report = validate(whole, threads);
  return report.ok() ? of_part : MeshError(report.message(false));
}

Constraints checked_constraints(const TetMesh& mesh, const Options& options) {
  check_options(options);
  require_arrays(mesh);
  return find_constraints(mesh, options);
}

ListedFeatures find_listed_features(const TetMesh& mesh, const Options& options, const Constraints& constraints,
                                    Report& report) {
  const auto is_few = [&](VertexConstraint constraint) {
    return std::count(constraints.vertices.begin(), constraints.vertices.end(), constraint) <= kFewListed;
  };
  if (is_few(VertexConstraint::corner) && is_few(VertexConstraint::line_end) &&
      count_junctions(mesh, constraints) <= kFewListed) {
    return {.corners = true, .edges = true, .line_ends = true};
  }
  report = report_constraints(mesh, options);
  const bool are_lines = report.edges_not_held == 0;
  return {.corners = report.corners_not_held == 0,
          .edges = are_lines,
          .line_ends = are_lines && report.line_ends_not_held == 0};
}

Report optimize_active(TetMesh& mesh, const Options& options, const Context& context) {
  const auto start = PhaseTimer::SteadyClock::now();
  const Constraints constraints = checked_constraints(mesh, options);
  Report report = optimize_active_tets(mesh, constraints, find_active(mesh, constraints, options), options, context);
  report.seconds = PhaseTimer::seconds_since(start);
  return report;
}

Report optimize_tets(TetMesh& mesh, FlaggedPart part, const Options& options, const Context& context) {
  const auto start = PhaseTimer::SteadyClock::now();
  const Constraints constraints = checked_constraints(mesh, options);
  const ActiveTets active = activate(mesh, std::move(part.flags), constraints, part.rings);
  Report report = optimize_active_tets(mesh, constraints, active, options, context);
  report.seconds = PhaseTimer::seconds_since(start);
  return report;
}

std::optional<PartMaps> change_tets(TetMesh& mesh, FlaggedPart part, const Options& options, const Context& context,
                                    const ChangePart& change, Report& report) {
  const LatchedHooks hooks(context);
  const Run run{options, hooks};
  const Constraints constraints = checked_constraints(mesh, options);
  const ActiveTets active = activate(mesh, std::move(part.flags), constraints, part.rings);
  auto maps = change_active(mesh, constraints, active, run, change, report);
  report.seconds = PhaseTimer::seconds_since(run.start);
  return maps;
}

}  // namespace tetune

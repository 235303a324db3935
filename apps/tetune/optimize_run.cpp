// SPDX-License-Identifier: Apache-2.0
#include "optimize_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <new>
#include <optional>
#include <string_view>

#include "declined_measures.hpp"
#include "geometry_files.hpp"
#include "interrupt.hpp"
#include "map_file.hpp"
#include "mesh_errors.hpp"
#include "mesh_files.hpp"
#include "move_targets.hpp"
#include "option_flags.hpp"
#include "option_values.hpp"
#include "report_files.hpp"
#include "tables.hpp"
#include "time_estimate.hpp"

namespace tetune::cli {
namespace {

std::string thread_count(int threads) { return fmt::format("{} thread{}", threads, threads == 1 ? "" : "s"); }

using Time = std::chrono::steady_clock;

double seconds_since(Time::time_point start) { return std::chrono::duration<double>(Time::now() - start).count(); }

/// --untangle failed: the exit code is 1, although nothing is written.
class NotUntangled : public MeshError {
 public:
  using MeshError::MeshError;
};

nlohmann::ordered_json ids_from_1(const std::vector<Index>& ids) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Index id : ids) json.push_back(id + 1);
  return json;
}

class Run {
 public:
  Run(const OptimizeArguments& arguments, const Job& job, Console& console)
      : a_(arguments), job_(job), console_(console), options_(arguments.options), warnings_(arguments.warnings) {}

  JobResult run() {
    read();
    if (a_.dry_run) return dry_run();
    optimize_mesh();
    write();
    finish();
    return result_;
  }

 private:
  void read() {
    if (!job_.output.empty() && job_.output != kPipe) check_writable(job_.output);
    for (const std::string& path : job_.texts()) check_place(path);
    console_.phase("reading");
    std::future<Geometry> geometry = start_reading(a_.geometry, a_.options.threads);
    input_ = read_input(job_.input, options_.threads);
    choose_tags(input_, job_.input, a_.tags);
    warn_all(input_.warnings);
    const std::string name = shown_input(job_.input);
    if (input_.mesh.tets.empty()) throw MeshError(name + ": there is no tetrahedron in this file");
    freeze(a_.frozen, name, input_.mesh, options_);
    file_links_ = input_.mesh.periodic.size();
    add_links(a_.periodic, a_.periodic_map, name, input_.mesh);
    if (geometry.valid()) {
      geometry_.emplace(geometry.get());
      warn_all(geometry_->warnings());
    }
    if (a_.move) {
      std::vector<std::string> target_warnings;
      targets_ = read_targets(input_.mesh, *a_.move, options_.threads, target_warnings);
      warn_all(target_warnings);
    }
    if (a_.deviation_bound) options_.max_deviation = a_.deviation_bound->in(bounding_box(input_.mesh));
    const std::size_t needed =
        a_.move ? memory_needed_to_move(input_.mesh, targets_.size(), options_) : memory_needed(input_.mesh, options_);
    needed_mb_ = static_cast<double>(needed) / (1024 * 1024);
    if (a_.max_memory && needed_mb_ > *a_.max_memory) {
      throw MeshError(
          fmt::format("{}: needs about {:.0f} MB of memory, and --max-memory allows {:.6g}; allow more, or use a "
                      "smaller mesh",
                      name, needed_mb_, *a_.max_memory));
    }
  }

  /// Whether the figures of the run are printed or written.
  bool shows_figures() const { return console_.verbosity() > 0 || !job_.report.empty(); }
  /// The tables and the warning of measures that decline need fewer measures than the report, and JSON lines only some.
  Quality measure() const {
    const bool warns = !a_.move && console_.verbosity() >= 0;
    if (!warns && !shows_figures() && !console_.json()) return {};
    return job_.report.empty() ? quality(input_.mesh, options_.threads) : measure_all(input_.mesh, options_.threads);
  }

  /// Calls optimize().
  void improve(const Context& context) {
    const std::string file = shown_input(job_.input);
    try {
      result_.before = measure();
      if (a_.criteria && a_.move) criteria_.before = check(input_.mesh, *a_.criteria, options_.threads);
      measured_at_ = Time::now();
      if (a_.move) {
        motion_ = move(input_.mesh, targets_, options_, context);
        report_ = std::move(motion_.optimization);
      } else if (a_.criteria && !a_.dry_run) {
        criteria_ = optimize_towards(input_.mesh, *a_.criteria, options_, context);
        report_ = std::move(criteria_.optimization);
      } else if (geometry_ && !a_.dry_run) {
        on_geometry_ = optimize_on_geometry(input_.mesh, *geometry_, options_,
                                            {.snap = a_.geometry.snap == "yes", .measures = shows_figures()}, context);
        report_ = std::move(on_geometry_.optimization);
      } else {
        report_ = optimize(input_.mesh, options_, context);
      }
    } catch (const UntangleError& e) {
      if (e.reason == UntangleError::Reason::stopped) {
        throw NotUntangled(file + ": stopped before all tetrahedra were made " + (e.of_curved ? "valid" : "positive") +
                           ", nothing was written");
      }
      fail_to_untangle(e);
    } catch (const Error&) {
      rethrow_with_message(file, input_.mesh, options_.threads, kUntangleHere);
    }
  }

  /// The message has the first tetrahedra that could not be repaired, the report all of them.
  [[noreturn]] void fail_to_untangle(const UntangleError& e) {
    if (!job_.report.empty() && !a_.dry_run) {
      nlohmann::ordered_json json = report_head();
      json["untangling"] = {{"inverted_or_flat", e.tangled}, {"left", ids_from_1(e.left)}};
      if (!e.folded.empty()) json["untangling"]["folded"] = ids_from_1(e.folded);
      try {
        write_text(job_.report, json_text(json));
      } catch (const FileError& file_error) {
        console_.warn(file_error.what());
      }
    }
    throw NotUntangled(shown_input(job_.input) + ": " + untangle_message(e, input_.mesh));
  }

  void warn(const std::string& text) {
    console_.warn(text);
    warnings_.push_back(text);
  }
  void warn_all(const std::vector<std::string>& texts) {
    for (const std::string& text : texts) warn(text);
  }

  /// Loads the mesh, which finds its constraints, and stops there.
  JobResult dry_run() {
    console_.phase("checking");
    const std::string counts = mesh_summary(input_.mesh);
    double load_seconds = 0;
    Context context;
    context.progress = [&](const Progress& p) {
      load_seconds = p.seconds;
      return std::string_view(p.phase) != "load";
    };
    improve(context);
    std::string text = fmt::format("{}{}: nothing is written\n{}", shown_input(job_.input),
                                   job_.output.empty() ? "" : " -> " + shown_output(job_.output), counts);
    text += constraint_table(report_);
    for (const std::string& note : constraint_notes(report_)) text += "  " + note + "\n";
    text += quality_table({"now"}, {result_.before});
    text += fmt::format("  memory                 about {:.0f} MB\n", needed_mb_);
    const auto seconds = estimated_seconds(options_, input_.seconds, load_seconds, report_.threads);
    if (seconds && !a_.move) {
      text += fmt::format("  time                   about {:.2g} s on {}\n", *seconds, thread_count(report_.threads));
    }
    console_.print(text);
    result_.code = kDone;
    result_.summary = "checked";
    return result_;
  }

  void optimize_mesh() {
    const bool compares = options_.boundary == Boundary::slide && !a_.move && !geometry_ && shows_figures();
    if (compares) original_ = std::make_unique<TetMesh>(input_.mesh);
    console_.phase(a_.move ? "moving" : "optimizing");
    std::optional<Time::time_point> end;
    Context context;
    context.progress = console_.progress_hook();
    context.stop = [&] {
      interrupt::enter(interrupt::Stage::worth_writing);
      if (a_.time_limit && !end) end = end_of_work();
      late_ = late_ || (end && Time::now() >= *end);
      return late_ || interrupt::requested();
    };
    improve(context);
    warn_all(run_warnings(report_, a_.move ? a_.move->displacement : ""));
    warn_all(geometry_warnings(on_geometry_));
    warn_all(motion_.warnings(true));
    if (report_.unchanged.empty() && !criteria_.undone.empty()) warn(criteria_.undone);
  }

  /// The time at which to stop so that there is time to write. Called when the mesh is loaded: storing it takes part of
  /// the time of loading, and writing about as long as reading.
  Time::time_point end_of_work() const {
    constexpr double kStoringPerLoading = 0.25;
    constexpr double kWritingPerReading = 1.2;
    const double reserved = kStoringPerLoading * seconds_since(measured_at_) + kWritingPerReading * input_.seconds;
    constexpr double kMaxSeconds = 1e9;  // a longer duration would overflow
    const auto limit = std::chrono::duration<double>(std::clamp(*a_.time_limit - reserved, 0.0, kMaxSeconds));
    return start_ + std::chrono::duration_cast<Time::duration>(limit);
  }

  void write() {
    console_.phase("writing");
    const auto start = Time::now();
    input_.mesh.periodic.resize(file_links_);
    std::vector<std::string> warnings;
    // A deck may include other files, with names relative to its own folder.
    const bool may_copy = !has_changed() && a_.tags.empty() && input_.mesh.deck == nullptr;
    if (!may_copy || !copy_mesh(job_.input, job_.output)) {
      warnings = write_output(job_.output, input_.binary, input_.mesh, options_.threads);
    }
    interrupt::enter(interrupt::Stage::written);
    write_seconds_ = seconds_since(start);
    warn_all(warnings);
    if (job_.map.empty()) return;
    write_beside_mesh(job_.map, map_text(report_, input_.mesh.points.size(), input_.mesh.tets.size()));
  }

  /// Writes a text beside the mesh, which is written already.
  void write_beside_mesh(const std::string& path, const std::string& text) {
    try {
      write_text(path, text);
    } catch (const FileError& e) {
      warn(fmt::format("{}; the mesh was written", e.what()));
      lacks_texts_ = true;
    }
  }

  /// Whether there was something to do, as --only-below may leave nothing.
  bool has_worked() const { return options_.only_below.empty() || report_.tets_active > 0; }
  bool has_changed() const { return has_worked() && (options_.only_below.empty() || report_.unchanged.empty()); }
  bool stopped() const { return report_.stop == StopReason::cancelled; }

  void finish() {
    result_.after = measure();
    if (!a_.move && !stopped()) warn_all(declined_measures(result_.before, result_.after, "--only-below"));
    if (a_.criteria && a_.move) criteria_.after = check(input_.mesh, *a_.criteria, options_.threads);
    const bool accepted = !a_.criteria || criteria_.after.verdict != Verdict::fail;
    const bool met = std::all_of(report_.targets.begin(), report_.targets.end(), [](const auto& t) { return t.met(); });
    result_.code = stopped() || !motion_.reached() || !met || !accepted ? kStoppedEarly : kDone;
    result_.summary = stopped()            ? (late_ ? "time limit" : "interrupted")
                      : !motion_.reached() ? "motion blocked"
                      : !met               ? "target missed"
                      : !accepted          ? "criterion failed"
                                           : "done";
    std::optional<Comparison> change;
    if (original_ && !stopped()) {
      // Measuring the distances takes long. A bound is tested at all points; otherwise a part of them is measured, so
      // that it takes no longer than the optimization.
      const std::int64_t max_samples = options_.max_deviation > 0 && input_.mesh.curved_edges.empty() ? 0 : 25'000;
      change = compare(*original_, input_.mesh, options_.threads, max_samples);
    }
    if (change) check_surface(*change);
    if (result_.code == kStoppedEarly && !shows_figures()) warn(shortfall());
    if (!job_.trace.empty()) write_beside_mesh(job_.trace, trace_csv(report_));
    if (!job_.report.empty()) {
      nlohmann::ordered_json json = full_report();
      if (change) json["surface"] = to_json(*change);
      if (change && options_.max_deviation > 0) json["surface"]["max_deviation_kept"] = deviation_kept_;
      write_beside_mesh(job_.report, json_text(json));
    }
    if (!job_.page.empty()) {
      nlohmann::ordered_json json = full_report();
      json["page"] = job_.page;
      write_beside_mesh(a_.page_data, json_text(json));
    }
    if (lacks_texts_ && result_.code == kDone) {
      result_.code = kStoppedEarly;
      result_.summary = "report not written";
    }
    if (shows_figures()) console_.print(summary(change));
  }

  /// The sentence on a run that ended early, where no table says why.
  std::string shortfall() const {
    const std::string output = shown_output(job_.output);
    if (stopped() || motion_.reached()) return output + ": " + result_.summary;
    return blocked_text(output, fmt::format("at target {}", motion_.targets_reached + 1), motion_.fraction);
  }

  void check_surface(const Comparison& change) {
    if (!(options_.max_deviation > 0)) return warn_all(changed_volume(change));
    constexpr double kRounding = 1e-6;  // relative error of distances far from the origin
    // The facets that stand for curved triangles differ from them.
    const double deviation = input_.mesh.curved_edges.empty()
                                 ? change.mean_edge * std::max(change.new_to_old, change.old_to_new)
                                 : report_.deviation;
    deviation_kept_ = deviation <= (1 + kRounding) * options_.max_deviation;
    if (deviation_kept_) return;
    warn(
        fmt::format("{}: the surface is {:.3e} from the old one, and --max-deviation allows {:.3e}; list the edges of "
                    "parts that are thinner than that, or allow less",
                    shown_input(job_.input), deviation, options_.max_deviation));
  }

  std::string summary(const std::optional<Comparison>& change) const {
    const char* reason = stopped() ? result_.summary : to_string(report_.stop);
    std::string text = quality_table({"before", "after"}, {result_.before, result_.after});
    text += curved_change(result_.before.curved, result_.after.curved);
    text += active_line(report_, options_);
    if (has_worked()) text += count_line(report_, reason);
    if (a_.move) text += move_summary(motion_, input_.mesh);
    if (change) text += surface_table(*change);
    if (geometry_) text += geometry_summary(*geometry_, on_geometry_);
    if (change && options_.max_deviation > 0) {
      text += fmt::format("  --max-deviation        {:.2e}{}\n", options_.max_deviation,
                          deviation_kept_ ? ", kept" : ", EXCEEDED");
    }
    for (const TargetReport& t : report_.targets) text += target_table(t);
    if (a_.criteria) text += change_table(criteria_) + criteria_table(criteria_);
    if (console_.verbosity() > 1) text += run_table(report_);
    text += fmt::format("  read {:.3f} s, {} {:.3f} s on {}{}, written {:.3f} s: {}\n", input_.seconds,
                        a_.move ? "moved" : "optimized", report_.seconds, report_.device,
                        report_.threads > 0 ? fmt::format(" ({})", thread_count(report_.threads)) : "", write_seconds_,
                        shown_output(job_.output));
    if (!report_.device_reason.empty())
      text += fmt::format("  on {}: {}\n", report_.device, with_flags(report_.device_reason));
    if (stopped())
      text += fmt::format("  stopped early ({}): a valid mesh was written, but there was more to do\n", reason);
    return text;
  }

  nlohmann::ordered_json report_head() const {
    return {{"tetune", TETUNE_VERSION}, {"instructions", instruction_set()}, {"input", job_.input},
            {"output", job_.output},    {"options", to_json(options_)},      {"warnings", warnings_}};
  }
  nlohmann::ordered_json full_report() const {
    nlohmann::ordered_json json = report_head();
    json["read_seconds"] = input_.seconds;
    json["write_seconds"] = write_seconds_;
    json["before"] = to_json(result_.before);
    json["after"] = to_json(result_.after);
    json["optimization"] = to_json(report_);
    if (a_.criteria) json["acceptance"] = to_json(criteria_);
    if (a_.move) json["motion"] = to_json(motion_);
    if (geometry_) json["geometry"] = to_json(*geometry_, on_geometry_);
    if (stopped()) json["optimization"]["stopped"] = result_.summary;
    return json;
  }

  const OptimizeArguments& a_;
  const Job& job_;
  Console& console_;
  Options options_;
  Time::time_point start_ = Time::now();
  Time::time_point measured_at_;
  Input input_;
  std::vector<std::string> warnings_;
  double needed_mb_ = 0;
  std::size_t file_links_ = 0;               ///< number of the periodic links of the file
  std::unique_ptr<const TetMesh> original_;  ///< with Boundary::slide, to compare the surfaces; not if they move
  std::vector<VertexTargets> targets_;       ///< of `tetune move`
  MoveReport motion_;                        ///< without its Report
  Report report_;
  CriteriaReport criteria_;  ///< with --criteria, without its Report
  std::optional<Geometry> geometry_;
  GeometryReport on_geometry_;  ///< with --geometry, without its Report
  bool lacks_texts_ = false;    ///< the report, the trace or the map could not be written
  bool late_ = false;           ///< the time limit was reached
  bool deviation_kept_ = true;
  double write_seconds_ = 0;
  JobResult result_;
};

}  // namespace

JobResult run_job(const OptimizeArguments& arguments, const Job& job, Console& console) {
  JobResult result;
  const auto start = Time::now();
  try {
    result = Run(arguments, job, console).run();
  } catch (const std::bad_alloc&) {
    console.error(shown_input(job.input) + ": out of memory");
  } catch (const NotUntangled& e) {
    console.error(e.what());
    result.code = kStoppedEarly;
  } catch (const std::exception& e) {
    console.error(e.what());
  }
  console.clear();
  result.seconds = seconds_since(start);
  return result;
}

}  // namespace tetune::cli

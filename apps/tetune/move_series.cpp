// SPDX-License-Identifier: Apache-2.0
#include "move_series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <new>
#include <numeric>
#include <optional>

#include "interrupt.hpp"
#include "mesh_errors.hpp"
#include "mesh_files.hpp"
#include "move_targets.hpp"
#include "option_flags.hpp"
#include "report_files.hpp"
#include "system/path.hpp"
#include "tables.hpp"
#include "tetune/io.hpp"
#include "tetune/live_mesh.hpp"
#include "tetune/series.hpp"

namespace tetune::cli {
namespace {

namespace fs = std::filesystem;

/// Throws OptionError for arguments that a series does not take.
void check_arguments(const OptimizeArguments& a, const Job& job) {
  if (!(is_series(job.input) || has_times(job.input)) || !is_series(job.output)) {
    throw OptionError(
        fmt::format("{} -> {}: a time series (.pvd, or an Exodus file) becomes a time series (.pvd); name one for both",
                    job.input, job.output));
  }
  if (has_times(job.input) && a.move->displacement.empty()) {
    throw OptionError(fmt::format(
        "{}: an Exodus file has the coordinates of one time; name the data of displacements with --displacement",
        job.input));
  }
  const std::pair<bool, const char*> refused[] = {{!a.move->to.empty(), "--to"},
                                                  {!job.map.empty(), "--map"},
                                                  {!job.trace.empty(), "--trace"},
                                                  {a.criteria.has_value(), "--criteria"},
                                                  {!a.periodic.empty(), "--periodic"},
                                                  {!a.periodic_map.empty(), "--periodic-map"},
                                                  {!a.max_deviation.empty(), "--max-deviation"},
                                                  {!a.options.targets.empty(), "--target-dihedral, --target-quality"},
                                                  {a.time_limit.has_value(), "--time-limit"},
                                                  {a.max_memory.has_value(), "--max-memory"},
                                                  {a.dry_run, "--dry-run"}};
  for (const auto& [is_given, flag] : refused) {
    if (is_given) throw OptionError(fmt::format("{}: {} is not for time series; leave it out", job.input, flag));
  }
}

/// The name of the mesh of a step: that of the series with a number.
std::string step_name(const std::string& series, std::size_t step) {
  const fs::path path = path_of(series);
  return (path.parent_path() / fmt::format("{}_{:04}.vtu", path.stem().string(), step)).string();
}

class SeriesRun {
 public:
  SeriesRun(const OptimizeArguments& arguments, const Job& job, Console& console)
      : a_(arguments), job_(job), console_(console), options_(arguments.options) {}

  JobResult run() {
    check_arguments(a_, job_);
    read();
    LiveMesh mesh = with_messages(shown_input(steps_[0].path), input_, options_.threads, kUntangleHere,
                                  [this] { return LiveMesh(input_, options_); });
    original_of_.resize(input_.points.size());
    std::iota(original_of_.begin(), original_of_.end(), 0);
    result_.before = quality(input_, options_.threads);
    result_.code = kDone;
    result_.summary = "done";
    for (std::size_t i = 0; i < steps_.size() && result_.code == kDone; ++i) {
      try {
        if (!make_step(mesh, i)) break;
      } catch (const std::exception& e) {
        if (written_.empty()) throw;
        fail_after_first(e);
      }
    }
    if (interrupt::requested()) {
      result_.code = kStoppedEarly;
      result_.summary = "interrupted";
      stopped_at_ = written_.size();
      blocked_fraction_.reset();
    }
    result_.after = quality(mesh.mesh(), options_.threads);
    finish();
    return result_;
  }

 private:
  /// Moves to a time and writes the mesh. Returns false if that was interrupted.
  bool make_step(LiveMesh& mesh, std::size_t i) {
    const bool moves = i > 0 || !a_.move->displacement.empty();
    MoveReport report;
    if (moves) report = move(mesh, i);
    if (interrupt::requested() && !report.reached()) return false;
    write(mesh.mesh(), i, moves ? &report : nullptr);
    return true;
  }
  /// The meshes of earlier times are written, and the series lists them.
  void fail_after_first(const std::exception& e) {
    const bool lacks_memory = dynamic_cast<const std::bad_alloc*>(&e) != nullptr;
    console_.error(lacks_memory ? job_.input + ": out of memory" : e.what());
    result_.code = kStoppedEarly;
    result_.summary = "a time failed";
  }

  void read() {
    check_writable(step_name(job_.output, 0));
    check_place(job_.output);
    for (const std::string& path : job_.texts()) check_place(path);
    console_.phase("reading");
    steps_ = read_series(job_.input);
    const std::vector<std::string> read = files_read(job_.input);
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      const std::string name = step_name(job_.output, i);
      std::error_code error;
      if (!fs::exists(path_of(steps_[i].path), error)) {
        throw OptionError(fmt::format("{}: there is no file {}, the mesh of time {}; remove the time, or make the file",
                                      job_.input, steps_[i].path, steps_[i].time));
      }
      if (!fs::exists(path_of(name), error)) continue;
      if (!a_.replaces) {
        throw OptionError(fmt::format("{0}: the mesh of a time would replace {1}, which exists; replace it with -o {0}",
                                      job_.output, name));
      }
      for (const std::string& file : read) {
        if (!fs::equivalent(path_of(name), path_of(file), error) || error) continue;
        throw OptionError(fmt::format("{}: the file {} of the input would be overwritten; give the output another name",
                                      job_.output, file));
      }
    }
    Input first;
    first.mesh = read_step(steps_[0], &first.warnings, options_.threads);
    choose_tags(first, steps_[0].path, a_.tags);
    for (const std::string& w : first.warnings) warn(w);
    input_ = std::move(first.mesh);
    if (input_.tets.empty()) throw MeshError(steps_[0].path + ": there is no tetrahedron in this file");
    freeze(a_.frozen, steps_[0].path, input_, options_);
  }

  void warn(const std::string& text) {
    if (std::find(warnings_.begin(), warnings_.end(), text) != warnings_.end()) return;
    console_.warn(text);
    warnings_.push_back(text);
  }

  /// The targets of a step, for the vertices of the first file.
  VertexTargets read_target(std::size_t i) {
    const SeriesStep& step = steps_[i];
    if (i == 0) return target_of(input_, input_, step.path, *a_.move);
    const TetMesh mesh = read_step(step, nullptr, options_.threads);
    if (mesh.points.size() != input_.points.size() || mesh.tets.size() != input_.tets.size()) {
      throw MeshError(fmt::format(
          "{}: {} vertices and {} tetrahedra, but {} has {} and {}; all files of a series must "
          "have the same mesh, with moved vertices or a displacement",
          step.path, mesh.points.size(), mesh.tets.size(), steps_[0].path, input_.points.size(), input_.tets.size()));
    }
    // Reading turns tetrahedra that the motion has turned over.
    const auto same = [](const auto& a, const auto& b) { return std::is_permutation(a.begin(), a.end(), b.begin()); };
    const auto differing = std::mismatch(mesh.tets.begin(), mesh.tets.end(), input_.tets.begin(), same).first;
    if (differing != mesh.tets.end()) {
      throw MeshError(
          fmt::format("{}: tetrahedron {} has other vertices than in {}; all files of a series must have "
                      "the same mesh, with moved vertices or a displacement",
                      step.path, differing - mesh.tets.begin() + 1, steps_[0].path));
    }
    return target_of(input_, mesh, step.path, *a_.move);
  }

  /// Moves the mesh to the target of a step, as far as that is possible.
  MoveReport move(LiveMesh& mesh, std::size_t i) {
    console_.phase("moving");
    const VertexTargets by_original = read_target(i);
    const auto has_target = [](const Point3& p) { return !std::isnan(p[0]); };
    VertexTargets target;
    for (const Index original : original_of_) {
      target.push_back(original < 0 ? Point3{NAN, NAN, NAN} : by_original.begin()[original]);
    }
    const auto missing = std::count_if(by_original.begin(), by_original.end(), has_target) -
                         std::count_if(target.begin(), target.end(), has_target);
    if (missing > 0) {
      throw OptionError(
          fmt::format("{}: {} vertices with a target were removed in earlier steps, in which they had "
                      "none; give them one in all steps, or --keep-vertices",
                      steps_[i].path, missing));
    }
    Context context;
    context.progress = console_.progress_hook();
    context.stop = [] {
      interrupt::enter(interrupt::Stage::worth_writing);
      return interrupt::requested();
    };
    MoveReport report = with_messages(shown_input(steps_[i].path), mesh.mesh(), options_.threads, kUntangleHere,
                                      [&] { return mesh.move(target, context); });
    const std::vector<Index>& from = report.optimization.vertex2original;
    if (!from.empty()) {
      std::vector<Index> now;
      for (const Index v : from) now.push_back(v < 0 ? v : original_of_.begin()[v]);
      original_of_ = std::move(now);
    }
    for (const std::string& w : run_warnings(report.optimization, a_.move->displacement)) warn(w);
    for (const std::string& w : report.warnings(true)) warn(w);
    return report;
  }

  /// Writes the mesh of a step and the series up to it.
  void write(const TetMesh& mesh, std::size_t i, const MoveReport* report) {
    console_.phase("writing");
    const SeriesStep step{steps_[i].time, step_name(job_.output, i)};
    std::vector<std::string> warnings;
    write_mesh(step.path, mesh, options_.threads, &warnings);
    for (const std::string& w : warnings) warn(w);
    written_.push_back(step);
    write_series(job_.output, written_);
    interrupt::enter(interrupt::Stage::written);
    nlohmann::ordered_json entry = {{"time", step.time}, {"file", step.path}};
    std::string text = fmt::format("  time {:.6g}: {}", step.time, shown_output(step.path));
    if (report == nullptr) {
      text += ", the mesh of the first file\n";
    } else {
      has_moved_ = has_moved_ || !report->steps.empty();
      entry["motion"] = to_json(*report);
      text += report->steps.empty() ? std::string(", nothing moved\n")
                                    : fmt::format(", {} steps, smallest dihedral angle of what moved {:.2f}\n",
                                                  report->steps.size(), report->steps.back().dihedral_min);
      if (!report->reached()) {
        result_.code = kStoppedEarly;
        result_.summary = "motion blocked";
        stopped_at_ = i;
        blocked_fraction_ = report->fraction;
        text += move_summary(*report, mesh);
      }
    }
    entries_.push_back(entry);
    console_.print(text);
  }

  /// The motion may be in point data, which are not used unless they are named.
  void warn_if_nothing_moved() {
    if (result_.code != kDone || has_moved_ || !a_.move->displacement.empty()) return;
    warn(
        fmt::format("{}: nothing moved: the vertices have the same positions at all times; if point data are their "
                    "displacements, name these with --displacement ({} has: {})",
                    job_.input, steps_[0].path, point_data_names(input_)));
  }

  void finish() {
    warn_if_nothing_moved();
    // Without tables, nothing else says why the exit code is not 0; a time that failed is an error.
    if (stopped_at_ && console_.verbosity() < 1) {
      const std::string output = shown_output(job_.output);
      const std::string at = fmt::format("at time {:.6g}", steps_[std::min(*stopped_at_, steps_.size() - 1)].time);
      warn(blocked_fraction_ ? blocked_text(output, at, *blocked_fraction_)
                             : fmt::format("{}: {} {}", output, result_.summary, at));
    }
    if (!job_.report.empty()) {
      const nlohmann::ordered_json json = {{"tetune", TETUNE_VERSION},        {"input", job_.input},
                                           {"output", job_.output},           {"options", to_json(options_)},
                                           {"warnings", warnings_},           {"before", to_json(result_.before)},
                                           {"after", to_json(result_.after)}, {"times", entries_}};
      write_report(json_text(json));
    }
    console_.print(quality_table({"first", "last"}, {result_.before, result_.after}) +
                   fmt::format("  {} of {} times written: {}\n", written_.size(), steps_.size(), job_.output));
  }

  /// Writes the report beside the meshes, which are written already.
  void write_report(const std::string& text) {
    try {
      write_text(job_.report, text);
    } catch (const FileError& e) {
      warn(fmt::format("{}; the meshes were written", e.what()));
      if (result_.code != kDone) return;
      result_.code = kStoppedEarly;
      result_.summary = "report not written";
    }
  }

  const OptimizeArguments& a_;
  const Job& job_;
  Console& console_;
  Options options_;
  std::vector<SeriesStep> steps_, written_;
  TetMesh input_;                           ///< of the first file
  std::vector<Index> original_of_;          ///< per vertex: that of the first file, or -1
  std::optional<std::size_t> stopped_at_;   ///< the step at which a blocked motion or an interruption ended the run
  std::optional<double> blocked_fraction_;  ///< of the step at which the motion was blocked
  bool has_moved_ = false;                  ///< at any time
  std::vector<std::string> warnings_;
  nlohmann::ordered_json entries_ = nlohmann::ordered_json::array();
  JobResult result_;
};

}  // namespace

bool is_series(const std::string& path) { return ending_of(path) == ".pvd"; }

JobResult run_series(const OptimizeArguments& arguments, const Job& job, Console& console) {
  const auto start = std::chrono::steady_clock::now();
  JobResult result;
  try {
    result = SeriesRun(arguments, job, console).run();
  } catch (const std::bad_alloc&) {
    console.error(job.input + ": out of memory");
  } catch (const std::exception& e) {
    console.error(e.what());
  }
  console.clear();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace tetune::cli

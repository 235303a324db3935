// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <new>
#include <optional>
#include <string_view>

#include "commands.hpp"
#include "console.hpp"
#include "interrupt.hpp"
#include "map_file.hpp"
#include "mesh_files.hpp"
#include "optimize_arguments.hpp"
#include "option_values.hpp"
#include "report_files.hpp"
#include "tables.hpp"

namespace tetune::cli {
namespace {

using Time = std::chrono::steady_clock;

double seconds_since(Time::time_point start) { return std::chrono::duration<double>(Time::now() - start).count(); }

/// What became of one mesh.
struct Outcome {
  int code = kNothingWritten;
  const char* what = "failed";
  Quality before, after;
  double seconds = 0;
};

/// --untangle could not repair all: exit code 1, though nothing is written.
class NotUntangled : public MeshError {
 public:
  using MeshError::MeshError;
};

/// Takes one mesh from its file to the other.
class Run {
 public:
  Run(const OptimizeArguments& arguments, const Job& job, Console& console)
      : a_(arguments), job_(job), console_(console), options_(arguments.options) {}

  Outcome run() {
    read();
    if (a_.dry_run) return tell_what_would_be_done();
    optimize_mesh();
    write();
    finish();
    return outcome_;
  }

 private:
  void read() {
    if (!job_.output.empty() && job_.output != kPipe) check_writable(job_.output);
    for (const std::string& path : {job_.report, job_.trace, job_.map}) check_folder(path);
    console_.phase("reading");
    input_ = read_input(job_.input, options_.threads);
    choose_tags(input_, job_.input, a_.tags);
    for (const std::string& w : input_.warnings) warn(w);
    const std::string name = shown_name(job_.input, false);
    if (input_.mesh.tets.empty()) throw MeshError(name + ": there is no tetrahedron in this file");
    freeze(a_.frozen, name, input_.mesh, options_);
    if (!a_.max_deviation.empty()) {
      options_.max_deviation = parse_length("--max-deviation", a_.max_deviation, input_.mesh);
    }
    need_mb_ = static_cast<double>(memory_needed(input_.mesh, options_)) / (1024 * 1024);
    if (a_.max_memory && need_mb_ > *a_.max_memory) {
      throw MeshError(
          fmt::format("{}: needs about {:.0f} MB of memory, and --max-memory allows {:.6g}; allow more, or take a "
                      "smaller mesh",
                      name, need_mb_, *a_.max_memory));
    }
  }

  /// The table needs less than the report, and takes less time.
  Quality measured() const {
    return job_.report.empty() ? quality(input_.mesh, options_.threads) : measure_all(input_.mesh, options_.threads);
  }

  /// optimize(), and what is wrong with the mesh in the file's own numbers.
  void improve(const Context& context) {
    try {
      outcome_.before = measured();
      measured_at_ = Time::now();
      report_ = optimize(input_.mesh, options_, context);
    } catch (const UntangleError& e) {
      if (e.reason == UntangleError::Reason::stopped) {
        throw NotUntangled(shown_name(job_.input, false) +
                           ": stopped before all tetrahedra were made positive, nothing was written");
      }
      fail_to_untangle(e);
    } catch (const OverlapError& e) {
      throw MeshError(shown_name(job_.input, false) + ": " + e.message(true));
    } catch (const MeshError& e) {
      const ValidationReport valid = validate(input_.mesh, options_.threads);
      throw MeshError(shown_name(job_.input, false) + ": " + (valid.ok() ? e.what() : validity_message(valid)));
    }
  }

  /// The report then lists all that the message only counts.
  [[noreturn]] void fail_to_untangle(const UntangleError& e) {
    if (!job_.report.empty() && !a_.dry_run) {
      nlohmann::ordered_json left = nlohmann::ordered_json::array();
      for (const Index t : e.left) left.push_back(t + 1);
      nlohmann::ordered_json json = report_head();
      json["warnings"] = warnings_;
      json["untangling"] = {{"inverted_or_flat", e.tangled}, {"left", left}};
      try {
        write_text(job_.report, json_text(json));
      } catch (const FileError& file_error) {
        console_.warn(file_error.what());
      }
    }
    Point3 centre{};
    for (const Index v : input_.mesh.tets[static_cast<std::size_t>(e.left.at(0))]) {
      for (std::size_t k = 0; k < 3; ++k) centre[k] += 0.25 * input_.mesh.points[static_cast<std::size_t>(v)][k];
    }
    throw NotUntangled(fmt::format("{}: {}\n  The first is near {:.6g} {:.6g} {:.6g}. No mesh was written.",
                                   shown_name(job_.input, false), e.message(true), centre[0], centre[1], centre[2]));
  }

  void warn(const std::string& text) {
    console_.warn(text);
    warnings_.push_back(text);
  }

  Outcome tell_what_would_be_done() {
    console_.phase("checking");
    const std::string counts = mesh_summary(input_.mesh);
    double load_seconds = 0;
    Context context;
    context.progress = [&](const Progress& p) {
      load_seconds = p.seconds;
      return std::string_view(p.phase) != "load";  // what comes after it would be the work
    };
    improve(context);
    std::string text = fmt::format("{}{}: nothing is written\n{}", shown_name(job_.input, false),
                                   job_.output.empty() ? "" : " -> " + shown_name(job_.output, true), counts);
    text += constraint_table(report_) + notes(report_);
    text += quality_table({"now"}, {outcome_.before});
    text += fmt::format("  memory                 about {:.0f} MB\n", need_mb_);
    if (options_.termination == Termination::relative && options_.relocation == Relocation::newton) {
      // A run takes about so many times what loading does: docs/command-line.md, "A look before the work".
      const double times = options_.effort == Effort::best ? 42 : options_.effort == Effort::fast ? 4.5 : 9;
      text += fmt::format("  time                   about {:.2g} s on {} threads\n",
                          2 * input_.seconds + times * load_seconds, report_.threads);
    }
    console_.print(text);
    outcome_.code = kDone;
    outcome_.what = "checked";
    return outcome_;
  }

  void optimize_mesh() {
    if (options_.boundary == Boundary::slide) original_ = std::make_unique<TetMesh>(input_.mesh);
    console_.phase("optimising");
    std::optional<Time::time_point> end;
    Context context;
    if (console_.watched()) {
      context.progress = [this](const Progress& p) {
        console_.update(p);
        return true;
      };
    }
    context.stop = [&] {
      interrupt::enter(interrupt::Stage::worth_writing);
      if (a_.time_limit && !end) end = end_of_work();
      late_ = late_ || (end && Time::now() >= *end);
      return late_ || interrupt::requested();
    };
    improve(context);
  }

  /// Asked when the mesh is loaded. What is left then, giving it back and writing it, takes about as long as what was
  /// done: loading it (a part of that) and reading.
  Time::time_point end_of_work() const {
    const double reserved = 0.25 * seconds_since(measured_at_) + 1.2 * input_.seconds;
    constexpr double kForever = 1e9;  // more would not fit
    const auto limit = std::chrono::duration<double>(std::clamp(*a_.time_limit - reserved, 0.0, kForever));
    return start_ + std::chrono::duration_cast<Time::duration>(limit);
  }

  void write() {
    console_.phase("writing");
    const auto start = Time::now();
    const auto warnings = write_output(job_.output, input_.binary, input_.mesh, options_.threads);
    interrupt::enter(interrupt::Stage::written);
    write_seconds_ = seconds_since(start);
    for (const std::string& w : warnings) warn(w);
    if (!job_.map.empty()) {
      write_text(job_.map, map_text(report_, input_.mesh.points.size(), input_.mesh.tets.size()));
    }
  }

  void finish() {
    outcome_.after = measured();
    const bool stopped = report_.stop == StopReason::cancelled;
    const bool met = std::all_of(report_.targets.begin(), report_.targets.end(), [](const auto& t) { return t.met(); });
    outcome_.code = stopped || !met ? kStoppedEarly : kDone;
    outcome_.what = stopped ? (late_ ? "time limit" : "interrupted") : met ? "done" : "target missed";
    // Comparing takes long, and whoever stops early is in a hurry.
    std::optional<Comparison> change;
    if (original_ && !stopped && (console_.verbosity() > 0 || !job_.report.empty())) {
      change = compare(*original_, input_.mesh, options_.threads);
    }
    if (change && options_.max_deviation > 0) {
      constexpr double kRounding = 1e-6;  // of distances, far from the origin
      deviation_ = change->mean_edge * std::max(change->new_to_old, change->old_to_new);
      kept_ = deviation_ <= (1 + kRounding) * options_.max_deviation;
      if (!kept_) {
        warn(
            fmt::format("{}: the surface is {:.3e} from the old one, and --max-deviation allows {:.3e}; list the "
                        "edges of parts that are thinner than that, or allow less",
                        shown_name(job_.input, false), deviation_, options_.max_deviation));
      }
    }
    if (!job_.report.empty()) {
      nlohmann::ordered_json json = full_report();
      json["optimization"]["stopped"] = stopped ? outcome_.what : to_string(report_.stop);
      if (change) json["surface"] = to_json(*change);
      if (change && options_.max_deviation > 0) json["surface"]["max_deviation_kept"] = kept_;
      write_text(job_.report, json_text(json));
    }
    if (!job_.trace.empty()) write_text(job_.trace, trace_csv(report_));
    console_.print(text(change));
  }

  std::string text(const std::optional<Comparison>& change) const {
    std::string text = quality_table({"before", "after"}, {outcome_.before, outcome_.after});
    const bool stopped = report_.stop == StopReason::cancelled;
    text += fmt::format(
        "  {} sweeps, {} + {} flips (2-3 + 3-2), {} larger edge removals, {} face removals, {} boundary flips, {} "
        "compound flips, {}; {} "
        "of {} vertices "
        "fixed\n",
        report_.sweeps.size(), report_.flips23, report_.flips32, report_.edge_removals, report_.face_removals,
        report_.boundary_flips, report_.compound_flips, stopped ? outcome_.what : to_string(report_.stop),
        report_.fixed_vertices, report_.vertices);
    if (report_.vertices_inserted + report_.vertices_removed > 0) {
      text += fmt::format("  {} vertices inserted, {} removed\n", report_.vertices_inserted, report_.vertices_removed);
    }
    if (report_.tets_untangled > 0) {
      text += fmt::format(
          "  {} inverted or flat tetrahedra made positive; \"before\" measures inverted ones as if they were not\n",
          report_.tets_untangled);
    }
    text += notes(report_);
    if (change) text += surface_table(*change);
    if (change && options_.max_deviation > 0) {
      text +=
          fmt::format("  --max-deviation        {:.2e}{}\n", options_.max_deviation, kept_ ? ", kept" : ", EXCEEDED");
    }
    for (const TargetReport& t : report_.targets) text += target_table(t);
    if (console_.verbosity() > 1) text += run_table(report_);
    text += fmt::format("  read {:.3f} s, optimised {:.3f} s on {}{}, written {:.3f} s: {}\n", input_.seconds,
                        report_.seconds, report_.device,
                        report_.threads > 0 ? fmt::format(" ({} threads)", report_.threads) : "", write_seconds_,
                        shown_name(job_.output, true));
    if (!report_.device_reason.empty()) {
      text += fmt::format("  on {}: {}\n", report_.device, report_.device_reason);
    }
    if (stopped) {
      text += fmt::format("  stopped early ({}): a valid mesh was written, but there was more to do\n", outcome_.what);
    }
    return text;
  }

  nlohmann::ordered_json report_head() const {
    return {{"tetune", TETUNE_VERSION},
            {"instructions", instruction_set()},
            {"input", job_.input},
            {"output", job_.output},
            {"options", to_json(options_)}};
  }
  nlohmann::ordered_json full_report() const {
    nlohmann::ordered_json json = report_head();
    json["warnings"] = warnings_;
    json["read_seconds"] = input_.seconds;
    json["write_seconds"] = write_seconds_;
    json["before"] = to_json(outcome_.before);
    json["after"] = to_json(outcome_.after);
    json["optimization"] = to_json(report_);
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
  double need_mb_ = 0;
  /// To say afterwards what became of the surface.
  std::unique_ptr<const TetMesh> original_;
  Report report_;
  bool late_ = false;
  double deviation_ = 0;  ///< a length; where it is bounded
  bool kept_ = true;
  double write_seconds_ = 0;
  Outcome outcome_;
};

/// One mesh, with its errors told.
Outcome attempt(const OptimizeArguments& a, const Job& job, Console& console) {
  interrupt::enter(interrupt::Stage::nothing);
  console.event({{"event", "start"}, {"input", job.input}, {"output", job.output}});
  Outcome outcome;
  const auto start = Time::now();
  try {
    outcome = Run(a, job, console).run();
  } catch (const std::bad_alloc&) {
    console.error(shown_name(job.input, false) + ": out of memory");
  } catch (const std::exception& e) {
    console.error(e.what());
    outcome.code = dynamic_cast<const NotUntangled*>(&e) != nullptr ? kStoppedEarly : kNothingWritten;
  }
  console.clear();
  outcome.seconds = seconds_since(start);
  nlohmann::ordered_json end = {{"event", "end"},
                                {"input", job.input},
                                {"result", outcome.what},
                                {"exit_code", outcome.code},
                                {"seconds", outcome.seconds}};
  if (outcome.after.tets > 0) {
    end["worst_angle_before_deg"] = outcome.before.dihedral_min;
    end["worst_angle_deg"] = outcome.after.dihedral_min;
  }
  console.event(end);
  return outcome;
}

/// Several meshes: one failure does not stop the others, and each has a line.
int run_all(const OptimizeArguments& a, const std::vector<Job>& jobs, Console& summary) {
  // The tables of each mesh are for those who ask for more.
  Console each(a.progress, a.verbosity > 1 || a.dry_run ? a.verbosity : std::min(a.verbosity, 1),
               a.verbosity > 1 || a.dry_run ? stdout : nullptr);
  std::size_t width = 5;
  for (const Job& job : jobs) width = std::max(width, job.input.size());
  std::string table = fmt::format("  {:<{}}{:>12}{:>12}{:>18}{:>18}{:>10}  {}\n", "mesh", width, "tetrahedra", "after",
                                  "dihedral min", "mean ratio", "time s", "result");
  if (a.verbosity < 2 && !a.dry_run) summary.print(table);
  int code = kDone;
  for (const Job& job : jobs) {
    Outcome o;
    if (interrupt::requested()) {
      o.what = "not started";
    } else {
      o = attempt(a, job, each);
    }
    code = std::max(code, o.code);
    std::string line = fmt::format("  {:<{}}", job.input, width);
    if (o.after.tets > 0) {
      line +=
          fmt::format("{:>12}{:>12}{:>8.2f} -> {:>6.2f}{:>8.4f} -> {:>6.4f}{:>10.2f}", o.before.tets, o.after.tets,
                      o.before.dihedral_min, o.after.dihedral_min, o.before.mean_ratio, o.after.mean_ratio, o.seconds);
    } else {
      line += fmt::format("{:>70}", "");
    }
    line += fmt::format("  {}\n", o.what);
    if (a.verbosity < 2 && !a.dry_run) summary.print(line);
    table += line;
  }
  if (a.verbosity > 1 || a.dry_run) summary.print(table);
  return code;
}

int run(const CLI::App& command, OptimizeArguments& a) {
  const std::vector<Job> jobs = settle(command, a);
  if (a.print_options) {
    for (const Frozen& f : a.frozen) {
      if (f.name.empty()) (f.region ? a.options.frozen_regions : a.options.frozen_patches).push_back(f.tag);
    }
    nlohmann::ordered_json json = to_json(a.options);
    if (!a.max_deviation.empty()) json["max_deviation"] = a.max_deviation;
    if (!a.freeze.empty()) json["freeze"] = a.freeze;
    if (a.time_limit) json["time_limit_seconds"] = *a.time_limit;
    if (a.max_memory) json["max_memory_mb"] = *a.max_memory;
    fmt::print("{}", json_text(json));
    return kDone;
  }
  const MadeFolder folder(a.names.output, a.dry_run);
  const bool to_pipe = jobs[0].output == kPipe;
  Console console(a.progress, a.verbosity, !to_pipe ? stdout : a.progress == ProgressMode::json ? nullptr : stderr);
  interrupt::install(console.json());
  return jobs.size() == 1 ? attempt(a, jobs[0], console).code : run_all(a, jobs, console);
}

}  // namespace

void add_optimize(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<OptimizeArguments>();
  CLI::App* c = app.add_subcommand("optimize", "Improve a mesh, or several.");
  define(*c, *a);
  c->callback([c, a, &exit_code] { exit_code = run(*c, *a); });
}

}  // namespace tetune::cli

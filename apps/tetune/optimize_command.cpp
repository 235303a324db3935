// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "commands.hpp"
#include "geometry_files.hpp"
#include "interrupt.hpp"
#include "move_series.hpp"
#include "move_targets.hpp"
#include "optimize_run.hpp"
#include "option_flags.hpp"
#include "report_files.hpp"

namespace tetune::cli {
namespace {

std::string table_line(const Job& job, const JobResult& o, std::size_t width) {
  std::string line = fmt::format("  {:<{}}", job.input, width);
  if (o.after.tets > 0) {
    line +=
        fmt::format("{:>12}{:>12}{:>8.2f} -> {:>6.2f}{:>8.4f} -> {:>6.4f}{:>10.2f}", o.before.tets, o.after.tets,
                    o.before.dihedral_min, o.after.dihedral_min, o.before.mean_ratio, o.after.mean_ratio, o.seconds);
  } else {
    line += fmt::format("{:>70}", "");
  }
  return line + fmt::format("  {}\n", o.summary);
}

/// Prints the event at the end of a job, in JSON mode only.
void print_end(const Job& job, const JobResult& result, Console& console) {
  nlohmann::ordered_json end = end_event(job.input, result.summary, result.code, result.seconds);
  if (result.after.tets > 0) {
    end["worst_angle_before_deg"] = result.before.dihedral_min;
    end["worst_angle_deg"] = result.after.dihedral_min;
  }
  console.event(end);
}

/// run_job() or run_series().
JobResult run_one(const OptimizeArguments& a, const Job& job, Console& console) {
  const bool moves_series = a.move && (is_series(job.input) || is_series(job.output));
  interrupt::begin(job.input, moves_series ? interrupt::JobOutput::series : interrupt::JobOutput::mesh);
  console.event({{"event", "start"}, {"input", job.input}, {"output", job.output}});
  const JobResult result = moves_series ? run_series(a, job, console) : run_job(a, job, console);
  print_end(job, result, console);
  return result;
}

/// Several meshes: each has one line in a table, and the failure of one does not stop the others.
int run_all(const OptimizeArguments& a, const std::vector<Job>& jobs, Console& summary) {
  // The tables of each mesh are printed only with -v 2 or more; the lines then come after all of them.
  const bool has_details = a.verbosity > 1 || a.dry_run;
  Console each(a.progress, has_details ? a.verbosity : std::min(a.verbosity, 1), has_details ? stdout : nullptr);
  std::size_t width = 5;
  for (const Job& job : jobs) width = std::max(width, job.input.size());
  std::string table = fmt::format("  {:<{}}{:>12}{:>12}{:>18}{:>18}{:>10}  {}\n", "mesh", width, "tetrahedra", "after",
                                  "dihedral min", "mean ratio", "time s", "result");
  if (!has_details) summary.print(table);
  int code = kDone;
  for (const Job& job : jobs) {
    JobResult o;
    if (interrupt::requested()) {
      o.summary = "not started";
      print_end(job, o, each);
    } else {
      o = run_one(a, job, each);
    }
    code = std::max(code, o.code);
    const std::string line = table_line(job, o, width);
    if (!has_details) summary.print(line);
    table += line;
  }
  if (has_details) summary.print(table);
  return code;
}

void print_options(OptimizeArguments& a) {
  for (const TagOrName& f : a.frozen) {
    if (f.name.empty()) (f.is_region() ? a.options.frozen_regions : a.options.frozen_patches).push_back(f.tag);
  }
  nlohmann::ordered_json json = to_json(a.options);
  if (!a.max_deviation.empty()) json["max_deviation"] = a.max_deviation;
  if (!a.freeze.empty()) json["freeze"] = a.freeze;
  if (a.time_limit) json["time_limit_seconds"] = *a.time_limit;
  if (a.max_memory) json["max_memory_mb"] = *a.max_memory;
  fmt::print("{}", json_text(json));
}

int run(const CLI::App& command, OptimizeArguments& a) {
  const bool has_series = std::any_of(a.files.begin(), a.files.end(), is_series);
  if (a.move && !a.print_options) check_move_arguments(*a.move, has_series);
  if (has_series && !a.move) throw OptionError("time series (.pvd) are for `tetune move`; name one of their meshes");
  const std::vector<Job> jobs = resolve_jobs(command, a);
  check_geometry_arguments(command, a);
  const bool to_pipe = !jobs.empty() && jobs[0].output == kPipe;
  Console console(a.progress, a.verbosity, !to_pipe ? stdout : a.progress == ProgressMode::json ? nullptr : stderr);
  for (const std::string& w : a.warnings) console.warn(w);
  if (a.print_options) {
    print_options(a);
    return kDone;
  }
  const OutputFolder folder(a.names.output, a.dry_run);
  interrupt::install(console.json());
  return jobs.size() == 1 ? run_one(a, jobs[0], console).code : run_all(a, jobs, console);
}

}  // namespace

void add_optimize(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<OptimizeArguments>();
  CLI::App* c = app.add_subcommand("optimize", "Improve a mesh, or several.");
  define_geometry_to_slide_on(*c, a->geometry);
  define_arguments(*c, *a);
  c->callback([c, a, &exit_code] { exit_code = run(*c, *a); });
}

void add_move(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<OptimizeArguments>();
  CLI::App* c = app.add_subcommand(
      "move", "Move vertices of a mesh to prescribed positions; the others follow, and the mesh is improved.");
  define_move_arguments(*c, *a);
  define_arguments(*c, *a);
  c->callback([c, a, &exit_code] { exit_code = run(*c, *a); });
}

}  // namespace tetune::cli

// SPDX-License-Identifier: Apache-2.0
#include "optimize_arguments.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "criteria_file.hpp"
#include "definitions.hpp"
#include "option_flags.hpp"
#include "python_package.hpp"
#include "system/path.hpp"
#include "tetune/error.hpp"
#include "tetune/io.hpp"

namespace tetune::cli {
namespace {

constexpr const char* kSurface = "Surface and constraints";
constexpr const char* kTargets = "Targets";
constexpr const char* kResources = "Resources";
constexpr const char* kOutput = "Output";

CLI::Validator is_positive() {
  const auto check = [](std::string& word) -> std::string {
    double value = 0;
    const bool ok = CLI::detail::lexical_cast(word, value) && value > 0 && std::isfinite(value);
    return ok ? "" : fmt::format("'{}' is not a positive number", word);
  };
  return {check, ""};
}

void define_files(CLI::App& c, OptimizeArguments& a) {
  c.add_option("files", a.files,
               "Mesh to read: " + readable_endings() + (c.get_name() == "move" ? ", time series (.pvd)" : "") +
                   "; or - for the standard input (MEDIT). A second name is that of the mesh to write, which must not "
                   "exist, unless -o is given: then any number of meshes is read")
      ->option_text("INPUT [OUTPUT]");
  c.add_option(
       "-o,--output", a.names.output,
       "Mesh to write: " + writable_endings() +
           "; or - for the standard output (MEDIT, binary if the input is). A file that exists is replaced. For "
           "several meshes: a folder, with / at its end, which is made if necessary; or a name with {}, which stands "
           "for the name of each mesh without ending")
      ->option_text("FILE");
  c.add_flag("--dry-run", a.dry_run,
             "Read and check the mesh, print how it is constrained and estimates of memory and time, write nothing");
  c.add_flag("--print-options", a.print_options, "Print the options as JSON and exit");
}

void define_periodic(CLI::App& c, OptimizeArguments& a) {
  c.add_option("--periodic", a.periodic,
               "The mesh is a box, periodic along these axes: vertices of opposite faces, which must match, move "
               "together. $Periodic of a Gmsh file is followed without this option")
      ->option_text("x,y,z")
      ->delimiter(',')
      ->check(is_word({"x", "y", "z"}))
      ->group(kSurface);
  c.add_option("--periodic-map", a.periodic_map,
               "Text file of vertices that move together: a line \"translation X Y Z\", and then a line \"VERTEX "
               "MASTER\" for each pair that it maps from the master to the vertex, in numbers from 1")
      ->option_text("FILE")
      ->group(kSurface);
}

/// Those of the library's options, in the order of its table, and those that stand for several of them.
void define_options(CLI::App& c, OptimizeArguments& a) {
  for (const OptionInfo& option : option_table()) {
    const std::string flag = flag_of(option);
    if (std::string_view(option.name) == "max_deviation") {
      c.add_option(flag, a.max_deviation,
                   with_flags(option.text) + ". A length, or a part of the bounding box's diagonal as 0.1%")
          ->option_text("LENGTH|PERCENT")
          ->group(option.group);
      c.add_option("--tags", a.tags, kTagsHelp)->option_text("NAME")->group(kSurface);
      c.add_option("--freeze", a.freeze,
                   "Regions and patches that do not change, by their tags or the names of their groups: "
                   "tag=1,2,patch=inlet")
          ->option_text("tag=N|NAME,...,patch=N|NAME,...")
          ->group(kSurface);
      define_periodic(c, a);
    } else if (std::string_view(option.name) == "only_below") {
      c.add_option(flag, a.only_below,
                   "Only tetrahedra with a dihedral angle below this, and those around them, may change; all others "
                   "stay bit for bit, and in their order. For another measure of `tetune info`: mean_ratio=0.2, "
                   "radius_ratio=5. May be repeated: tetrahedra that miss one of the limits")
          ->option_text("DEG|MEASURE=Q")
          ->allow_extra_args(false)
          ->group(option.group);
    } else if (!flag.empty()) {
      define_option(c, option, a.options, a.warnings);
    }
  }
}

void define_targets(CLI::App& c, OptimizeArguments& a) {
  c.add_option("--target-dihedral", a.target_dihedral,
               "Smallest dihedral angle that every element should have. It does not change the result: if an element "
               "misses it, the exit code is 1, and the output lists the worst ones and what constrains them")
      ->option_text("DEG")
      ->group(kTargets);
  c.add_option("--target-quality", a.target_quality,
               "As --target-dihedral, for any measure of `tetune info`: mean_ratio=0.2, or radius_ratio=5. May be "
               "repeated")
      ->option_text("MEASURE=Q")
      ->allow_extra_args(false)
      ->group(kTargets);
}

void define_criteria(CLI::App& c, OptimizeArguments& a) {
  const std::string action =
      c.get_name() == "move" ? "Judge the result by" : "Optimize towards, and judge the result by,";
  c.add_option("--criteria", a.criteria_name, criteria_help(action))->option_text("NAME|FILE")->group(kTargets);
}

void define_limits(CLI::App& c, OptimizeArguments& a) {
  c.add_option("-m,--max-memory", a.max_memory,
               "Refuse a mesh that needs more memory than this (1 MB = 1024 * 1024 bytes)")
      ->check(is_positive())
      ->option_text("MB")
      ->group(kResources);
  c.add_option("--time-limit", a.time_limit,
               "Read, improve and write each mesh within about this time; exit code 1 if the run was stopped early")
      ->check(is_positive())
      ->option_text("SECONDS")
      ->group(kResources);
}

void define_output(CLI::App& c, OptimizeArguments& a) {
  c.add_option("--report", a.names.report, "Write all figures of the run to this file, as JSON")
      ->option_text("FILE.json")
      ->group(kOutput);
  // The Python package runs this program with the variable set, and writes the page afterwards.
  const auto set_page = [&a](const std::string& name) {
    const char* data = std::getenv("TETUNE_PAGE_DATA");
    if (data == nullptr || *data == '\0') need_python("--report-html");
    a.names.page = name;
    a.page_data = data;
  };
  c.add_option_function<std::string>(
       "--report-html", set_page, "Write one HTML page that shows the mesh before and after (needs the Python package)")
      ->option_text("FILE.html")
      ->group(kOutput);
  c.add_option("--trace", a.names.trace, "Write one line per sweep and flip pass to this file, as CSV")
      ->option_text("FILE.csv")
      ->group(kOutput);
  c.add_option("--map", a.names.map,
               "Write the correspondence between old and new vertices and tetrahedra to this file, as text")
      ->option_text("FILE")
      ->group(kOutput);
  const auto set_progress = [&a](const std::string& word) {
    a.progress = word == "json" ? ProgressMode::json : word == "none" ? ProgressMode::none : ProgressMode::automatic;
  };
  c.add_option_function<std::string>("--progress", set_progress,
                                     "auto: one updated line on a terminal; none; json: one JSON object per line on "
                                     "the standard error")
      ->check(is_word({"auto", "none", "json"}))
      ->default_str("auto")
      ->group(kOutput);
  auto* v = c.add_option("-v", a.verbosity,
                         "-1: only errors; 0: and warnings; 1: and the quality before and after; 2 to 10: and each "
                         "sweep and flip pass, and times")
                ->check(CLI::Range(-1, 10))
                ->capture_default_str()
                ->group(kOutput);
  c.add_flag("--quiet", a.quiet, "Only errors and warnings: -v 0")->excludes(v)->group(kOutput);
}

/// Returns the inputs, and takes the output from the files where it is the second of two.
std::vector<std::string> find_inputs(OptimizeArguments& a) {
  if (a.files.empty()) throw OptionError("no input: name a mesh to read, or - for the standard input");
  std::vector<std::string> inputs = a.files;
  // With --dry-run both files may be inputs; one that does not exist can only be an output.
  std::error_code ignored;
  const bool both = a.dry_run && inputs.size() == 2 && std::filesystem::exists(path_of(inputs.back()), ignored);
  if (a.names.output.empty() && inputs.size() == 2 && !both) {
    a.names.output = inputs.back();
    inputs.pop_back();
  }
  if (a.names.output.empty() && inputs.size() > 2 && !a.dry_run) {
    throw OptionError("no output: with several meshes, name a folder with -o FOLDER/, or names with -o new_{}.mesh");
  }
  if (a.names.output.empty() && !a.dry_run) {
    throw OptionError("no output: name it after the input or with -o, or write nothing with --dry-run");
  }
  return inputs;
}

/// The files besides the meshes that the options name, and that are read.
std::vector<std::string> other_inputs(const OptimizeArguments& a) {
  std::vector<std::string> files{a.periodic_map, a.criteria_name, a.geometry.file};
  if (a.move) files.insert(files.end(), a.move->to.begin(), a.move->to.end());
  std::erase(files, "");
  return files;
}

/// The page is made of the files of one mesh.
void check_page(const std::vector<std::string>& inputs, OptimizeArguments& a) {
  if (a.names.page.empty()) return;
  if (inputs.size() > 1) {
    throw OptionError("--report-html: the page shows one mesh, and there are several; name one, or use --report");
  }
  const auto is_mesh_file = [](const std::string& name) { return name != kPipe && ending_of(name) != ".pvd"; };
  if (!is_mesh_file(inputs[0]) || !is_mesh_file(a.names.output)) {
    throw OptionError(
        "--report-html: the page is made of the files of one mesh, not of the standard input or output or a time "
        "series; give names of files");
  }
  if (a.dry_run) a.warnings.emplace_back("--report-html has no effect with --dry-run");
}

void check(const CLI::App& command, OptimizeArguments& a) {
  try {
    check_options(a.options);
  } catch (const OptionError& e) {
    throw OptionError(with_flags(e.what()));
  }
  Options options = a.options;
  if (!a.max_deviation.empty()) {
    a.deviation_bound = parse_length("--max-deviation", a.max_deviation);
    options.max_deviation = a.deviation_bound->value;  // only whether it is 0 matters here
  }
  for (std::string& text : ineffective_flags(command, options)) a.warnings.push_back(std::move(text));
  if (a.options.trace_angles && a.names.report.empty() && a.names.page.empty()) {
    a.warnings.emplace_back("--trace-angles has no effect without --report");
  }
}

}  // namespace

void define_arguments(CLI::App& command, OptimizeArguments& arguments) {
  define_files(command, arguments);
  define_options(command, arguments);
  define_targets(command, arguments);
  define_criteria(command, arguments);
  define_limits(command, arguments);
  define_output(command, arguments);
  check_values(command);
}

std::vector<Job> resolve_jobs(const CLI::App& command, OptimizeArguments& a) {
  for (const std::string& text : a.freeze) parse_freeze(text, a.frozen);
  if (a.target_dihedral) a.options.targets.push_back({Measure::min_dihedral, *a.target_dihedral});
  for (const std::string& text : a.target_quality) {
    a.options.targets.push_back(parse_bound("--target-quality", text, std::nullopt));
  }
  for (const std::string& text : a.only_below) {
    a.options.only_below.push_back(parse_bound("--only-below", text, Measure::min_dihedral));
  }
  if (!a.criteria_name.empty()) a.criteria = read_criteria(a.criteria_name);
  check(command, a);
  if (a.quiet) a.verbosity = 0;
  if (a.print_options) return {};
  a.replaces = !a.names.output.empty();
  if (!a.names.page.empty()) a.options.trace_angles = true;
  const std::vector<std::string> inputs = find_inputs(a);
  check_page(inputs, a);
  std::vector<Job> jobs = make_jobs(inputs, other_inputs(a), a.names);
  if (!a.replaces && !a.dry_run) refuse_existing(jobs.front().output);
  return jobs;
}

}  // namespace tetune::cli

// SPDX-License-Identifier: Apache-2.0
#include "optimize_arguments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "commands.hpp"
#include "definitions.hpp"
#include "option_values.hpp"
#include "tetune/error.hpp"
#include "tetune/io.hpp"

namespace tetune::cli {
namespace {

/// The words for the values of an option, in the order in which they are offered.
template <class T>
using Names = std::vector<std::pair<std::string, T>>;

const Names<Boundary> kBoundaries{
    {"preserve", Boundary::preserve}, {"slide", Boundary::slide}, {"fixed", Boundary::fixed}};
const Names<Energy> kEnergies{{"shape", Energy::shape}, {"harmonic", Energy::harmonic}};
const Names<Effort> kEfforts{{"fast", Effort::fast}, {"default", Effort::standard}, {"best", Effort::best}};
const Names<Relocation> kRelocations{{"newton", Relocation::newton}, {"gradient", Relocation::gradient}};
const Names<Termination> kTerminations{{"relative", Termination::relative}, {"paper", Termination::paper}};
const Names<Device> kDevices{{"auto", Device::automatic}, {"cpu", Device::cpu}, {"cuda", Device::cuda}};
const Names<ProgressMode> kProgressModes{
    {"auto", ProgressMode::automatic}, {"none", ProgressMode::none}, {"json", ProgressMode::json}};

template <class T>
std::string name_of(const Names<T>& names, T value) {
  for (const auto& [name, v] : names) {
    if (v == value) return name;
  }
  return "";
}

/// Takes one of the names, and no number as CLI::CheckedTransformer does.
template <class T>
CLI::Validator one_of(const Names<T>& names) {
  std::string known;
  for (const auto& [name, value] : names) known += (known.empty() ? "" : ",") + name;
  const auto transform = [&names, known](std::string& word) -> std::string {
    for (const auto& [name, value] : names) {
      if (name != word) continue;
      word = std::to_string(static_cast<int>(value));
      return "";
    }
    return fmt::format("'{}' is not one of {}", word, known);
  };
  return CLI::Validator(transform, "{" + known + "}");
}

CLI::Validator positive() {
  const auto check = [](std::string& word) -> std::string {
    double value = 0;
    const bool ok = CLI::detail::lexical_cast(word, value) && value > 0 && std::isfinite(value);
    return ok ? "" : fmt::format("'{}' is not a positive number", word);
  };
  return CLI::Validator(check, "");
}

/// Options that cannot take effect together with others are refused rather than ignored.
void refuse_ineffective(const CLI::App& command, const OptimizeArguments& a) {
  if (a.options.max_iterations == 0) {
    for (const char* name : {"--relocation", "--termination", "--effort"}) {
      if (command.count(name) > 0)
        throw OptionError(fmt::format("{} has no effect with --max-iterations 0; drop one of them", name));
    }
  }
  if (a.options.boundary != Boundary::slide) {
    for (const auto& [name, alias] :
         {std::pair("--feature-angle", "-ar, -nr"), std::pair("--max-deviation", "-hausd")}) {
      if (command.count(name) > 0) {
        throw OptionError(
            fmt::format("{} (Mmg's {}) has no effect without --boundary slide; add it, or drop {}", name, alias, name));
      }
    }
  }
  if (command.count("--boundary-flips") > 0) {
    const char* other = a.options.boundary == Boundary::fixed ? "--boundary fixed"
                        : !a.max_deviation.empty()            ? "--max-deviation"
                        : !a.options.flips                    ? "--no-flips"
                        : a.options.max_ring == 3             ? "--max-ring 3"
                        : a.options.max_iterations == 0       ? "--max-iterations 0"
                                                              : nullptr;
    if (other != nullptr) {
      throw OptionError(fmt::format("{} has no effect with {}; drop one of them",
                                    a.options.boundary_flips ? "--boundary-flips" : "--no-boundary-flips", other));
    }
  }
  if (!a.options.flips && command.count("--max-ring") > 0) {
    throw OptionError("--max-ring has no effect with --no-flips; drop one of them");
  }
  if (!a.options.flips && a.options.max_iterations == 0) {
    throw OptionError("with --no-flips and --max-iterations 0 there is nothing to do; drop one of them");
  }
  if (a.options.termination == Termination::paper && command.count("--effort") > 0) {
    throw OptionError("--effort has no effect with --termination paper; drop one of them");
  }
  if (a.options.energy == Energy::harmonic && a.options.effort == Effort::best) {
    throw OptionError("--effort best has no effect with --energy harmonic; drop one of them");
  }
  if (a.options.trace_angles && a.names.report.empty()) {
    throw OptionError("--trace-angles has no effect without --report; add it, or drop --trace-angles");
  }
  if (a.options.device == Device::cuda && command.count("--threads") > 0) {
    throw OptionError("--threads has no effect with --device cuda; drop one of them");
  }
}

/// Inputs, and the output where it is the second of two free words.
std::vector<std::string> find_inputs(OptimizeArguments& a) {
  if (a.files.empty()) throw OptionError("no input: name a mesh to read, or - for the standard input");
  std::vector<std::string> inputs = a.files;
  // A look at two meshes: one that is not there can only be an output.
  std::error_code ignored;
  const bool both = a.dry_run && inputs.size() == 2 && std::filesystem::exists(inputs.back(), ignored);
  if (a.names.output.empty() && inputs.size() == 2 && !both) {
    a.names.output = inputs.back();
    inputs.pop_back();
  }
  if (a.names.output.empty() && inputs.size() > 2 && !a.dry_run) {
    throw OptionError("no output: with several meshes, name a folder with -o FOLDER/, or names with -o new_{}.mesh");
  }
  if (a.names.output.empty() && !a.dry_run) {
    throw OptionError("no output: name it after the input or with -o, or look without writing with --dry-run");
  }
  return inputs;
}

}  // namespace

void define(CLI::App& c, OptimizeArguments& a) {
  c.add_option("files", a.files,
               "Mesh to read: " + readable_endings() +
                   "; or - for the standard input (MEDIT); then the mesh to write, unless -o names it. With -o, any "
                   "number of meshes to read: use it with names as *.mesh, of which there may be two")
      ->option_text("INPUT [OUTPUT]");
  c.add_option(
       "-o,--output", a.names.output,
       "Mesh to write: " + writable_endings() +
           "; or - for the standard output (MEDIT text, or binary where the input is). For several meshes a folder "
           "with / at its end, made if it is not there, or a name in which {} is the name of each without its ending")
      ->option_text("FILE");
  c.add_option("--boundary", a.options.boundary,
               "preserve: vertices move within the surface's planes and straight lines, the surface stays as it is; "
               "slide: they move on the input surface and along its features, the surface follows it closely; "
               "fixed: none moves")
      ->transform(one_of(kBoundaries))
      ->default_str("preserve");
  c.add_option(
       "--feature-angle", a.options.feature_angle,
       "With --boundary slide: edges where the surface turns by more degrees are features, which vertices do not "
       "leave; above 0, up to 180: none")
      ->check(CLI::Range(0.0, 180.0))
      ->capture_default_str();
  c.add_option(
       "--max-deviation", a.max_deviation,
       "With --boundary slide: most distance of the new surface from the old one and of the old from the new; a "
       "length, or a part of the bounding box's diagonal as 0.1%")
      ->option_text("LENGTH|PERCENT");
  c.add_option("--tags", a.tags, kTagsHelp)->option_text("NAME");
  c.add_option("--freeze", a.freeze,
               "Regions and patches to keep as they are to the last bit, by their tags or the names of their groups: "
               "tag=1,2,patch=inlet")
      ->option_text("tag=N|NAME,...,patch=N|NAME,...");
  c.add_flag("--open-boundaries,!--no-open-boundaries", a.options.open_boundaries,
             "Tagged triangles with the same region on both sides stay faces of the mesh (the default), or are dropped")
      ->capture_default_str();
  c.add_option("--energy", a.options.energy,
               "shape: scale-free, small elements count as much as large ones; harmonic: sum of eta, as in the paper")
      ->transform(one_of(kEnergies))
      ->default_str("shape");
  c.add_option(
       "--effort", a.options.effort,
       "fast: look for flips once, and stop when a sweep lowers the energy by less than 2e-2 of it; default: 2e-3, "
       "then work on the worst elements and the smallest dihedral angles alone; best: 1e-4, then more of that, and "
       "vertices are inserted and removed there")
      ->transform(one_of(kEfforts))
      ->default_str("default");
  c.add_flag("--keep-vertices", a.options.keep_vertices,
             "With --effort best: no vertex is inserted or removed, those there are moved alone (as with the others)");
  c.add_flag("--untangle", a.options.untangle,
             "Make inverted and flat tetrahedra positive first, instead of refusing them");
  c.add_flag("--flips,!--no-flips", a.options.flips,
             "Edges and faces are flipped (the default), or vertices moved alone")
      ->capture_default_str();
  c.add_option("--relocation", a.options.relocation,
               "newton: over-relaxed Newton steps; gradient: as in the paper, slower")
      ->transform(one_of(kRelocations))
      ->default_str("newton");
  c.add_option("--termination", a.options.termination,
               "relative: stop when a sweep lowers the energy by little, as --effort says; paper: conditions C1 to C3")
      ->transform(one_of(kTerminations))
      ->default_str("relative");
  c.add_option("--max-iterations", a.options.max_iterations, "Most relocation sweeps; 0: flips alone")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  c.add_option("--max-ring", a.options.max_ring,
               "Largest ring of tetrahedra around an edge that flips remove or make; 3: 3-2 and 2-3 flips alone, as in "
               "the paper")
      ->check(CLI::Range(3, 7))
      ->capture_default_str();
  c.add_flag("--boundary-flips,!--no-boundary-flips", a.options.boundary_flips,
             "Edges between coplanar triangles of one patch of the boundary, or of an interface, may be flipped (the "
             "default), or stay")
      ->capture_default_str();
  c.add_option("--target-dihedral", a.target_dihedral,
               "Smallest dihedral angle that every element is to have. It changes nothing in the optimisation: if one "
               "misses it, the exit code is 1 and the output says which ones, and what constraint holds them")
      ->option_text("DEG");
  c.add_option(
       "--target-quality", a.target_quality,
       "The same for any measure of `tetune info`, for example 0.2 mean_ratio or 5 radius_ratio; may be repeated")
      ->option_text("Q MEASURE")
      ->allow_extra_args(false);
  c.add_option("--threads", a.options.threads, "CPU threads; 0: all. The result is the same for any number")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  c.add_option("--device", a.options.device,
               "Where to compute; auto: on a GPU from a million tetrahedra on, where there is one with enough memory")
      ->transform(one_of(kDevices))
      ->default_str("cpu");
  c.add_option("-m,--max-memory", a.max_memory,
               "Refuse a mesh for which more than so many MB (of 1024 * 1024 bytes) of memory would be needed")
      ->check(positive())
      ->option_text("MB");
  c.add_option(
       "--time-limit", a.time_limit,
       "Stop when it is time to write, so that a mesh is read, improved and written in about so many seconds; exit "
       "code 1 if there was more to do")
      ->check(positive())
      ->option_text("SECONDS");
  c.add_option("--report", a.names.report, "Write all figures of the run to this file, as JSON")
      ->option_text("FILE.json");
  c.add_option_function<std::string>(
       "--report-html", [](const std::string&) { need_python("--report-html"); },
       "Write one HTML page that shows the mesh before and after (needs the Python package)")
      ->option_text("FILE.html");
  c.add_flag(
      "--trace-angles", a.options.trace_angles,
      "Measure the smallest dihedral angle after each sweep and round, for --report; takes a twelfth of the time");
  c.add_option("--trace", a.names.trace, "Write one line for each sweep and flip pass to this file, as CSV")
      ->option_text("FILE.csv");
  c.add_option("--map", a.names.map, "Write which vertex and tetrahedron became which to this file, as text")
      ->option_text("FILE");
  c.add_flag(
      "--dry-run", a.dry_run,
      "Read and check the mesh, and say what constrains it and about what memory and time it takes; write nothing");
  c.add_flag("--print-options", a.print_options, "Print the options as they are in force, as JSON, and do nothing");
  c.add_option(
       "--progress", a.progress,
       "auto: a line that follows the work, on a terminal; none; json: one JSON object a line on the standard error")
      ->transform(one_of(kProgressModes))
      ->default_str("auto");
  auto* v =
      c.add_option(
           "-v", a.verbosity,
           "-1: errors alone; 0: these and warnings; 1: before and after; 2 to 10: each sweep and flip pass, and times")
          ->check(CLI::Range(-1, 10))
          ->capture_default_str();
  c.add_flag("--quiet", a.quiet, "Warnings and errors alone: -v 0")->excludes(v);
  for (const auto& [group, names] : std::map<std::string, std::vector<const char*>>{
           {"Surface and constraints",
            {"--boundary", "--feature-angle", "--max-deviation", "--tags", "--freeze", "--open-boundaries",
             "--boundary-flips"}},
           {"Method",
            {"--effort", "--keep-vertices", "--untangle", "--flips", "--energy", "--relocation", "--termination",
             "--max-iterations", "--max-ring"}},
           {"Targets", {"--target-dihedral", "--target-quality"}},
           {"Resources", {"--threads", "--device", "--max-memory", "--time-limit"}}}) {
    for (const char* name : names) c.get_option(name)->group(group);
  }
  refuse_empty_values(c);
}

std::vector<Job> settle(const CLI::App& command, OptimizeArguments& a) {
  refuse_ineffective(command, a);
  for (const std::string& text : a.freeze) parse_freeze(text, a.frozen);
  if (a.target_dihedral) a.options.targets.push_back({Measure::min_dihedral, *a.target_dihedral});
  for (const auto& [value, name] : a.target_quality) {
    a.options.targets.push_back({parse_measure("--target-quality", name), value});
  }
  if (a.quiet) a.verbosity = 0;
  if (a.print_options) return {};
  return make_jobs(find_inputs(a), a.names);
}

nlohmann::ordered_json to_json(const Options& o) {
  nlohmann::ordered_json targets = nlohmann::ordered_json::array();
  for (const Target& t : o.targets) targets.push_back({{"measure", to_string(t.measure)}, {"value", t.value}});
  return {{"boundary", name_of(kBoundaries, o.boundary)},
          {"energy", name_of(kEnergies, o.energy)},
          {"effort", name_of(kEfforts, o.effort)},
          {"keep_vertices", o.keep_vertices},
          {"untangle", o.untangle},
          {"feature_angle_deg", o.feature_angle},
          {"max_deviation", o.max_deviation},
          {"open_boundaries", o.open_boundaries},
          {"frozen_regions", o.frozen_regions},
          {"frozen_patches", o.frozen_patches},
          {"relocation", name_of(kRelocations, o.relocation)},
          {"termination", name_of(kTerminations, o.termination)},
          {"device", name_of(kDevices, o.device)},
          {"max_iterations", o.max_iterations},
          {"flips", o.flips},
          {"max_ring", o.max_ring},
          {"boundary_flips", o.boundary_flips},
          {"targets", targets},
          {"threads", o.threads}};
}

}  // namespace tetune::cli

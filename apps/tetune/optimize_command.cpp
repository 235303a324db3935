// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "option_values.hpp"
#include "progress_line.hpp"
#include "report_files.hpp"
#include "tables.hpp"

namespace tetune::cli {
namespace {

struct Arguments {
  std::string input, output, report, trace, max_deviation;
  std::vector<std::string> freeze;
  std::optional<double> target_dihedral;
  std::vector<std::pair<double, std::string>> target_quality;
  Options options;
  int verbosity = 1;
  bool quiet = false;
};

const std::map<std::string, Boundary> kBoundaries{
    {"preserve", Boundary::preserve}, {"slide", Boundary::slide}, {"fixed", Boundary::fixed}};
const std::map<std::string, Energy> kEnergies{{"shape", Energy::shape}, {"harmonic", Energy::harmonic}};
const std::map<std::string, Effort> kEfforts{
    {"fast", Effort::fast}, {"default", Effort::standard}, {"best", Effort::best}};
const std::map<std::string, Relocation> kRelocations{{"newton", Relocation::newton},
                                                     {"gradient", Relocation::gradient}};
const std::map<std::string, Termination> kTerminations{{"relative", Termination::relative},
                                                       {"paper", Termination::paper}};
const std::map<std::string, Device> kDevices{{"auto", Device::automatic}, {"cpu", Device::cpu}, {"cuda", Device::cuda}};

template <class T>
std::string name_of(const std::map<std::string, T>& names, T value) {
  for (const auto& [name, v] : names) {
    if (v == value) return name;
  }
  return "";
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Options that cannot take effect together with others are refused rather than ignored.
void refuse_ineffective(const CLI::App& command, const Arguments& a) {
  if (a.options.max_iterations == 0) {
    for (const char* name : {"--relocation", "--termination", "--effort"}) {
      if (command.count(name) > 0)
        throw OptionError(fmt::format("{} has no effect with --max-iterations 0; drop one of them", name));
    }
  }
  if (a.options.boundary != Boundary::slide) {
    for (const char* name : {"--feature-angle", "--max-deviation"}) {
      if (command.count(name) > 0)
        throw OptionError(fmt::format("{} has no effect without --boundary slide; add it, or drop {}", name, name));
    }
  }
  if (command.count("--boundary-flips") > 0) {
    const char* other = a.options.boundary == Boundary::fixed ? "--boundary fixed"
                        : !a.max_deviation.empty()            ? "--max-deviation"
                        : a.options.max_ring == 3             ? "--max-ring 3"
                        : a.options.max_iterations == 0       ? "--max-iterations 0"
                                                              : nullptr;
    if (other != nullptr) {
      throw OptionError(fmt::format("{} has no effect with {}; drop one of them",
                                    a.options.boundary_flips ? "--boundary-flips" : "--no-boundary-flips", other));
    }
  }
  if (a.options.termination == Termination::paper && command.count("--effort") > 0) {
    throw OptionError("--effort has no effect with --termination paper; drop one of them");
  }
  if (a.options.energy == Energy::harmonic && a.options.effort == Effort::best) {
    throw OptionError("--effort best has no effect with --energy harmonic; drop one of them");
  }
  if (a.options.keep_vertices && a.options.effort != Effort::best) {
    throw OptionError("--keep-vertices has no effect without --effort best: vertices are kept; drop it, or add that");
  }
  if (a.options.device == Device::cuda && command.count("--threads") > 0) {
    throw OptionError("--threads has no effect with --device cuda; drop one of them");
  }
}

nlohmann::ordered_json full_report(const Arguments& a, const Quality& before, const Quality& after,
                                   const Report& report, double read_seconds, double write_seconds) {
  nlohmann::ordered_json targets = nlohmann::ordered_json::array();
  for (const Target& t : a.options.targets) targets.push_back({{"measure", to_string(t.measure)}, {"value", t.value}});
  return {{"tetune", TETUNE_VERSION},
          {"input", a.input},
          {"output", a.output},
          {"options",
           {{"boundary", name_of(kBoundaries, a.options.boundary)},
            {"energy", name_of(kEnergies, a.options.energy)},
            {"effort", name_of(kEfforts, a.options.effort)},
            {"keep_vertices", a.options.keep_vertices},
            {"feature_angle_deg", a.options.feature_angle},
            {"max_deviation", a.options.max_deviation},
            {"open_boundaries", a.options.open_boundaries},
            {"frozen_regions", a.options.frozen_regions},
            {"frozen_patches", a.options.frozen_patches},
            {"relocation", name_of(kRelocations, a.options.relocation)},
            {"termination", name_of(kTerminations, a.options.termination)},
            {"device", name_of(kDevices, a.options.device)},
            {"max_iterations", a.options.max_iterations},
            {"max_ring", a.options.max_ring},
            {"boundary_flips", a.options.boundary_flips},
            {"targets", targets},
            {"threads", a.options.threads}}},
          {"read_seconds", read_seconds},
          {"write_seconds", write_seconds},
          {"before", to_json(before)},
          {"after", to_json(after)},
          {"optimization", to_json(report)}};
}

int run(const CLI::App& command, Arguments& a) {
  refuse_ineffective(command, a);
  for (const std::string& text : a.freeze) parse_freeze(text, a.options);
  if (a.target_dihedral) a.options.targets.push_back({Measure::min_dihedral, *a.target_dihedral});
  for (const auto& [value, name] : a.target_quality) a.options.targets.push_back({parse_measure(name), value});
  const int verbosity = a.quiet ? 0 : a.verbosity;
  check_writable(a.output);
  check_folder(a.report);
  check_folder(a.trace);
  ProgressLine line(verbosity > 0);

  line.say("reading");
  auto start = std::chrono::steady_clock::now();
  std::vector<std::string> warnings;
  TetMesh mesh = read_mesh(a.input, &warnings, a.options.threads);
  const double read_seconds = seconds_since(start);
  line.clear();
  if (verbosity > 0) {
    for (const std::string& w : warnings) fmt::print(stderr, "tetune: warning: {}\n", w);
  }

  if (mesh.tets.empty()) throw MeshError(a.input + ": there is no tetrahedron in this file");
  if (!a.max_deviation.empty()) a.options.max_deviation = parse_length("--max-deviation", a.max_deviation, mesh);
  // To say afterwards what became of the surface.
  const std::unique_ptr<const TetMesh> original(a.options.boundary == Boundary::slide ? std::make_unique<TetMesh>(mesh)
                                                                                      : nullptr);
  // The table needs less than the report, and takes less time.
  const auto measured = [&a](const TetMesh& m) {
    return a.report.empty() ? quality(m, a.options.threads) : measure_all(m, a.options.threads);
  };
  Quality before;
  Report report;
  Context context;
  context.progress = [&line](const Progress& p) {
    line.update(p);
    return true;
  };
  line.say("optimising");
  try {
    before = measured(mesh);
    report = optimize(mesh, a.options, context);
  } catch (const MeshError&) {
    line.clear();
    throw MeshError(a.input + ": " + validity_message(validate(mesh, a.options.threads)));
  }
  line.say("writing");
  start = std::chrono::steady_clock::now();
  write_mesh(a.output, mesh, a.options.threads);
  const double write_seconds = seconds_since(start);
  line.clear();

  const Quality after = measured(mesh);
  std::optional<Comparison> change;
  if (original && (verbosity > 0 || !a.report.empty())) change = compare(*original, mesh, a.options.threads);
  if (verbosity > 0) {
    fmt::print("{}", quality_table({"before", "after"}, {before, after}));
    fmt::print(
        "  {} sweeps, {} + {} flips (2-3 + 3-2), {} larger edge removals, {} boundary flips, {}; {} of {} vertices "
        "fixed\n",
        report.sweeps.size(), report.flips23, report.flips32, report.edge_removals, report.boundary_flips,
        to_string(report.stop), report.fixed_vertices, report.vertices);
    if (report.vertices_inserted + report.vertices_removed > 0) {
      fmt::print("  {} vertices inserted, {} removed\n", report.vertices_inserted, report.vertices_removed);
    }
    if (report.corners_not_held > 0) {
      fmt::print(
          "  {} listed corners lie where the surface has no feature, too many for a list of corners: they may move\n",
          report.corners_not_held);
    }
    if (report.edges_not_held > 0) {
      fmt::print("  {} tagged edges are too many for feature lines: their vertices may leave them\n",
                 report.edges_not_held);
    }
    if (report.triangles_dropped > 0) {
      fmt::print("  {} listed triangles without tag inside a region are no constraint and were dropped\n",
                 report.triangles_dropped);
    }
    if (report.edges_dropped > 0) fmt::print("  {} listed edges without tag are gone\n", report.edges_dropped);
    if (change) fmt::print("{}", surface_table(*change));
    for (const TargetReport& t : report.targets) fmt::print("{}", target_table(t));
    if (verbosity > 1) fmt::print("{}", run_table(report));
    fmt::print("  read {:.3f} s, optimised {:.3f} s on {}{}, written {:.3f} s: {}\n", read_seconds, report.seconds,
               report.device, report.threads > 0 ? fmt::format(" ({} threads)", report.threads) : "", write_seconds,
               a.output);
  }
  if (!a.report.empty()) {
    nlohmann::ordered_json json = full_report(a, before, after, report, read_seconds, write_seconds);
    if (change) json["surface"] = to_json(*change);
    write_text(a.report, json.dump(2) + "\n");
  }
  if (!a.trace.empty()) write_text(a.trace, trace_csv(report));
  const bool met = std::all_of(report.targets.begin(), report.targets.end(), [](const auto& t) { return t.met(); });
  return report.stop == StopReason::cancelled || !met ? kStoppedEarly : kDone;
}

}  // namespace

void add_optimize(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<Arguments>();
  CLI::App* c = app.add_subcommand("optimize", "Improve a mesh.");
  c->add_option("input", a->input, "Mesh to read: .mesh, .meshb, .ele")->required();
  c->add_option("-o,--output", a->output, "Mesh to write: .mesh, .meshb")->required();
  c->add_option("--boundary", a->options.boundary,
                "preserve: vertices move within the surface's planes and straight lines, the surface stays as it is; "
                "slide: they move on the input surface and along its features, the surface follows it closely; "
                "fixed: none moves")
      ->transform(CLI::CheckedTransformer(kBoundaries).description("{preserve,slide,fixed}"))
      ->default_str("preserve");
  c->add_option(
       "--feature-angle", a->options.feature_angle,
       "With --boundary slide: edges where the surface turns by more degrees are features, which vertices do not "
       "leave; 180: none")
      ->check(CLI::Range(0.0, 180.0))
      ->capture_default_str();
  c->add_option(
       "--max-deviation", a->max_deviation,
       "With --boundary slide: most distance of the new surface from the old one and of the old from the new; a "
       "length, or a part of the bounding box's diagonal as 0.1%")
      ->option_text("LENGTH|PERCENT");
  c->add_option("--freeze", a->freeze,
                "Regions and patches to keep as they are to the last bit, by their tags: tag=1,2,patch=7")
      ->option_text("tag=N,...,patch=N,...");
  c->add_flag(
       "--open-boundaries,!--no-open-boundaries", a->options.open_boundaries,
       "Tagged triangles with the same region on both sides stay faces of the mesh (the default), or are dropped")
      ->capture_default_str();
  c->add_option("--energy", a->options.energy,
                "shape: scale-free, small elements count as much as large ones; harmonic: sum of eta, as in the paper")
      ->transform(CLI::CheckedTransformer(kEnergies).description("{shape,harmonic}"))
      ->default_str("shape");
  c->add_option(
       "--effort", a->options.effort,
       "fast: stop when a sweep lowers the energy by less than 1e-3 of it; default: 1e-4, then work on the worst "
       "elements alone; best: then vertices are inserted, removed and moved to open the smallest dihedral angles")
      ->transform(CLI::CheckedTransformer(kEfforts).description("{fast,default,best}"))
      ->default_str("default");
  c->add_flag("--keep-vertices", a->options.keep_vertices,
              "With --effort best: no vertex is inserted or removed, those there are moved alone");
  c->add_option("--relocation", a->options.relocation,
                "newton: over-relaxed Newton steps; gradient: as in the paper, slower")
      ->transform(CLI::CheckedTransformer(kRelocations).description("{newton,gradient}"))
      ->default_str("newton");
  c->add_option("--termination", a->options.termination,
                "relative: stop when a sweep lowers the energy by less than 1e-4 of it; paper: conditions C1 to C3")
      ->transform(CLI::CheckedTransformer(kTerminations).description("{relative,paper}"))
      ->default_str("relative");
  c->add_option("--max-iterations", a->options.max_iterations, "Most relocation sweeps; 0: flips alone")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  c->add_option("--max-ring", a->options.max_ring,
                "Largest ring of tetrahedra around an edge that may be removed; 3: 3-2 flips alone, as in the paper")
      ->check(CLI::Range(3, 7))
      ->capture_default_str();
  c->add_flag("--boundary-flips,!--no-boundary-flips", a->options.boundary_flips,
              "Edges between coplanar triangles of one patch of the boundary may be flipped (the default), or stay")
      ->capture_default_str();
  c->add_option("--target-dihedral", a->target_dihedral,
                "Smallest dihedral angle that every element is to have. It changes nothing in the optimisation: if one "
                "misses it, the exit code is 1 and the output says which ones, and what constraint holds them")
      ->option_text("DEG");
  c->add_option(
       "--target-quality", a->target_quality,
       "The same for any measure of `tetune info`, for example 0.2 mean_ratio or 5 radius_ratio; may be repeated")
      ->option_text("Q MEASURE")
      ->allow_extra_args(false);
  c->add_option("--threads", a->options.threads, "CPU threads; 0: all. The result is the same for any number")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  c->add_option("--device", a->options.device, "Where to compute")
      ->transform(CLI::CheckedTransformer(kDevices).description("{auto,cpu,cuda}"))
      ->default_str("auto");
  c->add_option("--report", a->report, "Write all figures of the run to this file, as JSON");
  c->add_option("--trace", a->trace, "Write one line for each sweep and flip pass to this file, as CSV");
  auto* v = c->add_option("-v", a->verbosity, "0: nothing; 1: before and after; 2: each sweep and flip pass, and times")
                ->check(CLI::Range(0, 2))
                ->capture_default_str();
  c->add_flag("--quiet", a->quiet, "The same as -v 0")->excludes(v);
  c->callback([c, a, &exit_code] { exit_code = run(*c, *a); });
}

}  // namespace tetune::cli

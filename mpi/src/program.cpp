// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <petscsys.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <exception>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "clock.hpp"
#include "declined_measures.hpp"
#include "definitions.hpp"
#include "exit_code.hpp"
#include "files.hpp"
#include "io/losses.hpp"
#include "io/second_order.hpp"
#include "measure.hpp"
#include "optimize_arguments.hpp"
#include "option_flags.hpp"
#include "option_values.hpp"
#include "rounds.hpp"
#include "tetune/error.hpp"
#include "tetune/io.hpp"
#include "tetune/version.hpp"

/// `mpiexec -n N tetune-mpi IN OUT`.
namespace tetune::mpi {
namespace {

double peak_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) / 1024;
}

/// Messages count from 1, and advise to untangle by tetune, as tetune-mpi has no --untangle.
constexpr MessageForm kForm{true, "untangle them (tetune optimize --untangle)"};

class Program {
 public:
  Program(MPI_Comm comm, const cli::OptimizeArguments& arguments, const cli::Job& job)
      : comm_(comm), a_(arguments), job_(job), options_(arguments.options), first_(rank_of(comm) == 0) {}

  int run() {
    collective_try(comm_, [&] {
      take_frozen();
      if (!first_) return;
      const cli::OutputFolder folder(a_.names.output, false);
      if (is_plex_file(job_.output)) {
        check_plex_writable(job_.output);
      } else {
        check_writable(job_.output);
      }
      for (const std::string& path : job_.texts()) check_place(path);
    });
    auto start = Time::now();
    Input input = read_pieces(comm_, job_.input);
    if (input.totals.cells == 0) throw MeshError(job_.input + ": there is no tetrahedron in this file");
    for (const auto& list : {a_.warnings, input.warnings}) {
      for (const std::string& w : list) warn(w);
    }
    check_what_is_kept(input);
    read_seconds_ = seconds_since(start);
    start = Time::now();
    Part part;
    in_file([&] { part = distribute(comm_, std::move(input.pieces), input.totals); });
    const bool turned = orient_all(comm_, part);
    if (first_) input.frame.listed_inside_out = input.frame.listed_inside_out || turned;
    distribute_seconds_ = seconds_since(start);
    if (a_.deviation_bound) options_.max_deviation = a_.deviation_bound->in(bounding_box_of_all(part));
    before_ = quality_of_all(comm_, part.mesh, 1);

    start = Time::now();
    std::function<bool()> stop;
    if (a_.time_limit) stop = [&] { return seconds_since(program_start_) > *a_.time_limit; };
    in_file([&] { report_ = optimize_parts(comm_, part, input.totals, options_, stop, kForm); });
    optimize_seconds_ = seconds_since(start);

    after_ = quality_of_all(comm_, part.mesh, 1);
    if (report_.stop != StopReason::cancelled) {
      for (const std::string& w : cli::declined_measures(before_, after_, "tetune optimize --only-below")) warn(w);
    }
    if (!job_.report.empty()) first_cut_ = quality_of_all(comm_, at_first_cut(part), 1);
    start = Time::now();
    std::vector<std::string> warnings;
    if (is_plex_file(job_.output)) {
      write_plex(comm_, job_.output, std::move(part), input.totals, input.labels, warnings);
    } else {
      Pieces pieces = collect(comm_, std::move(part), input.totals, input.frame.others);
      write_pieces(comm_, job_.output, std::move(pieces), input.totals, std::move(input.frame), warnings);
    }
    for (const std::string& w : warnings) warn(w);
    write_seconds_ = seconds_since(start);
    memory_ = all_gather(comm_, peak_mb());
    const bool has_report = write_report();
    if (first_) print_summary();
    return report_.stop == StopReason::cancelled || !has_report ? cli::kStoppedEarly : cli::kDone;
  }

 private:
  void take_frozen() {
    for (const cli::TagOrName& f : a_.frozen) {
      if (!f.name.empty())
        throw OptionError("--freeze: '" + f.name + "' is not a tag; tetune-mpi takes no names of groups");
      (f.is_region() ? options_.frozen_regions : options_.frozen_patches).push_back(f.tag);
    }
  }

  /// Names the file in errors of the mesh, and flags.
  template <class F>
  void in_file(F work) const {
    try {
      work();
    } catch (const MeshError& e) {
      throw MeshError(job_.input + ": " + cli::with_flags(e.what()));
    } catch (const OptionError& e) {
      throw OptionError(cli::with_flags(e.what()));
    } catch (const DeviceError& e) {
      throw DeviceError(cli::with_flags(e.what()));
    }
  }

  /// Checks conversions between a DMPlex and other formats.
  void check_what_is_kept(const Input& input) const {
    const bool to_plex = is_plex_file(job_.output);
    collective_try(comm_, [&] {
      constexpr Id kMaxOfRank = std::numeric_limits<Index>::max();
      if (!to_plex && !is_meshb(job_.output) && std::max(input.totals.vertices, input.totals.cells) > kMaxOfRank) {
        throw FileError(job_.output +
                        ": one rank writes this format, of at most 2^31 - 1 vertices and tetrahedra; give .meshb");
      }
      if (!to_plex) return;
      // Cells, faces, edges and vertices.
      if (input.totals.cells > PETSC_MAX_INT / 5) {
        throw FileError(job_.output +
                        ": a DMPlex of this mesh has more points than this PETSc can number; give .meshb");
      }
      if (!input.frame.others.empty()) {
        throw FileError(job_.output + ": a DMPlex is written of tetrahedra alone, and " + job_.input +
                        " has elements of other kinds; give another format");
      }
    });
    if (to_plex) {
      std::vector<std::string> losses;
      warn_of_names(input.frame, {0, &losses});
      if (input.frame.second_order) losses.push_back(lost_middles(input.frame));
      for (const std::string& loss : losses) warn(job_.output + ": " + loss);
    }
    if (to_plex || !input.labels) return;
    for (const std::string& name : input.labels->names) {
      if (std::find(kSets.begin(), kSets.end(), name) != kSets.end()) continue;
      warn(job_.input + ": label \"" + name + "\" becomes tags with new numbers; .h5 would keep it");
    }
  }

  void warn(const std::string& text) const {
    if (first_ && a_.verbosity >= 0) fmt::print(stderr, "tetune-mpi: warning: {}\n", text);
  }

  cli::Box bounding_box_of_all(const Part& part) const {
    std::vector<double> box(6, std::numeric_limits<double>::infinity());
    for (const Point3& x : part.mesh.points) {
      for (std::size_t k = 0; k < 3; ++k) {
        box[k] = std::min(box[k], x[k]);
        box[3 + k] = std::min(box[3 + k], -x[k]);
      }
    }
    box = all_reduce(comm_, std::move(box), MPI_MIN);
    return {{box[0], box[1], box[2]}, {-box[3], -box[4], -box[5]}};
  }

  /// Returns false on all ranks, after a warning, where the report cannot be written: the mesh is written already.
  bool write_report() const {
    int failed = 0;
    if (first_ && !job_.report.empty()) {
      try {
        write_text(job_.report, json().dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
      } catch (const FileError& e) {
        warn(fmt::format("{}; the mesh was written", e.what()));
        failed = 1;
      }
    }
    MPI_Bcast(&failed, 1, MPI_INT, 0, comm_);
    return failed == 0;
  }

  void print_summary() const {
    if (a_.verbosity < 1) return;
    std::string text = fmt::format("  {:<22}{:>14}{:>14}\n", "", "before", "after");
    const auto line = [&text](const char* name, double before, double after, int digits) {
      text += fmt::format("  {:<22}{:>14.{}f}{:>14.{}f}\n", name, before, digits, after, digits);
    };
    line("tetrahedra", double(before_.tets), double(after_.tets), 0);
    line("dihedral min  (deg)", before_.dihedral_min, after_.dihedral_min, 3);
    line("         max", before_.dihedral_max, after_.dihedral_max, 3);
    line("mean ratio  min", before_.mean_ratio_min, after_.mean_ratio_min, 4);
    line("            mean", before_.mean_ratio, after_.mean_ratio, 4);
    text += fmt::format("  {:<7}{:>14}{:>14}{:>14}{:>14}{:>12}{:>12}\n", "round", "tetrahedra", "moved", "cut vertices",
                        "left frozen", "optimize s", "total s");
    for (const RoundReport& r : report_.rounds) {
      text += fmt::format("  {:<7}{:>14}{:>14}{:>14}{:>14}{:>12.2f}{:>12.2f}\n", r.round, r.tets, r.tets_moved,
                          r.cut_vertices, r.left_frozen, r.optimizer_seconds, r.seconds);
    }
    text += fmt::format(
        "  {} ranks: read {:.2f} s, distributed {:.2f} s, optimized {:.2f} s, written {:.2f} s; largest memory of a "
        "rank {:.0f} MB\n",
        report_.ranks, read_seconds_, distribute_seconds_, optimize_seconds_, write_seconds_,
        *std::max_element(memory_.begin(), memory_.end()));
    if (report_.stop == StopReason::cancelled) {
      text += "  stopped early (time limit): a valid mesh was written, but there was more to do\n";
    }
    fmt::print("{}", text);
  }

  static nlohmann::ordered_json to_json(const Quality& q) {
    return {{"tets", q.tets},
            {"dihedral_min_deg", q.dihedral_min},
            {"dihedral_max_deg", q.dihedral_max},
            {"dihedral_mean_deg", q.dihedral_mean},
            {"mean_ratio_min", q.mean_ratio_min},
            {"mean_ratio_mean", q.mean_ratio},
            {"eta_sum", q.eta_sum},
            {"shape_sum", q.shape_sum},
            {"volume", q.volume},
            {"dihedral_histogram", q.histogram}};
  }

  nlohmann::ordered_json json() const {
    nlohmann::ordered_json rounds = nlohmann::ordered_json::array();
    for (const RoundReport& r : report_.rounds) {
      rounds.push_back({{"round", r.round},
                        {"tets", r.tets},
                        {"tets_moved", r.tets_moved},
                        {"cut_vertices", r.cut_vertices},
                        {"left_frozen", r.left_frozen},
                        {"optimizer_seconds", r.optimizer_seconds},
                        {"seconds", r.seconds}});
    }
    nlohmann::ordered_json optimization = {{"tets_before", report_.tets_before},
                                           {"tets_after", report_.tets_after},
                                           {"energy_before", report_.energy_before},
                                           {"energy_after", report_.energy_after}};
    for (const auto& kind : kOperationCounts) optimization[kind.name] = report_.*kind.count;
    optimization.update({{"left_frozen", report_.left_frozen},
                         {"surface_triangles", report_.surface_triangles},
                         {"optimizer_seconds", report_.optimizer_seconds},
                         {"seconds", report_.seconds},
                         {"stop", to_string(report_.stop)},
                         {"rounds", rounds}});
    return {{"tetune", TETUNE_VERSION},
            {"input", job_.input},
            {"output", job_.output},
            {"ranks", report_.ranks},
            {"options", cli::to_json(options_)},
            {"read_seconds", read_seconds_},
            {"distribute_seconds", distribute_seconds_},
            {"write_seconds", write_seconds_},
            {"peak_mb", memory_},
            {"before", to_json(before_)},
            {"after", to_json(after_)},
            {"after_at_first_cut", to_json(first_cut_)},
            {"optimization", optimization}};
  }

  MPI_Comm comm_;
  const cli::OptimizeArguments& a_;
  const cli::Job& job_;
  Options options_;
  bool first_;
  const Time::time_point program_start_ = Time::now();
  Quality before_, after_, first_cut_;
  DistributedReport report_;
  std::vector<double> memory_;
  double read_seconds_ = 0, distribute_seconds_ = 0, optimize_seconds_ = 0, write_seconds_ = 0;
};

/// Options of `tetune optimize` that tetune-mpi does not have.
constexpr std::array<std::string_view, 18> kAbsentOptions{
    "--untangle",      "--target-dihedral", "--target-quality", "--only-below",   "--rings", "--criteria",
    "--max-memory",    "--report-html",     "--trace-angles",   "--trace",        "--map",   "--dry-run",
    "--print-options", "--progress",        "--periodic",       "--periodic-map", "--tags",  "--straighten"};

/// Replaces texts of `tetune optimize` about files and groups by those that hold here.
void describe_arguments(CLI::App& app) {
  app.get_option("files")->description(
      "Mesh to read: a format of `tetune`, or .h5; and mesh to write, also .xmf, which must not exist, unless -o is "
      "given");
  app.get_option("--output")
      ->description("Mesh to write: a format of `tetune`, .h5 or .xmf. A file that exists is replaced");
  app.get_option("--freeze")
      ->description("Regions and patches that do not change, by their tags: tag=1,2,patch=7")
      ->option_text("tag=N,...,patch=N,...");
}

/// Adds the endings of a DMPlex to the list of those that the library knows, where a text ends with that.
std::string with_plex_endings(const std::string& text) {
  if (text.ends_with("known endings: " + writable_endings())) return text + " .h5 .xmf";
  return text.ends_with("known endings: " + readable_endings()) ? text + " .h5" : text;
}

int main_of_rank(int argc, char** argv) {
  const MPI_Comm comm = MPI_COMM_WORLD;
  const bool first = rank_of(comm) == 0;
  CLI::App app{
      "tetune-mpi optimizes a tetrahedral mesh that is distributed over the ranks of MPI:\n"
      "mpiexec -n N tetune-mpi INPUT OUTPUT",
      "tetune-mpi"};
  app.set_version_flag("--version", "tetune-mpi " TETUNE_VERSION);
  app.footer(
      "Options are those of `tetune optimize`. Exit codes: 0 done; 1 stopped at the time limit, or the report "
      "could not be written, and a valid mesh was written; 2 nothing was written, an old output file is untouched.");
  cli::OptimizeArguments arguments;
  cli::define_arguments(app, arguments);
  for (const std::string_view name : kAbsentOptions) app.remove_option(app.get_option(std::string(name)));
  describe_arguments(app);
  try {
    for (int i = 1; i < argc; ++i) {
      const std::string_view argument = argv[i];
      if (argument == "--") break;  // no options after it
      const std::string_view name = argument.substr(0, argument.find('='));
      if (std::find(kAbsentOptions.begin(), kAbsentOptions.end(), name) != kAbsentOptions.end()) {
        throw OptionError(std::string(name) + ": `tetune` has this option, tetune-mpi does not; see tetune-mpi --help");
      }
      // CLI11 would take Mmg's -hausd for -h, which prints the help.
      if (argument.size() > 2 && argument.starts_with("-h")) {
        throw OptionError(std::string(argument) + ": Mmg's names of options are for `tetune`; see tetune-mpi --help");
      }
      cli::check_name(app, std::string(argument), "tetune-mpi");
    }
    app.parse(argc, argv);
    if (arguments.files.empty() || (arguments.files.size() == 1 && arguments.names.output.empty())) {
      throw OptionError("name a mesh to read and one to write: tetune-mpi INPUT OUTPUT");
    }
    const std::vector<cli::Job> jobs = cli::resolve_jobs(app, arguments);
    if (jobs.size() != 1) throw OptionError("one mesh at a time: a batch of meshes is for `tetune optimize`");
    if (arguments.options.surface_vertices == SurfaceVertices::edit) {
      throw OptionError("--surface-vertices edit: ranks keep the vertices of the surface; leave it out");
    }
    if (jobs[0].input == cli::kPipe || jobs[0].output == cli::kPipe) {
      throw OptionError("pipes end at one rank: name files");
    }
    return Program(comm, arguments, jobs[0]).run();
  } catch (const CLI::ParseError& e) {
    const bool is_error = e.get_exit_code() != 0;
    if (first && is_error) fmt::print(stderr, "tetune-mpi: {}; see tetune-mpi --help\n", e.what());
    if (first && !is_error) app.exit(e);  // prints the help or the version
    return is_error ? cli::kNothingWritten : cli::kDone;
  } catch (const Error& e) {
    // The error is collective: all ranks have the same message.
    if (first) fmt::print(stderr, "tetune-mpi: {}\n", with_plex_endings(e.what()));
    return cli::kNothingWritten;
  }
}

}  // namespace
}  // namespace tetune::mpi

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int code = 2;
  if (PetscInitializeNoArguments() != 0) MPI_Abort(MPI_COMM_WORLD, code);
  PetscPopSignalHandler();
  PetscPushErrorHandler(PetscReturnErrorHandler, nullptr);  // errors are thrown, and reported once
  try {
    code = tetune::mpi::main_of_rank(argc, argv);
  } catch (const std::exception& e) {
    // This rank alone: the others wait for it, so all must end.
    fmt::print(stderr, "tetune-mpi: rank {}: {}\n", tetune::mpi::rank_of(MPI_COMM_WORLD), e.what());
    MPI_Abort(MPI_COMM_WORLD, code);
  }
  PetscFinalize();
  MPI_Finalize();
  return code;
}

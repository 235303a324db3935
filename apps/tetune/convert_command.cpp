// SPDX-License-Identifier: Apache-2.0
// The command convert.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "console.hpp"
#include "definitions.hpp"
#include "exit_code.hpp"
#include "geometry_files.hpp"
#include "interrupt.hpp"
#include "mesh_errors.hpp"
#include "mesh_files.hpp"
#include "system/path.hpp"
#include "tables.hpp"
#include "tetune/curve.hpp"
#include "tetune/error.hpp"
#include "tetune/io.hpp"

namespace tetune::cli {
namespace {

struct ConvertArguments {
  std::string input, output;
  std::string replaced_output;  ///< with -o
  std::string tags;
  std::string msh;
  std::string surface;  ///< a finer mesh
  GeometryArguments geometry;
  int order = 0;
  double feature_angle = 45;
  int threads = 0;
  bool quiet = false;
};

/// Converts to elements of the order asked for.
void set_order(const ConvertArguments& a, TetMesh& mesh, Console& console) {
  if (a.order == 0) return;
  const bool had_deck = mesh.deck != nullptr;
  if (a.order == 1) {
    mesh.second_order = false;
    mesh.curved_edges.clear();
    mesh.deck = nullptr;
    if (had_deck) mesh.deck_nodes.clear();
  } else {
    CurveOptions options;
    options.feature_angle = a.feature_angle;
    options.threads = a.threads;
    std::optional<Input> finer;
    if (!a.surface.empty()) {
      finer = read_input(a.surface, a.threads);
      options.surface = &finer->mesh;
    }
    std::optional<Geometry> geometry;
    if (!a.geometry.file.empty()) {
      geometry.emplace(a.geometry.file, unit_in_mm(a.geometry.unit), a.threads);
      for (const std::string& warning : geometry->warnings()) console.warn(warning);
      options.geometry = &*geometry;
    }
    const CurveReport r =
        with_messages(shown_input(a.input), mesh, a.threads, kUntangleFirst, [&] { return curve(mesh, options); });
    console.print(fmt::format("{} curved edges, {} curved tetrahedra, smallest scaled Jacobian {:.4f}\n",
                              r.curved_edges, r.curved_tets, r.min_scaled_jacobian));
    if (r.not_valid_before > 0) {
      console.print(fmt::format("{} tetrahedra were not valid with the curved surface: {} inner vertices were moved\n",
                                r.not_valid_before, r.vertices_moved));
    }
    if (r.edges_off_geometry > 0) {
      console.warn(
          fmt::format("{} edges of the surface stay straight: it is not clear which face or edge of {} they are on",
                      r.edges_off_geometry, a.geometry.file));
    }
    if (!r.straightened.empty()) {
      console.warn("parts of the surface are less curved than asked for:");
      fmt::print(stderr, "{}", straightened_text(r.straightened));
    }
  }
  if (had_deck) console.warn("--order: the mesh is written without the other parts of its deck");
}

int convert(const CLI::App& c, const ConvertArguments& a) {
  if (a.output.empty() == a.replaced_output.empty()) {
    throw OptionError("name one mesh to write, after the input or with -o");
  }
  if (a.replaced_output.empty()) refuse_existing(a.output);
  const std::string& output = a.output.empty() ? a.replaced_output : a.output;
  if (output != kPipe) check_writable(output);
  refuse_replacing(output, a.input, {a.surface, a.geometry.file});
  if (a.order == 2) {
    if (output == kPipe) {
      throw OptionError("--order 2: MEDIT, as the standard output has it, has no nodes in the middles of edges");
    }
    check_second_order(output);
  }
  if (!a.surface.empty() && a.order != 2) throw OptionError("--surface is for --order 2 alone");
  if (!a.geometry.file.empty() && a.order != 2) throw OptionError("--geometry is for --order 2 alone");
  if (!a.geometry.file.empty() && !a.surface.empty()) throw OptionError("--surface and --geometry exclude each other");
  unit_in_mm(a.geometry.unit);
  Console console(ProgressMode::none, a.quiet ? 0 : 1, stderr);
  interrupt::install(console.json());
  Input input = read_input(a.input, a.threads);
  if (c.count("--feature-angle") > 0) {
    if (a.order != 2) console.warn("--feature-angle has no effect without --order 2");
    if (!a.geometry.file.empty()) console.warn("--feature-angle has no effect with --geometry");
  }
  for (const std::string& warning : flags_without_geometry(c, a.geometry)) console.warn(warning);
  if (!a.tags.empty()) choose_tags(input, a.input, a.tags);
  for (const std::string& warning : input.warnings) console.warn(warning);
  if (!a.msh.empty()) {
    input.mesh.dialect = "msh " + a.msh;
    std::replace(input.mesh.dialect.begin(), input.mesh.dialect.end(), '-', ' ');
    if (ending_of(output) != ".msh") console.warn("--msh has no effect: the output is not an .msh file");
  }
  set_order(a, input.mesh, console);
  const std::vector<std::string> warnings = write_output(output, input.binary, input.mesh, a.threads);
  interrupt::enter(interrupt::Stage::written);
  for (const std::string& warning : warnings) console.warn(warning);
  return kDone;
}

}  // namespace

void add_convert(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<ConvertArguments>();
  CLI::App* c = app.add_subcommand("convert", "Write a mesh in another format; warnings name what is lost.");
  c->add_option("INPUT", a->input, "Mesh to read: " + readable_endings() + "; or - for the standard input (MEDIT)")
      ->required();
  c->add_option("OUTPUT", a->output,
                "Mesh to write, which must not exist: " + writable_endings() +
                    "; or - for the standard output (MEDIT, binary if the input is)");
  c->add_option("-o,--output", a->replaced_output, "Mesh to write; a file that exists is replaced")
      ->option_text("FILE");
  c->add_option("--msh", a->msh, "Version and encoding of an .msh file; otherwise those of the input, or 4.1-binary")
      ->check(is_word({"2.2-text", "2.2-binary", "4.1-text", "4.1-binary"}))
      ->option_text("VERSION");
  c->add_option("--order", a->order,
                "Order of the tetrahedra: 1 drops mid-side nodes; 2 makes mid-side nodes on the curved surface that is "
                "reconstructed from the triangles, and proves each element valid; otherwise that of the input")
      ->check(CLI::IsMember({1, 2}));
  c->add_option("--surface", a->surface,
                "With --order 2, a finer mesh of the same part, on whose surface the mid-side nodes are put")
      ->option_text("FILE");
  define_geometry(*c, a->geometry, "Options",
                  "With --order 2, CAD model of the part (.step, .stp, .iges, .igs, .brep, .brp), on whose faces and "
                  "edges the mid-side nodes are put");
  c->add_option("--feature-angle", a->feature_angle,
                "With --order 2, the surface is not smooth at edges where it turns by a larger angle, in degrees")
      ->check(CLI::Range(1e-9, 180.0))
      ->capture_default_str();
  c->add_option("--tags", a->tags, kTagsHelp)->option_text("NAME");
  c->add_option("--threads", a->threads, "CPU threads; 0: all")->check(CLI::Range(0, 4096))->capture_default_str();
  c->add_flag("--quiet", a->quiet, "Only errors and warnings");
  check_values(*c);
  c->callback([c, a, &exit_code] { exit_code = convert(*c, *a); });
}

}  // namespace tetune::cli

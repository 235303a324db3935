// SPDX-License-Identifier: Apache-2.0
// The commands info and compare.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <utility>

#include "commands.hpp"
#include "console.hpp"
#include "criteria_file.hpp"
#include "definitions.hpp"
#include "exit_code.hpp"
#include "geometry_files.hpp"
#include "mesh_errors.hpp"
#include "mesh_files.hpp"
#include "option_values.hpp"
#include "report_files.hpp"
#include "tables.hpp"
#include "tetune/io.hpp"

namespace tetune::cli {
namespace {

struct InspectArguments {
  std::array<std::string, 2> files;  ///< `info` has only the first
  std::string cell_data;
  std::string tags;
  std::vector<std::string> min_quality;
  std::string criteria;
  GeometryArguments geometry;
  std::string classified;  ///< mesh to write, with the classification
  bool json = false;
  bool check = false;
  int threads = 0;
  int worst = 10;
};

void print_warnings(const std::vector<std::string>& warnings) {
  for (const std::string& w : warnings) print_to(stderr, fmt::format("tetune: warning: {}\n", w));
}

/// --tags names cell data of the first file. If the second file lacks them, they are its tags already.
TetMesh read(const InspectArguments& a, std::size_t file) {
  const std::string& path = a.files[file];
  Input input = read_input(path, a.threads);
  const auto& data = input.mesh.tet_data;
  const bool lacks = std::none_of(data.begin(), data.end(), [&](const DataArray& d) { return d.name == a.tags; });
  choose_tags(input, path, file > 0 && lacks ? "" : a.tags);
  print_warnings(input.warnings);
  return std::move(input.mesh);
}

/// The measurements of one file. The quality is that of the elements as listed; it is not available if indices are out
/// of range.
struct Inspection {
  TetMesh mesh;
  ValidationReport validity;
  Quality quality;
  bool measured = true;
  std::vector<Index> invalid_curved;           ///< curved tetrahedra that are not proved valid
  std::optional<AcceptanceReport> acceptance;  ///< with --criteria
  std::optional<Geometry> geometry;            ///< with --geometry
  GeometryMatch match;
};

/// Null without --criteria.
std::optional<AcceptanceCriteria> criteria_of(const InspectArguments& a) {
  return a.criteria.empty() ? std::nullopt : std::optional(read_criteria(a.criteria));
}

bool is_valid(const Inspection& i) { return !i.mesh.tets.empty() && i.validity.ok() && i.invalid_curved.empty(); }
bool is_accepted(const Inspection& i) { return !i.acceptance || i.acceptance->verdict != Verdict::fail; }

/// The curved tetrahedra that are not proved valid, in increasing order.
std::vector<Index> find_invalid_curved(const TetMesh& mesh, int threads) {
  std::vector<Index> ids;
  for (const CurvedTet& t : measure_curved_each(mesh, threads)) {
    if (t.validity != CurvedValidity::valid) ids.push_back(t.tet);
  }
  return ids;
}

Inspection inspect(const InspectArguments& a, const std::optional<AcceptanceCriteria>& criteria, std::size_t file) {
  Inspection i;
  i.mesh = read(a, file);
  i.validity = validate(i.mesh, a.threads);
  try {
    i.quality = measure_all(i.mesh, a.threads, a.worst);
    if (!i.quality.curved.all_valid()) i.invalid_curved = find_invalid_curved(i.mesh, a.threads);
    if (criteria) i.acceptance = tetune::check(i.mesh, *criteria, a.threads);
  } catch (const MeshError&) {
    i.measured = false;
  }
  return i;
}

/// Matches the mesh with the geometry, and writes the classification.
void match_geometry(const InspectArguments& a, const std::string& name, Inspection& i) {
  if (a.geometry.file.empty()) return;
  i.geometry.emplace(a.geometry.file, unit_in_mm(a.geometry.unit));
  print_warnings(i.geometry->warnings());
  i.match = with_messages(name, i.mesh, a.threads, kUntangleFirst, [&] { return i.geometry->match(i.mesh); });
  if (!a.classified.empty()) {
    print_warnings(write_output(a.classified, /*binary=*/false, classified_mesh(i.mesh, i.match), a.threads));
  }
}

/// The worst element compared to a bound.
struct BoundVerdict {
  Target bound;
  double worst;
  bool met;
};

std::vector<BoundVerdict> judge(const Quality& q, const std::vector<Target>& bounds) {
  std::vector<BoundVerdict> verdicts;
  for (const Target& b : bounds) {
    const bool up = larger_is_better(b.measure);
    const double worst = up ? q.of(b.measure).min : q.of(b.measure).max;
    verdicts.push_back({b, worst, up ? worst >= b.value : worst <= b.value});
  }
  return verdicts;
}

std::string to_text(const BoundVerdict& v) {
  const bool up = larger_is_better(v.bound.measure);
  return fmt::format("{} {:.6g}, {}: {} {:.6g}", to_string(v.bound.measure), v.worst, v.met ? "met" : "NOT met",
                     up ? ">=" : "<=", v.bound.value);
}

std::string defects_of(const Inspection& i) { return validity_message(i.validity, i.mesh); }

/// The first numbers of a list, counted from 1.
std::vector<Index> first_from_1(const std::vector<Index>& ids) {
  constexpr std::size_t kShown = 5;
  std::vector<Index> first;
  for (std::size_t k = 0; k < std::min(kShown, ids.size()); ++k) first.push_back(ids[k] + 1);
  return first;
}

/// The reason why a mesh is not valid; empty if it is.
std::string invalidity_of(const Inspection& i) {
  if (!i.validity.ok()) return defects_of(i);
  if (i.mesh.tets.empty()) return "there is no tetrahedron";
  if (i.invalid_curved.empty()) return "";
  return fmt::format("{} curved tetrahedra are not proved valid (first, counted from 1: {})", i.invalid_curved.size(),
                     fmt::join(first_from_1(i.invalid_curved), ", "));
}

/// The text behind a verdict of criteria, which do not know curved elements.
std::string acceptance_note(const Inspection& i) {
  if (i.invalid_curved.empty()) return "";
  return fmt::format(" (criteria judge straight tetrahedra; {} curved ones are not proved valid)",
                     i.invalid_curved.size());
}

nlohmann::ordered_json validity_json(const Inspection& i) {
  nlohmann::ordered_json json = to_json(i.validity);
  if (i.invalid_curved.empty()) return json;
  json["valid"] = false;
  json["findings"].push_back({{"kind", "curved tetrahedra that are not proved valid"},
                              {"where", "tetrahedra"},
                              {"count", i.invalid_curved.size()},
                              {"first", first_from_1(i.invalid_curved)}});
  return json;
}

nlohmann::ordered_json acceptance_json(const Inspection& i) {
  nlohmann::ordered_json json = to_json(*i.acceptance);
  if (i.quality.curved.tets > 0) json["curved_not_valid"] = i.invalid_curved.size();
  return json;
}

/// The JSON of one of two files.
nlohmann::ordered_json side_json(const std::string& file, const Inspection& i) {
  nlohmann::ordered_json json = {{"file", file}, {"validity", validity_json(i)}, {"quality", to_json(i.quality)}};
  if (i.acceptance) json["acceptance"] = acceptance_json(i);
  return json;
}

void print_json(const InspectArguments& a, const Inspection& i, const std::vector<BoundVerdict>& verdicts) {
  nlohmann::ordered_json json = {{"file", a.files[0]}, {"counts", counts_json(i.mesh)}, {"validity", validity_json(i)}};
  const Box box = bounding_box(i.mesh);
  json["box"] = {{"low", box.low}, {"high", box.high}, {"diagonal", box.diagonal()}};
  if (i.measured) json["quality"] = to_json(i.quality);
  if (i.acceptance) json["acceptance"] = acceptance_json(i);
  if (i.geometry) json["geometry"] = to_json(*i.geometry, i.match);
  for (const BoundVerdict& v : verdicts) {
    json["bounds"].push_back(
        {{"measure", to_string(v.bound.measure)}, {"value", v.bound.value}, {"worst", v.worst}, {"met", v.met}});
  }
  fmt::print("{}", json_text(json));
}

/// The sentence on a valid mesh, which names what is checked.
std::string validity_of(const TetMesh& mesh) {
  const bool has_others = std::any_of(mesh.others.begin(), mesh.others.end(),
                                      [](const ElementBlock& block) { return block.kind != kPoints; });
  return fmt::format("valid: {} positive, every face on one or two tetrahedra, boundary closed{}",
                     has_others ? "the volume of every tetrahedron" : "every volume",
                     has_others ? "; elements of other kinds are not checked" : "");
}

/// One line, for --check.
void print_verdict(const std::string& name, const Inspection& i, const std::vector<BoundVerdict>& verdicts) {
  std::string text = is_valid(i) ? validity_of(i.mesh) : invalidity_of(i);
  for (std::size_t at = 0; (at = text.find("\n  ")) != std::string::npos;) {
    text.replace(at, 3, text[at - 1] == ':' ? " " : "; ");
  }
  for (const BoundVerdict& v : verdicts) text += "; " + to_text(v);
  if (i.acceptance)
    text += fmt::format("; {}: {}{}", i.acceptance->name, to_string(i.acceptance->verdict), acceptance_note(i));
  fmt::print("{}: {}\n", name, text);
}

void print_tables(const std::string& name, const Inspection& i, const std::vector<BoundVerdict>& verdicts) {
  const bool has_tets = !i.mesh.tets.empty();
  const Box box = bounding_box(i.mesh);
  fmt::print("{}\n{}", name, mesh_summary(i.mesh));
  fmt::print("  box                     {:.6g} {:.6g} {:.6g} to {:.6g} {:.6g} {:.6g}, diagonal {:.6g}\n", box.low[0],
             box.low[1], box.low[2], box.high[0], box.high[1], box.high[2], box.diagonal());
  if (i.measured && has_tets) fmt::print("  volume                  {:.6g}\n", i.quality.volume);
  fmt::print("  {}\n", is_valid(i) ? validity_of(i.mesh) : invalidity_of(i));
  if (i.measured && has_tets) {
    const auto& findings = i.validity.findings;
    const bool inverted = std::any_of(findings.begin(), findings.end(),
                                      [](const Finding& f) { return f.defect == Defect::inverted_tet; });
    if (inverted) fmt::print("  inverted tetrahedra are measured by their absolute volume\n");
    fmt::print("{}{}", quality_table({""}, {i.quality}), measure_table("measures", i.quality));
    fmt::print("{}{}", worst_table("worst, counted from 1", i.quality), histogram(i.quality));
    fmt::print("{}", curved_table(i.quality.curved));
  }
  if (i.geometry) fmt::print("{}", match_table(*i.geometry, i.match));
  for (const BoundVerdict& v : verdicts) fmt::print("  {}\n", to_text(v));
  if (i.acceptance) fmt::print("{}", acceptance_table("acceptance", *i.acceptance, acceptance_note(i)));
}

int info(const CLI::App& c, const InspectArguments& a) {
  const std::string name = shown_input(a.files[0]);
  std::vector<Target> bounds;
  for (const std::string& text : a.min_quality)
    bounds.push_back(parse_bound("--min-quality", text, Measure::mean_ratio));
  if (a.geometry.file.empty() && !a.classified.empty()) throw OptionError("--output is for --geometry alone");
  unit_in_mm(a.geometry.unit);
  print_warnings(flags_without_geometry(c, a.geometry));
  Inspection i = inspect(a, criteria_of(a), 0);
  match_geometry(a, name, i);
  const std::vector<BoundVerdict> verdicts = i.measured ? judge(i.quality, bounds) : std::vector<BoundVerdict>{};
  const bool met =
      i.measured && std::all_of(verdicts.begin(), verdicts.end(), [](const BoundVerdict& v) { return v.met; });
  if (!a.cell_data.empty()) {
    if (!i.measured) throw MeshError(name + ": " + defects_of(i));
    std::vector<std::string> warnings;
    write_measures(a.cell_data, i.mesh, a.threads, &warnings);
    print_warnings(warnings);
  }
  if (a.json) {
    print_json(a, i, verdicts);
  } else if (a.check) {
    print_verdict(name, i, verdicts);
  } else {
    print_tables(name, i, verdicts);
  }
  return is_valid(i) && (met || bounds.empty()) && is_accepted(i) ? kDone : kStoppedEarly;
}

/// Meshes of one part have about the same volume.
void warn_of_volumes(const InspectArguments& a, const Comparison& c) {
  constexpr double kUnrelated = 2;
  const double ratio = 1 + c.volume_change;
  if (ratio <= kUnrelated && ratio >= 1 / kUnrelated) return;
  print_warnings({fmt::format(
      "{} has {:.3g} times the volume of {}: check that both are meshes of the same part, in the same unit", a.files[1],
      ratio, a.files[0])});
}

int compare_files(const InspectArguments& a) {
  const std::optional<AcceptanceCriteria> criteria = criteria_of(a);
  const Inspection before = inspect(a, criteria, 0);
  const Inspection after = inspect(a, criteria, 1);
  if (!before.measured || !after.measured) {
    const bool first = !before.measured;
    throw MeshError(a.files[first ? 0 : 1] + ": " + defects_of(first ? before : after));
  }
  const Comparison c = compare(before.mesh, after.mesh, a.threads);
  warn_of_volumes(a, c);
  if (a.json) {
    fmt::print("{}", json_text({{"before", side_json(a.files[0], before)},
                                {"after", side_json(a.files[1], after)},
                                {"change", to_json(c)}}));
  } else {
    fmt::print("{}{}{}{}{}{}{}", quality_table({"before", "after"}, {before.quality, after.quality}),
               curved_change(before.quality.curved, after.quality.curved),
               measure_table("measures before", before.quality), measure_table("measures after", after.quality),
               worst_table("worst before", before.quality), worst_table("worst after", after.quality),
               comparison_table(c));
    if (before.acceptance) {
      fmt::print("{}", acceptance_table("acceptance before", *before.acceptance, acceptance_note(before)));
    }
    if (after.acceptance) {
      fmt::print("{}", acceptance_table("acceptance after", *after.acceptance, acceptance_note(after)));
    }
    if (!is_valid(before)) fmt::print("  {}: {}\n", a.files[0], invalidity_of(before));
    if (!is_valid(after)) fmt::print("  {}: {}\n", a.files[1], invalidity_of(after));
  }
  return is_valid(before) && is_valid(after) && is_accepted(after) ? kDone : kStoppedEarly;
}

CLI::App* add_common(CLI::App& app, const char* name, const char* description,
                     const std::shared_ptr<InspectArguments>& a) {
  CLI::App* c = app.add_subcommand(name, description);
  c->add_flag("--json", a->json, "Print JSON");
  c->add_option("--threads", a->threads, "CPU threads; 0: all")->check(CLI::Range(0, 4096))->capture_default_str();
  c->add_option("--tags", a->tags, kTagsHelp)->option_text("NAME");
  c->add_option("--criteria", a->criteria, criteria_help("Judge the mesh (of two: the second) by"))
      ->option_text("NAME|FILE");
  c->add_option("--worst", a->worst, "Number of the worst tetrahedra to list")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  return c;
}

}  // namespace

void add_info(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<InspectArguments>();
  CLI::App* c = add_common(app, "info",
                           "Numbers of elements, tags, validity and quality of a mesh, and its worst tetrahedra.", a);
  c->add_option("MESH", a->files[0], "Mesh: " + readable_endings() + "; or - for the standard input (MEDIT)")
      ->required();
  c->add_option(
       "--cell-data", a->cell_data,
       "Write all measures of each tetrahedron: to a MEDIT solution file (.sol), or with the mesh (.vtu, .vtk, "
       ".e, .msh)")
      ->option_text("OUT");
  c->add_option(
       "--min-quality", a->min_quality,
       "Exit code 1 unless the worst element has this mean ratio, or this value of any measure, or a better one: "
       "0.2, min_dihedral_deg=10, radius_ratio=5. May be repeated")
      ->option_text("Q|MEASURE=Q")
      ->allow_extra_args(false);
  define_geometry(
      *c, a->geometry, c->get_option("--json")->get_group(),
      "CAD model of the part (.step, .stp, .iges, .igs, .brep, .brp): which of its vertices, edges and faces "
      "the mesh's surface is on, and how far from them");
  c->add_option(
       "-o,--output", a->classified,
       "With --geometry: mesh to write, whose surface has the numbers of faces and edges of the model as tags "
       "and as data, and whose vertices have data of the dimension, the number and the distance of their entity")
      ->option_text("FILE");
  c->add_flag("--check", a->check, "Print one line: whether the mesh is valid, and meets --min-quality");
  check_values(*c);
  c->callback([c, a, &exit_code] { exit_code = info(*c, *a); });
}

void add_compare(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<InspectArguments>();
  CLI::App* c =
      add_common(app, "compare", "Differences of two meshes of the same shape: quality, volume, surface, tags.", a);
  c->add_option("BEFORE", a->files[0], "Mesh before")->required();
  c->add_option("AFTER", a->files[1], "Mesh after")->required();
  check_values(*c);
  c->callback([a, &exit_code] { exit_code = compare_files(*a); });
}

}  // namespace tetune::cli

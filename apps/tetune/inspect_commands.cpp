// SPDX-License-Identifier: Apache-2.0
// info and compare: look, and change no mesh.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "commands.hpp"
#include "console.hpp"
#include "definitions.hpp"
#include "mesh_files.hpp"
#include "option_values.hpp"
#include "report_files.hpp"
#include "tables.hpp"
#include "tetune/io.hpp"

namespace tetune::cli {
namespace {

struct Arguments {
  std::array<std::string, 2> files;  ///< the second of compare alone
  std::string cell_data;
  std::string tags;
  std::vector<std::string> min_quality;
  bool json = false;
  bool check = false;
  int threads = 0;
  int worst = 10;
};

/// --tags names data of the first file; the second, where it lacks them, has them as its tags.
TetMesh read(const Arguments& a, std::size_t file) {
  const std::string& path = a.files[file];
  Input input = read_input(path, a.threads);
  const auto& data = input.mesh.tet_data;
  const bool lacks = std::none_of(data.begin(), data.end(), [&](const DataArray& d) { return d.name == a.tags; });
  choose_tags(input, path, file > 0 && lacks ? "" : a.tags);
  for (const std::string& w : input.warnings) say(stderr, fmt::format("tetune: warning: {}\n", w));
  return std::move(input.mesh);
}

/// What is measured of one file. Quality is that of the elements as they are, and is left out where indices are wild.
struct Inspection {
  TetMesh mesh;
  ValidationReport validity;
  Quality quality;
  bool measured = true;
};

Inspection inspect(const Arguments& a, std::size_t file) {
  Inspection i;
  i.mesh = read(a, file);
  i.validity = validate(i.mesh, a.threads);
  try {
    i.quality = measure_all(i.mesh, a.threads, a.worst);
  } catch (const MeshError&) {
    i.measured = false;
  }
  return i;
}

/// How the worst element stands to a bound.
struct Verdict {
  Target bound;
  double worst;
  bool met;
};

std::vector<Verdict> judge(const Quality& q, const std::vector<Target>& bounds) {
  std::vector<Verdict> verdicts;
  for (const Target& b : bounds) {
    const bool up = larger_is_better(b.measure);
    const double worst = up ? q.of(b.measure).min : q.of(b.measure).max;
    verdicts.push_back({b, worst, up ? worst >= b.value : worst <= b.value});
  }
  return verdicts;
}

std::string to_text(const Verdict& v) {
  const bool up = larger_is_better(v.bound.measure);
  return fmt::format("{} {:.6g}, {} {} {:.6g}", to_string(v.bound.measure), v.worst, v.met ? "as asked" : "NOT",
                     up ? ">=" : "<=", v.bound.value);
}

int info(const Arguments& a) {
  const std::string name = shown_name(a.files[0], false);
  std::vector<Target> bounds;
  for (const std::string& text : a.min_quality) bounds.push_back(parse_bound(text));
  const Inspection i = inspect(a, 0);
  const std::vector<Verdict> verdicts = i.measured ? judge(i.quality, bounds) : std::vector<Verdict>{};
  const bool met = i.measured && std::all_of(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return v.met; });
  const bool some = !i.mesh.tets.empty();
  const int code = some && i.validity.ok() && (met || bounds.empty()) ? kDone : kStoppedEarly;
  if (!a.cell_data.empty()) {
    if (!i.measured) throw MeshError(name + ": " + validity_message(i.validity));
    std::vector<std::string> warnings;
    write_measures(a.cell_data, i.mesh, a.threads, &warnings);
    for (const std::string& w : warnings) say(stderr, fmt::format("tetune: warning: {}\n", w));
  }
  if (a.json) {
    nlohmann::ordered_json json = {
        {"file", a.files[0]}, {"counts", counts_json(i.mesh)}, {"validity", to_json(i.validity)}};
    const Box box = bounding_box(i.mesh);
    json["box"] = {{"low", box.low}, {"high", box.high}, {"diagonal", box.diagonal()}};
    if (i.measured) json["quality"] = to_json(i.quality);
    for (const Verdict& v : verdicts) {
      json["bounds"].push_back(
          {{"measure", to_string(v.bound.measure)}, {"value", v.bound.value}, {"worst", v.worst}, {"met", v.met}});
    }
    fmt::print("{}", json_text(json));
  } else if (a.check) {
    std::string text = !i.validity.ok() ? validity_message(i.validity) : some ? "valid" : "there is no tetrahedron";
    for (std::size_t at = 0; (at = text.find("\n  ")) != std::string::npos;) {
      text.replace(at, 3, text[at - 1] == ':' ? " " : "; ");
    }
    for (const Verdict& v : verdicts) text += "; " + to_text(v);
    fmt::print("{}: {}\n", name, text);
  } else {
    const Box box = bounding_box(i.mesh);
    fmt::print("{}\n{}", name, mesh_summary(i.mesh));
    fmt::print("  box                     {:.6g} {:.6g} {:.6g} to {:.6g} {:.6g} {:.6g}, diagonal {:.6g}\n", box.low[0],
               box.low[1], box.low[2], box.high[0], box.high[1], box.high[2], box.diagonal());
    if (i.measured && some) fmt::print("  volume                  {:.6g}\n", i.quality.volume);
    if (i.validity.ok() && !some) {
      fmt::print("  there is no tetrahedron\n");
    } else if (i.validity.ok()) {
      fmt::print("  valid: every volume positive, every face on one or two tetrahedra, boundary closed\n");
    } else {
      fmt::print("  {}\n", validity_message(i.validity));
    }
    if (i.measured && some) {
      const auto& findings = i.validity.findings;
      const bool inverted = std::any_of(findings.begin(), findings.end(),
                                        [](const Finding& f) { return f.defect == Defect::inverted_tet; });
      if (inverted) fmt::print("  inverted tetrahedra are measured as if they were not\n");
      fmt::print("{}{}", quality_table({""}, {i.quality}), measure_table("measures", i.quality));
      fmt::print("{}{}", worst_table("worst, counted from 1", i.quality), histogram(i.quality));
    }
    for (const Verdict& v : verdicts) fmt::print("  {}\n", to_text(v));
  }
  return code;
}

int compare_files(const Arguments& a) {
  const Inspection before = inspect(a, 0);
  const Inspection after = inspect(a, 1);
  if (!before.measured || !after.measured) {
    const bool first = !before.measured;
    throw MeshError(a.files[first ? 0 : 1] + ": " + validity_message(first ? before.validity : after.validity));
  }
  const Comparison c = compare(before.mesh, after.mesh, a.threads);
  if (a.json) {
    const nlohmann::ordered_json json = {
        {"before",
         {{"file", a.files[0]}, {"validity", to_json(before.validity)}, {"quality", to_json(before.quality)}}},
        {"after", {{"file", a.files[1]}, {"validity", to_json(after.validity)}, {"quality", to_json(after.quality)}}},
        {"change", to_json(c)}};
    fmt::print("{}", json_text(json));
  } else {
    fmt::print("{}{}{}{}{}{}", quality_table({"before", "after"}, {before.quality, after.quality}),
               measure_table("measures before", before.quality), measure_table("measures after", after.quality),
               worst_table("worst before", before.quality), worst_table("worst after", after.quality),
               comparison_table(c));
    if (!before.validity.ok()) fmt::print("  {}: {}\n", a.files[0], validity_message(before.validity));
    if (!after.validity.ok()) fmt::print("  {}: {}\n", a.files[1], validity_message(after.validity));
  }
  return before.validity.ok() && after.validity.ok() ? kDone : kStoppedEarly;
}

CLI::App* add_common(CLI::App& app, const char* name, const char* description, const std::shared_ptr<Arguments>& a) {
  CLI::App* c = app.add_subcommand(name, description);
  c->add_flag("--json", a->json, "Print JSON");
  c->add_option("--threads", a->threads, "CPU threads; 0: all")->check(CLI::Range(0, 4096))->capture_default_str();
  c->add_option("--tags", a->tags, kTagsHelp)->option_text("NAME");
  c->add_option("--worst", a->worst, "How many of the worst tetrahedra to list")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  return c;
}

}  // namespace

void add_info(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<Arguments>();
  CLI::App* c = add_common(app, "info", "Counts, tags, validity and quality of a mesh, and its worst tetrahedra.", a);
  c->add_option("MESH", a->files[0], "Mesh: " + readable_endings() + "; or - for the standard input (MEDIT)")
      ->required();
  c->add_option("--cell-data", a->cell_data,
                "Write all measures of every tetrahedron: to a MEDIT solution file (.sol), or with the mesh (.vtu, "
                ".vtk, .e, .msh)")
      ->option_text("OUT");
  c->add_option("--min-quality", a->min_quality,
                "Exit code 1 unless the worst element has this mean ratio or more; or any measure, for example "
                "min_dihedral_deg=10 or radius_ratio=5. May be repeated")
      ->option_text("Q|MEASURE=Q")
      ->allow_extra_args(false);
  c->add_flag("--check", a->check, "One line: whether the mesh is valid, and has what --min-quality asks for");
  refuse_empty_values(*c);
  c->callback([a, &exit_code] { exit_code = info(*a); });
}

void add_compare(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<Arguments>();
  CLI::App* c =
      add_common(app, "compare", "What changed between two meshes of one shape: quality, volume, surface, tags.", a);
  c->add_option("BEFORE", a->files[0], "Mesh before")->required();
  c->add_option("AFTER", a->files[1], "Mesh after")->required();
  refuse_empty_values(*c);
  c->callback([a, &exit_code] { exit_code = compare_files(*a); });
}

}  // namespace tetune::cli

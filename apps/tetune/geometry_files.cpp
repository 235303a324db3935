// SPDX-License-Identifier: Apache-2.0
#include "geometry_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "definitions.hpp"
#include "option_flags.hpp"
#include "system/child_process.hpp"
#include "tetune/error.hpp"

namespace tetune::cli {
namespace {

std::string unit_names() {
  std::string names;
  for (const LengthUnit& u : kLengthUnits) names += (names.empty() ? "" : ", ") + std::string(u.name);
  return names;
}

double largest_distance(const GeometryMatch& match) {
  return match.distances.empty() ? 0 : *std::max_element(match.distances.begin(), match.distances.end());
}

}  // namespace

std::future<Geometry> start_reading(const GeometryArguments& a, int threads) {
  if (a.file.empty()) return {};
  // Where there are no processes there may be no threads either, and the constructor refuses at once.
  const std::launch policy = has_child_processes() ? std::launch::async | std::launch::deferred : std::launch::deferred;
  return std::async(policy, [&a, threads] { return Geometry(a.file, unit_in_mm(a.unit), threads); });
}

double unit_in_mm(const std::string& unit) {
  for (const LengthUnit& u : kLengthUnits) {
    if (unit == u.name) return u.mm;
  }
  double mm = 0;
  if (CLI::detail::lexical_cast(unit, mm) && mm > 0 && std::isfinite(mm)) return mm;
  throw OptionError("--geometry-unit: '" + unit + "' is not one of " + unit_names() + ", nor a length in mm");
}

void define_geometry(CLI::App& command, GeometryArguments& a, const std::string& group, const std::string& purpose) {
  command.add_option("--geometry", a.file, purpose)->option_text("FILE")->group(group);
  command
      .add_option("--geometry-unit", a.unit,
                  "With --geometry: the mesh's unit, " + unit_names() +
                      " or a number of mm, to which the geometry is converted; BREP files are in mm")
      ->option_text("UNIT")
      ->default_str("mm")
      ->group(group);
}

void define_geometry_to_slide_on(CLI::App& command, GeometryArguments& a) {
  constexpr const char* kGroup = "Surface and constraints";
  define_geometry(
      command, a, kGroup,
      "With --boundary slide: CAD model of the part (.step, .stp, .iges, .igs, .brep, .brp). Vertices of the "
      "surface end on its faces and edges, those at its vertices stay");
  command
      .add_option("--snap", a.snap,
                  "With --geometry: whether vertices that are a little off the geometry are first moved onto it")
      ->check(is_word({"yes", "no"}))
      ->default_str("yes")
      ->group(kGroup);
}

std::vector<std::string> flags_without_geometry(const CLI::App& command, const GeometryArguments& a) {
  std::vector<std::string> warnings;
  for (const char* option : {"--geometry-unit", "--snap"}) {
    const CLI::Option* given = a.file.empty() ? command.get_option_no_throw(option) : nullptr;
    if (given != nullptr && given->count() > 0)
      warnings.push_back(std::string(option) + " has no effect without --geometry");
  }
  return warnings;
}

void check_geometry_arguments(const CLI::App& command, OptimizeArguments& a) {
  unit_in_mm(a.geometry.unit);
  for (std::string& text : flags_without_geometry(command, a.geometry)) a.warnings.push_back(std::move(text));
  if (a.geometry.file.empty()) return;
  if (a.options.boundary != Boundary::slide) throw OptionError("--geometry needs --boundary slide");
  if (!a.criteria_name.empty())
    throw OptionError("--geometry and --criteria exclude each other: judge by `tetune info`");
}

std::string with_library_flags(const std::string& text) {
  constexpr std::pair<std::string_view, std::string_view> kNames[] = {
      {"geometry_unit=", "--geometry-unit "},
      {"(order 1)", "(--order 1)"},
      {"(order 1: an empty curved_edges)", "(tetune convert --order 1)"}};
  std::string flags = with_flags(text);
  for (const auto& [name, flag] : kNames) {
    if (const auto at = flags.find(name); at != std::string::npos) flags.replace(at, name.size(), flag);
  }
  return flags;
}

TetMesh classified_mesh(const TetMesh& mesh, const GeometryMatch& match) {
  TetMesh out;
  out.points = mesh.points;
  out.point_tags = mesh.point_tags;
  out.tets = mesh.tets;
  out.tet_tags = mesh.tet_tags;
  out.triangles = match.triangles;
  out.triangle_tags.assign(match.faces.begin(), match.faces.end());
  out.edges = match.edges;
  out.edge_tags.assign(match.edge_numbers.begin(), match.edge_numbers.end());
  std::vector<std::int32_t> dimensions, numbers;
  for (const GeometryEntity& entity : match.vertices) {
    dimensions.push_back(entity.dimension);
    numbers.push_back(entity.number);
  }
  out.point_data = {{"geometry:dimension", 1, dimensions},
                    {"geometry:number", 1, numbers},
                    {"geometry:distance", 1, match.distances}};
  out.triangle_data = {{"geometry:face", 1, match.faces}};
  out.edge_data = {{"geometry:edge", 1, match.edge_numbers}};
  return out;
}

std::string match_table(const Geometry& geometry, const GeometryMatch& match) {
  const auto counts = geometry.counts();
  std::string text =
      fmt::format("  geometry                {} vertices, {} edges, {} faces, {} solids, diagonal {:.6g}\n", counts[0],
                  counts[1], counts[2], counts[3], geometry.diagonal());
  text += fmt::format("  vertices on geometry    {} on vertices, {} on edges, {} on faces; largest distance {:.3e}\n",
                      match.on_entities[0], match.on_entities[1], match.on_entities[2], largest_distance(match));
  if (match.without_entity > 0) {
    text += fmt::format("  not on the geometry     {} vertices; {} triangles for which two faces are about as near\n",
                        match.without_entity, match.ambiguous_triangles);
  }
  if (match.file_surfaces_differing > 0) {
    text +=
        fmt::format("  surfaces of the file    {} of {} are not on the face of the same number: found by distance\n",
                    match.file_surfaces_differing, match.file_surfaces);
  }
  if (match.unmatched_vertices > 0) {
    text += fmt::format("  without a vertex        {} vertices of the geometry\n", match.unmatched_vertices);
  }
  return text;
}

nlohmann::ordered_json to_json(const Geometry& geometry, const GeometryMatch& match) {
  const auto counts = geometry.counts();
  return {{"file", geometry.file()},
          {"vertices", counts[0]},
          {"edges", counts[1]},
          {"faces", counts[2]},
          {"solids", counts[3]},
          {"box", {{"low", geometry.low()}, {"high", geometry.high()}}},
          {"mesh_vertices_on_vertices", match.on_entities[0]},
          {"mesh_vertices_on_edges", match.on_entities[1]},
          {"mesh_vertices_on_faces", match.on_entities[2]},
          {"mesh_vertices_without_entity", match.without_entity},
          {"ambiguous_triangles", match.ambiguous_triangles},
          {"vertices_without_mesh_vertex", match.unmatched_vertices},
          {"surfaces_of_the_file", match.file_surfaces},
          {"surfaces_with_other_numbers", match.file_surfaces_differing},
          {"largest_distance", largest_distance(match)}};
}

std::vector<std::string> geometry_warnings(const GeometryReport& r) {
  if (r.vertices_left_off == 0) return {};
  return {fmt::format(
      "{} vertices stay off the geometry, by up to {:.3g}: required entities, --freeze or elements of other kinds hold "
      "them",
      r.vertices_left_off, r.largest_left_off)};
}

std::string geometry_summary(const Geometry& geometry, const GeometryReport& r) {
  std::string text = match_table(geometry, r.after);
  if (r.vertices_snapped > 0 && r.snapped > 0) {
    text += fmt::format("  moved onto geometry     {} vertices{}\n", r.vertices_snapped,
                        r.snapped < 1
                            ? fmt::format(", {:.1f} % of the way: further, elements would be inverted", 100 * r.snapped)
                            : "");
  }
  if (r.vertices_held > 0)
    text += fmt::format("  held on geometry        {} vertices beside bad elements\n", r.vertices_held);
  if (r.vertices_left_off > 0) {
    text += fmt::format("  left off geometry       {} vertices that are held, by up to {:.3e}\n", r.vertices_left_off,
                        r.largest_left_off);
  }
  if (r.rounds == 0) text += "  surface                 it did not slide: elements would be worse\n";
  const auto line = [&](const char* name, const DistanceSummary& before, const DistanceSummary& after) {
    text += fmt::format("  {:<24}{:>12.3e}{:>12.3e}{:>12.3e}{:>12.3e}\n", name, before.largest, after.largest,
                        before.mean, after.mean);
  };
  text +=
      fmt::format("  {:<24}{:>12}{:>12}{:>12}{:>12}\n", "distance from geometry", "largest", "after", "mean", "after");
  line("  of vertices", r.deviation_before.vertices, r.deviation_after.vertices);
  line("  of edge midpoints", r.deviation_before.midpoints, r.deviation_after.midpoints);
  line("  of triangle centers", r.deviation_before.centers, r.deviation_after.centers);
  return text;
}

namespace {

nlohmann::ordered_json distances_json(const DistanceSummary& s) {
  return {{"points", s.points}, {"largest", s.largest}, {"mean", s.mean}};
}

nlohmann::ordered_json deviation_json(const GeometryDeviation& d) {
  nlohmann::ordered_json json = {{"vertices", distances_json(d.vertices)},
                                 {"edge_midpoints", distances_json(d.midpoints)},
                                 {"triangle_centers", distances_json(d.centers)}};
  json["faces"] = nlohmann::ordered_json::array();
  for (const GeometryDeviation::Face& f : d.faces) {
    json["faces"].push_back({{"face", f.number},
                             {"vertices", distances_json(f.vertices)},
                             {"edge_midpoints", distances_json(f.midpoints)},
                             {"triangle_centers", distances_json(f.centers)}});
  }
  return json;
}

}  // namespace

nlohmann::ordered_json to_json(const Geometry& geometry, const GeometryReport& r) {
  nlohmann::ordered_json json = to_json(geometry, r.after);
  json["vertices_snapped"] = r.vertices_snapped;
  json["snapped"] = r.snapped;
  json["rounds"] = r.rounds;
  json["vertices_held"] = r.vertices_held;
  json["vertices_left_off"] = r.vertices_left_off;
  json["largest_left_off"] = r.largest_left_off;
  json["distance_before"] = deviation_json(r.deviation_before);
  json["distance_after"] = deviation_json(r.deviation_after);
  return json;
}

}  // namespace tetune::cli

// SPDX-License-Identifier: Apache-2.0
#include "move_targets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tetune/error.hpp"
#include "tetune/io.hpp"

namespace tetune::cli {
namespace {

constexpr const char* kMotion = "Motion";

void define_motion(CLI::App& c, MoveArguments& a) {
  c.add_option("--to", a.to,
               "Mesh with as many vertices as the input, which are its positions after the motion; with --displacement "
               "a mesh with that point data. May be repeated: the targets are reached one after the other")
      ->option_text("FILE")
      ->allow_extra_args(false)
      ->group(kMotion);
  c.add_option("--displacement", a.displacement,
               "Name of point data with three numbers per vertex, or of three with _x, _y, _z after it: how far each "
               "vertex of the input moves, with NaN for a vertex that follows the others. Without --to they are read "
               "from the input")
      ->option_text("NAME")
      ->group(kMotion);
  c.add_option(
       "--patches", a.patches,
       "Patches, by their tags or the names of their groups, whose vertices move as the target says; the others "
       "follow. Default: the vertices of the boundary, of interfaces between regions, of listed triangles and tagged "
       "edges, and other listed ones")
      ->option_text("TAG|NAME,...")
      ->delimiter(',')
      ->group(kMotion);
  c.add_flag("--all-vertices", a.all_vertices, "All vertices move as the target says, those inside the mesh too")
      ->group(kMotion);
}

const DataArray* find_point_data(const TetMesh& mesh, const std::string& name) {
  for (const DataArray& array : mesh.point_data) {
    if (array.name == name) return &array;
  }
  return nullptr;
}

/// The arrays of a displacement: one of this name, or three with _x, _y, _z (or capitals) after it.
std::vector<const DataArray*> find_displacement(const TetMesh& source, const std::string& path,
                                                const std::string& name) {
  std::vector<const DataArray*> found{find_point_data(source, name)};
  if (found[0] != nullptr) {
    if (found[0]->components == 3) return found;
    throw OptionError(fmt::format("--displacement \"{}\": {} has {} numbers per vertex; a displacement has 3", name,
                                  path, found[0]->components));
  }
  for (const char* const axes : {"xyz", "XYZ"}) {
    found.clear();
    for (const char* axis = axes; *axis != '\0'; ++axis) found.push_back(find_point_data(source, name + "_" + *axis));
    const auto is_scalar = [](const DataArray* array) { return array != nullptr && array->components == 1; };
    if (std::all_of(found.begin(), found.end(), is_scalar)) return found;
  }
  throw OptionError(fmt::format("--displacement \"{}\": {} has no point data of this name; it has: {}", name, path,
                                point_data_names(source)));
}

/// The input's positions plus the point data `name` of `source`.
std::vector<Point3> displaced(const TetMesh& mesh, const TetMesh& source, const std::string& path,
                              const std::string& name) {
  std::vector<Point3> points = mesh.points;
  std::size_t first = 0;
  for (const DataArray* array : find_displacement(source, path, name)) {
    const auto components = std::size_t(array->components);
    const auto add = [&](const auto& values) {
      auto value = values.begin();
      for (Point3& p : points) {
        for (std::size_t k = first; k < first + components; ++k) p[k] += static_cast<double>(*value++);
      }
    };
    std::visit(add, array->values);
    first += components;
  }
  return points;
}

void check_count(const TetMesh& mesh, const TetMesh& source, const std::string& path) {
  if (source.points.size() == mesh.points.size()) return;
  throw OptionError(
      fmt::format("--to {}: it has {} vertices, and the input has {}; both must have the same vertices in "
                  "the same order",
                  path, source.points.size(), mesh.points.size()));
}

/// Throws OptionError for a vertex with NaN in some components: it stands for no target in all three only.
void check_nan(const VertexTargets& target, const std::string& path, const MoveArguments& a) {
  for (std::size_t v = 0; v < target.size(); ++v) {
    const auto count = std::count_if(target[v].begin(), target[v].end(), [](double x) { return std::isnan(x); });
    if (count == 0 || count == 3) continue;
    const std::string option = a.displacement.empty() ? "--to" : fmt::format("--displacement \"{}\"", a.displacement);
    throw OptionError(fmt::format(
        "{}: vertex {} of {} has NaN in {} of its three components; a vertex that follows the others has it "
        "in all three",
        option, v, path, count));
  }
}

}  // namespace

std::string point_data_names(const TetMesh& mesh) {
  std::string names;
  for (const DataArray& array : mesh.point_data) names += (names.empty() ? "" : ", ") + array.name;
  return names.empty() ? "none" : names;
}

void define_move_arguments(CLI::App& command, OptimizeArguments& arguments) {
  define_motion(command, arguments.move.emplace());
}

void check_move_arguments(const MoveArguments& a, bool has_series) {
  if (!has_series && a.to.empty() && a.displacement.empty()) {
    throw OptionError(
        "no target: name a mesh with --to, or point data with --displacement, or move a time series (.pvd, Exodus)");
  }
  if (a.all_vertices && !a.patches.empty()) {
    throw OptionError("--all-vertices and --patches exclude each other; give one of them");
  }
}

VertexTargets target_of(const TetMesh& mesh, const TetMesh& source, const std::string& path, const MoveArguments& a) {
  VertexTargets target = a.displacement.empty() ? source.points : displaced(mesh, source, path, a.displacement);
  check_nan(target, path, a);
  if (a.all_vertices) return target;
  return surface_targets(mesh, target, find_patches("--patches", a.patches, "the input", mesh));
}

std::vector<VertexTargets> read_targets(const TetMesh& mesh, const MoveArguments& a, int threads,
                                        std::vector<std::string>& warnings) {
  std::vector<VertexTargets> targets;
  const auto add = [&](const TetMesh& source, const std::string& path) {
    check_count(mesh, source, path);
    targets.push_back(target_of(mesh, source, path, a));
  };
  for (const std::string& path : a.to) {
    std::vector<std::string> read_warnings;
    add(read_mesh(path, &read_warnings, threads), path);
    warnings.insert(warnings.end(), read_warnings.begin(), read_warnings.end());
  }
  if (a.to.empty()) add(mesh, "the input");
  return targets;
}

std::string blocked_text(const std::string& output, const std::string& target, double fraction) {
  return fmt::format(
      "{}: motion blocked {}, after {:.4g} % of the way there: the valid mesh of that fraction was written; move less, "
      "or in more steps; -v 1 lists the elements that block it",
      output, target, 100 * fraction);
}

std::string move_summary(const MoveReport& r, const TetMesh& mesh) {
  std::string text = fmt::format("  moved {} vertices to {} of {} targets in {} steps\n", r.prescribed,
                                 r.targets_reached, r.targets, r.steps.size());
  if (r.reached()) return text;
  text += fmt::format("  target {}: stopped after {:.4g} % of the way\n", r.targets_reached + 1, 100 * r.fraction);
  if (r.blocking_tets.empty()) return text;
  const auto list = [](const std::vector<Index>& ids) {
    constexpr std::size_t kListed = 5;
    std::string ids_text;
    for (std::size_t i = 0; i < std::min(kListed, ids.size()); ++i) {
      ids_text += fmt::format("{}{}", i == 0 ? "" : ", ", ids[i] + 1);
    }
    return ids_text + (ids.size() > kListed ? ", ..." : "");
  };
  Point3 center{};
  for (const Index v : mesh.tets.begin()[r.blocking_tets[0]]) {
    for (std::size_t k = 0; k < 3; ++k) center[k] += 0.25 * mesh.points.begin()[v][k];
  }
  const char* const at_least = r.blocking_tets.size() < kMaxBlocking ? "" : "at least ";
  text += fmt::format("  {}{} tetrahedra of the result block it ({}; the first near {:.6g} {:.6g} {:.6g})", at_least,
                      r.blocking_tets.size(), list(r.blocking_tets), center[0], center[1], center[2]);
  if (!r.blocking_vertices.empty()) text += fmt::format(", with the motion of vertices {}", list(r.blocking_vertices));
  return text + "\n";
}

nlohmann::ordered_json to_json(const MoveReport& r) {
  const auto one_based = [](const std::vector<Index>& ids) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const Index id : ids) list.push_back(id + 1);
    return list;
  };
  nlohmann::ordered_json steps = nlohmann::ordered_json::array();
  for (const MoveStep& s : r.steps) {
    steps.push_back({{"target", s.target + 1},
                     {"fraction", s.fraction},
                     {"solver_iterations", s.solver_iterations},
                     {"dihedral_min_moved_deg", s.dihedral_moved},
                     {"dihedral_min_deg", s.dihedral_min},
                     {"seconds", s.seconds}});
  }
  nlohmann::ordered_json inverted = nlohmann::ordered_json::array();
  for (const InvertedOthers& others : r.inverted_others) {
    inverted.push_back({{"kind", others.kind}, {"elements", one_based(others.elements)}});
  }
  return {{"vertices_prescribed", r.prescribed},
          {"targets", r.targets},
          {"targets_reached", r.targets_reached},
          {"fraction", r.fraction},
          {"blocking_tetrahedra", one_based(r.blocking_tets)},
          {"blocking_vertices", one_based(r.blocking_vertices)},
          {"frozen_vertices_moved", r.frozen_moved},
          {"inverted_elements", inverted},
          {"steps", steps}};
}

}  // namespace tetune::cli

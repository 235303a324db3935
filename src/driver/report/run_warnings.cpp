// SPDX-License-Identifier: Apache-2.0
#include "driver/report/run_warnings.hpp"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <utility>
#include <variant>

#include "mesh/transfer/floating_data.hpp"
#include "tetune/option_table.hpp"

namespace tetune {
namespace {

/// The number of warnings that may be added after the run: on fields, two on numbers, two of the run, on frozen
/// vertices, and one per block of other elements.
std::size_t max_further(const TetMesh& mesh) { return 6 + mesh.others.size(); }

/// Whether the values are integers that increase from entry to entry, as numbers of entities do.
bool is_numbering(const DataArray& array) {
  return array.components == 1 && !is_floating(array) &&
         std::visit(
             [](const auto& values) {
               return values.size() > 1 &&
                      std::adjacent_find(values.begin(), values.end(), std::greater_equal<>()) == values.end();
             },
             array.values);
}

/// A warning of the arrays that number entities, or an empty one.
std::string warn_of_numbers(const std::vector<DataArray>& data, const char* entities, const char* reason) {
  std::string names;
  for (const DataArray& array : data) {
    if (is_numbering(array)) names += (names.empty() ? "" : ", ") + array.name;
  }
  if (names.empty()) return names;
  return "the values of " + names + " number the " + entities + " of the input; " + reason +
         "; numbers may occur more than once in the result, and others not at all";
}

bool changes_connectivity(const Report& report) {
  const auto has_happened = [&](const auto& kind) { return report.*kind.count > 0; };
  return std::any_of(kOperationCounts.begin(), kOperationCounts.end(), has_happened);
}

bool has_moved(const Report& report) {
  const auto moved = [](const auto& step) { return step.moved > 0; };
  return std::any_of(report.sweeps.begin(), report.sweeps.end(), moved) ||
         std::any_of(report.worst_rounds.begin(), report.worst_rounds.end(), moved);
}

}  // namespace

RunWarnings::RunWarnings(const TetMesh& mesh, const Options& options) : warnings_(ineffective_options(options)) {
  warnings_.reserve(warnings_.size() + max_further(mesh));
  of_vertex_numbers_ = warn_of_numbers(mesh.point_data, "vertices", "inserted vertices have that of a neighbor");
  of_tet_numbers_ = warn_of_numbers(mesh.tet_data, "tetrahedra", "new ones have that of the one they descend from");
  if (options.data != DataTransfer::carry) return;
  std::string names;
  for (const DataArray& array : mesh.point_data) {
    if (!is_floating(array)) continue;
    fields_.push_back(array.name);
    names += (names.empty() ? "" : ", ") + array.name;
  }
  of_fields_ = "the values of " + names +
               " moved with their vertices; if they sample a field, data=interpolate or data=conserve evaluates it at "
               "the new positions";
}

void RunWarnings::add_to(Report& report, std::vector<std::string> of_run, bool moved_besides) {
  report.moved_fields.clear();
  if (!fields_.empty() && (moved_besides || has_moved(report))) {
    warnings_.push_back(std::move(of_fields_));
    report.moved_fields.swap(fields_);
  }
  report.repeated_numbers.clear();
  if (report.vertices_inserted > 0) add_numbers(of_vertex_numbers_, report);
  if (changes_connectivity(report)) add_numbers(of_tet_numbers_, report);
  for (std::string& warning : of_run) warnings_.push_back(std::move(warning));
  report.warnings.swap(warnings_);
}

void RunWarnings::add_numbers(const std::string& text, Report& report) {
  if (text.empty()) return;
  warnings_.push_back(text);
  report.repeated_numbers.push_back(text);
}

std::vector<std::string> warn_of_smaller_angle(const Quality& before, const Quality& after) {
  constexpr double kAccuracy = 1e-9;  // degrees
  if (after.dihedral_min >= before.dihedral_min - kAccuracy) return {};
  char text[256];
  std::snprintf(text, sizeof text,
                "the smallest dihedral angle is %.3g degrees, and was %.3g in the input: curved elements that were not "
                "valid needed the space; effort=best and boundary=slide enlarge it",
                after.dihedral_min, before.dihedral_min);
  return {text};
}

}  // namespace tetune

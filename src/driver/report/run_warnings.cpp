// SPDX-License-Identifier: Apache-2.0
#include "driver/report/run_warnings.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "mesh/transfer/floating_data.hpp"
#include "tetune/option_table.hpp"

namespace tetune {
namespace {

/// The number of warnings that may be added after the run: on fields, two of the run, on frozen vertices, and one per
/// block of other elements.
std::size_t max_further(const TetMesh& mesh) { return 4 + mesh.others.size(); }

bool has_moved(const Report& report) {
  const auto moved = [](const auto& step) { return step.moved > 0; };
  return std::any_of(report.sweeps.begin(), report.sweeps.end(), moved) ||
         std::any_of(report.worst_rounds.begin(), report.worst_rounds.end(), moved);
}

}  // namespace

RunWarnings::RunWarnings(const TetMesh& mesh, const Options& options) : warnings_(ineffective_options(options)) {
  warnings_.reserve(warnings_.size() + max_further(mesh));
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
  for (std::string& warning : of_run) warnings_.push_back(std::move(warning));
  report.warnings.swap(warnings_);
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

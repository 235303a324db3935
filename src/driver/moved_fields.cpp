// SPDX-License-Identifier: Apache-2.0
#include "driver/moved_fields.hpp"

#include <algorithm>
#include <string>
#include <type_traits>

namespace tetune {
namespace {

bool is_floating(const DataArray& array) {
  return std::visit(
      [](const auto& values) {
        return std::is_floating_point_v<typename std::remove_cvref_t<decltype(values)>::value_type>;
      },
      array.values);
}

bool has_moved(const Report& report) {
  const auto moved = [](const auto& step) { return step.moved > 0; };
  return std::any_of(report.sweeps.begin(), report.sweeps.end(), moved) ||
         std::any_of(report.worst_rounds.begin(), report.worst_rounds.end(), moved);
}

}  // namespace

void report_moved_fields(const TetMesh& result, const Options& options, Report& report) {
  report.moved_fields.clear();
  if (options.data != DataTransfer::carry || !has_moved(report)) return;
  std::string names;
  for (const DataArray& array : result.point_data) {
    if (!is_floating(array)) continue;
    report.moved_fields.push_back(array.name);
    names += (names.empty() ? "" : ", ") + array.name;
  }
  if (names.empty()) return;
  report.warnings.push_back("vertices moved and kept their values of " + names +
                            ": of a field, data=interpolate or data=conserve evaluates it at the new places");
}

}  // namespace tetune

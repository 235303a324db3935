// SPDX-License-Identifier: Apache-2.0
// The reports of the C interface.
#include <cstdint>
#include <vector>

#include "objects.hpp"

using tetune::c::checked;
using tetune::c::guarded;
using tetune::c::require;

const char* tetune_report_stop(const tetune_report* report) {
  const char* stop = "";
  guarded([&] { stop = to_string(checked(report).report.stop); });
  return stop;
}

double tetune_report_seconds(const tetune_report* report) {
  double seconds = 0;
  guarded([&] { seconds = checked(report).report.seconds; });
  return seconds;
}

double tetune_report_energy(const tetune_report* report, int after) {
  double energy = 0;
  guarded([&] {
    const tetune::Report& of = checked(report).report;
    energy = after != 0 ? of.energy_after : of.energy_before;
  });
  return energy;
}

const int32_t* tetune_report_original(const tetune_report* report, tetune_kind kind) {
  const tetune::Index* original = nullptr;
  guarded([&] {
    const tetune::Report& of = checked(report).report;
    const std::vector<tetune::Index>* map = kind == TETUNE_VERTICES     ? &of.vertex2original
                                            : kind == TETUNE_EDGES      ? &of.edge2original
                                            : kind == TETUNE_TRIANGLES  ? &of.triangle2original
                                            : kind == TETUNE_TETRAHEDRA ? &of.tet2original
                                                                        : nullptr;
    require(map != nullptr, "kind is not one of tetune_kind");
    if (!map->empty()) original = map->data();
  });
  return original;
}

int64_t tetune_report_warnings(const tetune_report* report) {
  std::int64_t count = 0;
  guarded([&] { count = std::ssize(checked(report).report.warnings); });
  return count;
}

const char* tetune_report_warning(const tetune_report* report, int64_t position) {
  const char* text = nullptr;
  guarded([&] {
    const auto& warnings = checked(report).report.warnings;
    require(position >= 0 && position < std::ssize(warnings), "there is no warning at this position");
    text = warnings[std::size_t(position)].c_str();
  });
  return text;
}

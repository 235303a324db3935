// SPDX-License-Identifier: Apache-2.0
#include "declined_measures.hpp"

#include <fmt/format.h>

namespace tetune::cli {

std::vector<std::string> declined_measures(const Quality& before, const Quality& after, const std::string& local) {
  // Angles up to kHarmless degrees may grow at will; beyond, one counts that is nearer to 180 degrees by kNearer.
  constexpr double kHarmless = 150, kNearer = 0.5, kLowerAngle = 0.9, kLowerRatio = 0.97;
  if (before.tets == 0 || after.tets == 0) return {};
  std::string declined;
  const auto add = [&declined](const char* name, int digits, double from, double to) {
    declined += fmt::format("{}{} {:.{}f} -> {:.{}f}", declined.empty() ? "" : ", ", name, from, digits, to, digits);
  };
  const auto to_flat = [](const Quality& q) { return 180 - q.dihedral_max; };
  if (after.dihedral_max > kHarmless && to_flat(after) < kNearer * to_flat(before))
    add("largest dihedral angle", 2, before.dihedral_max, after.dihedral_max);
  if (after.dihedral_p5 < kLowerAngle * before.dihedral_p5)
    add("angle that 5 % are below", 2, before.dihedral_p5, after.dihedral_p5);
  if (after.mean_ratio < kLowerRatio * before.mean_ratio) add("mean ratio", 4, before.mean_ratio, after.mean_ratio);
  if (declined.empty()) return {};
  return {"the worst elements improved at the expense of others (" + declined + "); " + local +
          " changes the worst ones and their neighbors alone"};
}

std::vector<std::string> changed_volume(const Comparison& change) {
  constexpr double kMaxChange = 0.02;
  if (!(change.region_volume_change > kMaxChange)) return {};
  return {fmt::format(
      "--boundary slide has changed the volume of a region by {:.1f} %: --max-deviation bounds the distance of the "
      "surfaces, --boundary preserve keeps the shape",
      100 * change.region_volume_change)};
}

}  // namespace tetune::cli

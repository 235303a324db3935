// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

namespace tetune {

/// The parts of an optimization whose time is measured and whose progress is reported.
enum class Phase {
  load,
  untangling,
  motion,
  flips,
  boundary_flips,
  rings,
  coloring,
  sweeps,
  sums,
  worst,
  angles,
  restarts,
  trace,
  targets,
  data,
  store,
};

/// The name of a phase in Report::phases. Users read these names: they do not change.
inline const char* name_of(Phase phase) {
  constexpr std::array kNames{"load",     "untangling", "motion", "flips", "boundary flips", "rings",
                              "coloring", "sweeps",     "sums",   "worst", "angles",         "restarts",
                              "trace",    "targets",    "data",   "store"};
  return kNames.at(static_cast<std::size_t>(phase));
}

/// The name of a phase in Progress::phase, where one sweep is reported at a time.
inline const char* progress_name_of(Phase phase) { return phase == Phase::sweeps ? "sweep" : name_of(phase); }

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "time_estimate.hpp"

#include <algorithm>

namespace tetune::cli {

std::optional<double> estimated_seconds(const Options& options, double read_seconds, double load_seconds, int threads) {
  if (options.termination != Termination::relative || options.relocation != Relocation::newton) return std::nullopt;
  const double files = 2 * read_seconds;
  if (options.effort != Effort::best) return files + (options.effort == Effort::fast ? 4.5 : 9) * load_seconds;
  // The time of restarts hardly depends on the size of the mesh.
  constexpr double kSecondsPerRound = 0.3;
  constexpr int kDefaultRounds = 10;
  const int rounds = options.restarts < 0 ? kDefaultRounds : options.restarts;
  return files + 50 * load_seconds + kSecondsPerRound * rounds / std::clamp(threads, 1, 4);
}

}  // namespace tetune::cli

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "tetune/options.hpp"

namespace tetune::cli {

/// The seconds that a run takes, without the transfer of data, by ratios that were measured; nothing with the
/// algorithms of the paper, whose time depends on the limits that are given. `threads`: those of the run.
std::optional<double> estimated_seconds(const Options& options, double read_seconds, double load_seconds, int threads);

}  // namespace tetune::cli

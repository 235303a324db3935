// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "console.hpp"
#include "optimize_run.hpp"

/// `tetune move` of a time series.
namespace tetune::cli {

/// Whether a name is that of a time series.
bool is_series(const std::string& path);

/// Moves the mesh of the first file of a series to the targets that the files give, one after the other, and writes
/// the mesh of each time, and the series of these. Errors are printed, and set the exit code.
JobResult run_series(const OptimizeArguments& arguments, const Job& job, Console& console);

}  // namespace tetune::cli

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "console.hpp"
#include "exit_code.hpp"
#include "optimize_arguments.hpp"
#include "tetune/quality.hpp"

namespace tetune::cli {

/// The result of one job.
struct JobResult {
  int code = kNothingWritten;
  const char* summary = "failed";
  Quality before, after;
  double seconds = 0;
};

/// Reads, improves and writes one mesh. Errors are printed, and set the exit code.
JobResult run_job(const OptimizeArguments& arguments, const Job& job, Console& console);

}  // namespace tetune::cli

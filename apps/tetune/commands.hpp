// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace tetune::cli {

/// Exit codes, as Mmg's.
enum ExitCode : int {
  kDone = 0,          ///< all went well
  kStoppedEarly = 1,  ///< stopped early or a target was missed; a valid mesh was written. Of `info` and `compare`: the
                      ///< mesh is not valid
  kNothingWritten = 2,
};

/// Each adds its subcommand; the callback stores the exit code.
void add_optimize(CLI::App& app, int& exit_code);
void add_info(CLI::App& app, int& exit_code);
void add_compare(CLI::App& app, int& exit_code);

}  // namespace tetune::cli

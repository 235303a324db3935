// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace tetune::cli {

/// Exit codes, as Mmg's.
enum ExitCode : int {
  kDone = 0,          ///< all went well
  kStoppedEarly = 1,  ///< stopped early or a target was missed; a valid mesh was written. Of `info` and `compare`: the
                      ///< mesh is not valid, or not of the quality asked for
  kNothingWritten = 2,  ///< of several meshes: for at least one
};

/// Each adds its subcommand; the callback stores the exit code.
void add_optimize(CLI::App& app, int& exit_code);
void add_info(CLI::App& app, int& exit_code);
void add_compare(CLI::App& app, int& exit_code);
void add_completion(CLI::App& app);
void add_man(CLI::App& app);
void add_report(CLI::App& app);

/// Throws OptionError: `what` is made by the Python package.
[[noreturn]] void need_python(const std::string& what);

}  // namespace tetune::cli

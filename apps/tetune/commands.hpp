// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace tetune::cli {

/// Each of these functions adds a subcommand, whose callback stores the ExitCode.
void add_optimize(CLI::App& app, int& exit_code);
void add_convert(CLI::App& app, int& exit_code);
void add_move(CLI::App& app, int& exit_code);
void add_info(CLI::App& app, int& exit_code);
void add_compare(CLI::App& app, int& exit_code);
void add_completion(CLI::App& app);
void add_man(CLI::App& app);
void add_report(CLI::App& app);

}  // namespace tetune::cli

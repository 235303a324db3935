// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "console.hpp"
#include "mesh_files.hpp"
#include "option_values.hpp"
#include "tetune/optimize.hpp"

namespace tetune::cli {

/// What follows `tetune optimize`.
struct OptimizeArguments {
  std::vector<std::string> files;  ///< inputs; without --output, one input and the output
  Job names;                       ///< of what is written, before they are filled in; no input
  std::string tags;                ///< the cell data to take for the tags; empty: the file's own
  std::string max_deviation;
  std::vector<std::string> freeze;
  std::vector<Frozen> frozen;  ///< what these say
  std::optional<double> target_dihedral;
  std::vector<std::pair<double, std::string>> target_quality;
  Options options;
  std::optional<double> time_limit;  ///< seconds
  std::optional<double> max_memory;  ///< MB of 1024 * 1024 bytes
  ProgressMode progress = ProgressMode::automatic;
  int verbosity = 1;
  bool quiet = false;
  bool dry_run = false;
  bool print_options = false;
};

/// Defines them.
void define(CLI::App& command, OptimizeArguments& arguments);

/// Refuses options that have no effect together, reads those whose values are words, and finds the inputs and outputs.
/// Throws OptionError.
std::vector<Job> settle(const CLI::App& command, OptimizeArguments& arguments);

/// All options as they are in force, by name.
nlohmann::ordered_json to_json(const Options& options);

}  // namespace tetune::cli

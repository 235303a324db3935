// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "mesh_files.hpp"
#include "option_values.hpp"
#include "tetune/criteria.hpp"
#include "tetune/optimize.hpp"

namespace tetune::cli {

enum class ProgressMode { automatic, none, json };

/// The arguments of the motion in `tetune move`.
struct MoveArguments {
  std::vector<std::string> to;       ///< files of the targets; empty: the input
  std::string displacement;          ///< point data; empty: the positions are the targets
  std::vector<std::string> patches;  ///< tags or names of groups; empty: the whole surface
  bool all_vertices = false;
};

/// The CAD geometry of `tetune optimize` and `tetune info`.
struct GeometryArguments {
  std::string file;         ///< empty: none
  std::string unit = "mm";  ///< of the mesh
  std::string snap = "yes";
};

/// The arguments of `tetune optimize` and `tetune move`.
struct OptimizeArguments {
  std::vector<std::string> files;  ///< inputs; without --output, one input and the output
  Job names;                       ///< patterns of the names of written files; its input is empty
  std::string tags;                ///< cell data to use as tags; empty: the tags of the file
  std::string page_data;           ///< file for what the page of --report-html needs; empty: no page
  std::string max_deviation;
  std::optional<Length> deviation_bound;  ///< parsed from `max_deviation`
  std::vector<std::string> periodic;      ///< axes
  std::string periodic_map;
  std::vector<std::string> freeze;
  std::vector<TagOrName> frozen;  ///< parsed from `freeze`
  std::optional<double> target_dihedral;
  std::vector<std::string> target_quality;
  std::vector<std::string> only_below;
  std::string criteria_name;
  std::optional<AcceptanceCriteria> criteria;  ///< read from `criteria_name`
  std::optional<MoveArguments> move;
  GeometryArguments geometry;
  Options options;
  std::optional<double> time_limit;  ///< seconds
  std::optional<double> max_memory;  ///< MB of 1024 * 1024 bytes
  ProgressMode progress = ProgressMode::automatic;
  int verbosity = 1;
  bool quiet = false;
  bool dry_run = false;
  bool print_options = false;
  bool replaces = false;              ///< the output is named with -o: files that exist may be replaced
  std::vector<std::string> warnings;  ///< former names, and options without effect
};

/// Defines the arguments of a command, which parsing then stores in `arguments`.
void define_arguments(CLI::App& command, OptimizeArguments& arguments);

/// After parsing: checks the options, parses those whose values are words, collects warnings, and returns one job per
/// mesh (none with --print-options). Throws OptionError.
std::vector<Job> resolve_jobs(const CLI::App& command, OptimizeArguments& arguments);

}  // namespace tetune::cli

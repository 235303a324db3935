// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "optimize_arguments.hpp"
#include "tetune/move.hpp"

/// The options that `tetune move` has beside those of `tetune optimize`.
namespace tetune::cli {

/// Defines the arguments of the motion: sets OptimizeArguments::move.
void define_move_arguments(CLI::App& command, OptimizeArguments& arguments);

/// Throws OptionError for arguments that name no target, unless they have a time series, or contradict each other.
void check_move_arguments(const MoveArguments& arguments, bool has_series);

/// The targets that the arguments name, for a mesh that was read. Throws FileError and OptionError.
std::vector<VertexTargets> read_targets(const TetMesh& mesh, const MoveArguments& arguments, int threads,
                                        std::vector<std::string>& warnings);

/// The target that a file `path` with the mesh `source` gives for `mesh`, which has as many vertices.
VertexTargets target_of(const TetMesh& mesh, const TetMesh& source, const std::string& path,
                        const MoveArguments& arguments);

/// The names of the point data of a mesh, or "none".
std::string point_data_names(const TetMesh& mesh);

/// The sentence on a motion that was blocked on the way to a target, such as "at time 2.5".
std::string blocked_text(const std::string& output, const std::string& target, double fraction);

/// How far the motion went, and what blocked it. `mesh` is the result.
std::string move_summary(const MoveReport& report, const TetMesh& mesh);
nlohmann::ordered_json to_json(const MoveReport& report);

}  // namespace tetune::cli

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tetune/tetune.hpp"

namespace tetune::cli {

/// Of what measure_all() measured.
nlohmann::ordered_json to_json(const Quality& quality);
nlohmann::ordered_json to_json(const Comparison& comparison);
nlohmann::ordered_json to_json(const Report& report);
nlohmann::ordered_json to_json(const TargetReport& report);
nlohmann::ordered_json to_json(const ValidationReport& report);
nlohmann::ordered_json counts_json(const TetMesh& mesh);

/// As files and the standard output have it, with a line's end. Names from files may hold any bytes.
std::string json_text(const nlohmann::ordered_json& json);

/// One line for each sweep and flip pass, in the order they ran.
std::string trace_csv(const Report& report);

/// Throws FileError when the folder of `path` is not there, or something at that place that is no file: to fail before
/// the work. An empty path is well.
void check_folder(const std::string& path);

}  // namespace tetune::cli

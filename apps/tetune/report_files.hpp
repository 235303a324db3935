// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tetune/tetune.hpp"

namespace tetune::cli {

/// Of the result of measure_all().
nlohmann::ordered_json to_json(const Quality& quality);
nlohmann::ordered_json to_json(const CurvedQuality& quality);
nlohmann::ordered_json to_json(const Comparison& comparison);
nlohmann::ordered_json to_json(const Report& report);
nlohmann::ordered_json to_json(const TargetReport& report);
nlohmann::ordered_json to_json(const ValidationReport& report);
nlohmann::ordered_json to_json(const AcceptanceReport& report);
/// Without its Report.
nlohmann::ordered_json to_json(const CriteriaReport& report);
nlohmann::ordered_json counts_json(const TetMesh& mesh);
/// The number of pairs of all periodic links.
std::size_t periodic_pairs(const TetMesh& mesh);

/// The JSON text with a final line break. Bytes that are not UTF-8 (in names from files) are replaced.
std::string json_text(const nlohmann::ordered_json& json);

/// One line per sweep and flip pass, in the order in which they ran.
std::string trace_csv(const Report& report);

/// Throws FileError if the folder of `path` does not exist, or if `path` exists and is not a regular file: to fail
/// before the work. An empty path is accepted.
void check_folder(const std::string& path);

}  // namespace tetune::cli

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tetune/tetune.hpp"

namespace tetune::cli {

/// `quality` is a result of measure_all().
nlohmann::ordered_json to_json(const Quality& quality);
nlohmann::ordered_json to_json(const CurvedQuality& quality);
nlohmann::ordered_json to_json(const Comparison& comparison);
nlohmann::ordered_json to_json(const Report& report);
nlohmann::ordered_json to_json(const TargetReport& report);
nlohmann::ordered_json to_json(const ValidationReport& report);
nlohmann::ordered_json to_json(const AcceptanceReport& report);
/// The report on criteria without its Report.
nlohmann::ordered_json to_json(const CriteriaReport& report);
nlohmann::ordered_json counts_json(const TetMesh& mesh);
/// Warnings of lists that the result lacks, of a mesh that was left as it is, and of point data, except for the
/// displacement of a motion, whose values moved with their vertices.
std::vector<std::string> run_warnings(const Report& report, const std::string& displacement);

/// The number of pairs of all periodic links.
std::size_t periodic_pairs(const TetMesh& mesh);

/// The JSON text with a final line break. Bytes that are not UTF-8 (in names from files) are replaced.
std::string json_text(const nlohmann::ordered_json& json);

/// One line per sweep and flip pass, in the order in which they ran.
std::string trace_csv(const Report& report);

}  // namespace tetune::cli

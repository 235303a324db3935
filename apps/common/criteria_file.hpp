// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tetune/criteria.hpp"

namespace tetune::cli {

/// Reads the criteria that `name` names: a preset, or else a TOML file with one table per measure:
///
///     [mean_ratio]
///     warn = 0.2
///     fail = 0.05
///     allowed_percent = 0.1
///
/// Throws FileError with file and line, and for an unknown name the most similar known one.
AcceptanceCriteria read_criteria(const std::string& name);

/// Reads criteria from the bytes of a TOML file; `path` stands for it in messages. A build without toml++ refuses all.
AcceptanceCriteria parse_criteria(const std::string& path, const std::string& bytes);

/// For an unknown name, as a part of a message: the most similar known one, and all of them.
std::string name_suggestion(const std::string& name, const std::vector<std::string>& known);

/// For an unknown measure, as a part of a message: the most similar known name, and all of them.
std::string measure_suggestion(const std::string& name);

/// The help text of --criteria: `action`, which ends with "by", and the criteria.
std::string criteria_help(const std::string& action);

}  // namespace tetune::cli

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

namespace tetune::cli {

/// The words of a command line for CLI11: options of Mmg after `optimize` are replaced by those of tetune, and a long
/// name with one dash gets the second. Throws OptionError for options that do not exist, with a suggestion, and if the
/// first word is no command.
std::vector<std::string> expand_aliases(const CLI::App& app, const std::vector<std::string>& words);

/// Mmg's options and their replacements, for the manual: "-ar A", "--feature-angle A".
std::vector<std::pair<std::string, std::string>> alias_table();

}  // namespace tetune::cli

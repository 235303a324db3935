// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace tetune::cli {

/// The words of a command line as CLI11 understands them: after `optimize`, the names that Mmg's users know become
/// ours; and every long name may have one dash. Throws OptionError for what Mmg has and tetune has not, and where the
/// first word is no command.
std::vector<std::string> without_aliases(const CLI::App& app, int argc, const char* const* argv);

/// What aliases stand for, for help and manual: pairs as "-ar A", "--feature-angle A".
std::vector<std::pair<std::string, std::string>> alias_table();

}  // namespace tetune::cli

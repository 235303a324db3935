// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tetune/option_table.hpp"

/// The options of the library (option_table.hpp) as flags of a command line.
namespace tetune::cli {

/// The flag of an option: "--max-ring", with what precedes the value: "--freeze tag=". Empty if there is none.
std::string flag_of(const OptionInfo& option);

/// The flag with a value, as a user writes it: "--boundary slide", "--no-flips", "--freeze tag=3".
std::string flag_with_value(const OptionInfo& option, const std::string& value);

/// A text of the library with its options written as flags: "boundary=slide" becomes "--boundary slide".
std::string with_flags(const std::string& text);

/// The help text of an option: what it does, its choices and its range.
std::string help_of(const OptionInfo& option);

/// Defines the flag of an option that has a single value. A former name of a choice adds a warning to `warnings`.
void define_option(CLI::App& command, const OptionInfo& option, Options& options, std::vector<std::string>& warnings);

/// One warning for each given option without effect.
std::vector<std::string> ineffective_flags(const CLI::App& command, const Options& options);

/// All options that have a flag, by name.
nlohmann::ordered_json to_json(const Options& options);

}  // namespace tetune::cli

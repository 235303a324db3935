// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

/// The options of a command as they were defined, for what is generated from them.
namespace tetune::cli {

/// Commands in the order they were added.
inline std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

/// All names, with their dashes: "-o", "--output"; also those that switch a flag off.
inline std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

inline bool is_positional(const CLI::Option& option) {
  return option.get_snames().empty() && option.get_lnames().empty();
}

inline bool takes_value(const CLI::Option& option) {
  return option.get_expected_max() > 0 && option.get_type_size() > 0;
}

/// An empty value, as of a variable of the shell that is not set, is refused: it would count as an option not given.
inline void refuse_empty_values(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    if (!takes_value(*option)) continue;
    const std::string what = is_positional(*option) ? "the name of a mesh" : "the value";
    const auto check = [what](const std::string& word) {
      return word.empty() ? what + " is empty (a variable of the shell that is not set?)" : "";
    };
    option->check(check, "");
  }
}

/// The words it may have, where these are listed: {a,b,c}.
inline std::vector<std::string> choices_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t open = type.find('{');
  const std::size_t close = type.find('}', open);
  if (open == std::string::npos || close == std::string::npos) return {};
  return CLI::detail::split(type.substr(open + 1, close - open - 1), ',');
}

/// What stands for its value.
inline std::string value_of(const CLI::Option& option) {
  if (!option.get_option_text().empty()) return option.get_option_text();
  if (is_positional(option)) return option.get_name();
  const std::vector<std::string> choices = choices_of(option);
  if (!choices.empty()) return CLI::detail::join(choices, "|");
  return "N";
}

}  // namespace tetune::cli

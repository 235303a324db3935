// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "nearest_name.hpp"
#include "tetune/error.hpp"

/// Queries of the definitions of a command's options, from which help, manual and completion are generated.
namespace tetune::cli {

/// Commands in the order in which they were added.
inline std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

/// All names with their dashes: "-o", "--output", and those that switch a flag off.
inline std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

/// Refuses an unknown long option of a command, with the most similar name. (CLI11 2.1 has no suggestions.)
inline void check_name(const CLI::App& command, const std::string& word, const std::string& command_line) {
  const std::string name = word.substr(0, word.find('='));
  if (!word.starts_with("--") || word == "--" || command.get_option_no_throw(name) != nullptr) return;
  std::vector<std::string> known;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& each : names_of(*option)) {
      if (each.starts_with("--")) known.push_back(each);
    }
  }
  const std::string nearest = nearest_name(name, known);
  throw OptionError(name + ": there is no such option" + (nearest.empty() ? "" : "; did you mean " + nearest + "?") +
                    "; see " + command_line + " --help");
}

inline bool is_positional(const CLI::Option& option) {
  return option.get_snames().empty() && option.get_lnames().empty();
}

inline bool takes_value(const CLI::Option& option) {
  return option.get_expected_max() > 0 && option.get_type_size() > 0;
}

/// Refuses empty values, as of an unset variable of the shell, which CLI11 would treat as an option that is not given,
/// and words where a number is expected.
inline void check_values(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    if (!takes_value(*option)) continue;
    const std::string subject = is_positional(*option) ? "the name of a mesh" : "the value";
    const std::string type = option->get_type_name();
    const bool is_integer = type.starts_with("INT"), is_real = type.starts_with("FLOAT");
    const auto check = [subject, is_integer, is_real](const std::string& word) -> std::string {
      if (word.empty()) return subject + " is empty (a variable of the shell that is not set?)";
      std::int64_t integer = 0;
      double real = 0;
      if (is_integer && !CLI::detail::lexical_cast(word, integer)) return "'" + word + "' is not an integer";
      if (is_real && !CLI::detail::lexical_cast(word, real)) return "'" + word + "' is not a number";
      return "";
    };
    option->check(check, "");
  }
}

/// Accepts the listed words. Its description, {a,b,c}, is what choices_of() reads.
inline CLI::Validator is_word(const std::vector<std::string>& words) {
  const std::string list = CLI::detail::join(words, ",");
  const auto check = [words, list](std::string& word) -> std::string {
    const bool known = std::find(words.begin(), words.end(), word) != words.end();
    return known ? "" : "'" + word + "' is not one of " + list;
  };
  return {check, "{" + list + "}"};
}

/// The words that the option accepts, if they are listed as {a,b,c}.
inline std::vector<std::string> choices_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t open = type.find('{');
  const std::size_t close = type.find('}', open);
  if (open == std::string::npos || close == std::string::npos) return {};
  return CLI::detail::split(type.substr(open + 1, close - open - 1), ',');
}

/// The placeholder of its value.
inline std::string placeholder_of(const CLI::Option& option) {
  if (!option.get_option_text().empty()) return option.get_option_text();
  if (is_positional(option)) return option.get_name();
  const std::vector<std::string> choices = choices_of(option);
  return choices.empty() ? "N" : CLI::detail::join(choices, "|");
}

}  // namespace tetune::cli

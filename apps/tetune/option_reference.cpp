// SPDX-License-Identifier: Apache-2.0
// Prints what is generated from the table of options (tetune/option_table.hpp):
//   tetune_option_reference markdown > docs/options.md
//   tetune_option_reference python > python/tetune/_options.py
#include <fmt/format.h>

#include <regex>
#include <string>
#include <string_view>
#include <type_traits>

#include "option_flags.hpp"

namespace {

using namespace tetune;

const Options kDefaults;

std::string values(const OptionInfo& option) {
  const auto describe = [&]<class T>(T Options::*) -> std::string {
    if constexpr (std::is_same_v<T, bool>) return "`true`, `false`";
    if constexpr (std::is_same_v<T, std::vector<Target>>) return "a value per measure";
    if constexpr (std::is_same_v<T, std::vector<int>>) return "tags";
    if constexpr (std::is_same_v<T, std::vector<std::uint8_t>>) return "flags";
    std::string list;
    for (const OptionChoice& choice : option.choices) {
      list += fmt::format("{}`{}`", list.empty() ? "" : ", ", choice.name);
    }
    return list.empty() ? to_string(option.range) : list;
  };
  return std::visit(describe, option.member);
}

/// "It has no effect with a=1, with b=2; does little with c=3."
std::string conditions(const OptionInfo& option) {
  constexpr std::string_view kNoEffect = "has no effect ";
  std::string text;
  for (const OptionCondition& condition : option.ineffective) {
    const std::string_view reason = condition.text;
    const bool continues = !text.empty() && reason.starts_with(kNoEffect);
    text += text.empty() ? "<br>It " : continues ? ", " : "; ";
    text += continues ? reason.substr(kNoEffect.size()) : reason;
  }
  return text.empty() ? text : text + '.';
}

/// Options in the text, as boundary=slide, in backquotes.
std::string with_code(const std::string& text) {
  return std::regex_replace(text, std::regex("[a-z_]+=[a-z0-9]+"), "`$&`");
}

std::string markdown_row(const OptionInfo& option) {
  std::string text = std::string(option.text) + ".";
  for (const OptionChoice& choice : option.choices) text += fmt::format("<br>`{}`: {}.", choice.name, choice.text);
  text = with_code(text + conditions(option));
  const std::string value = option_value(option, kDefaults);
  std::string flag = cli::flag_of(option);
  if (value == "true") flag = cli::flag_with_value(option, "false");
  if (std::string_view(option.name) == "targets") flag = "--target-quality";
  return fmt::format("| `{}` | {} | {} | {} | {} |\n", option.name, flag.empty() ? "" : "`" + flag + "`",
                     values(option), value.empty() ? "none" : "`" + value + "`", text);
}

std::string markdown() {
  std::string text = R"(# Options

The options of `optimize()` have the same names in C++ (`tetune::Options`), in Python (keyword arguments) and in
JSON reports. The command line has them as flags, and some more (`tetune optimize --help`). This page is generated
from the library's table of options.

A value out of its range is refused. An option that has no effect beside the others is not refused: a warning
names it.
)";
  std::string_view group;
  for (const OptionInfo& option : option_table()) {
    if (option.group != group) {
      group = option.group;
      text += fmt::format("\n## {}\n\n| option | flag | values | default | |\n|---|---|---|---|---|\n", group);
    }
    text += markdown_row(option);
  }
  text += "\n## Former names\n\nThese are accepted until version 0.3:";
  for (const OptionInfo& option : option_table()) {
    for (const OptionChoice& choice : option.choices) {
      if (choice.old_name == nullptr) continue;
      text += fmt::format(" `{0}={1}` for `{0}={2}`;", option.name, choice.old_name, choice.name);
    }
  }
  text.back() = '.';
  return text + "\n";
}

std::string python_type(const OptionInfo& option) {
  const auto name = [&]<class T>(T Options::*) -> std::string {
    if constexpr (std::is_same_v<T, bool>) return "bool";
    if constexpr (std::is_same_v<T, int>) return "int";
    if constexpr (std::is_same_v<T, double>) return "float";
    if constexpr (std::is_same_v<T, std::vector<Target>>) return "Mapping[str, float]";
    std::string list;
    for (const OptionChoice& choice : option.choices) {
      list += fmt::format("{}\"{}\"", list.empty() ? "" : ", ", choice.name);
    }
    return list.empty() ? "ArrayLike" : "Literal[" + list + "]";
  };
  return std::visit(name, option.member);
}

std::string python() {
  std::string text =
      "# SPDX-License-Identifier: Apache-2.0\n"
      "# Generated from the library's table of options by: tetune_option_reference python\n"
      "# ruff: noqa: E501\n"
      "\"\"\"The options of optimize().\"\"\"\n\n"
      "from __future__ import annotations\n\n"
      "from collections.abc import Mapping\n"
      "from typing import Literal, TypedDict\n\n"
      "from numpy.typing import ArrayLike\n\n\n"
      "class Options(TypedDict, total=False):\n"
      "    \"\"\"Options of optimize(), with the names, meanings and defaults of C++ (`tetune/options.hpp`).\"\"\"\n\n";
  for (const OptionInfo& option : option_table()) {
    text += fmt::format("    {}: {}\n    \"\"\"{}", option.name, python_type(option), option.text);
    for (const OptionChoice& choice : option.choices) text += fmt::format("; {}: {}", choice.name, choice.text);
    const std::string value = option_value(option, kDefaults);
    text += fmt::format(". Default: {}.\"\"\"\n", value.empty()      ? "none"
                                                  : value == "true"  ? "True"
                                                  : value == "false" ? "False"
                                                                     : value);
  }
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view format = argc == 2 ? argv[1] : "";
  if (format != "markdown" && format != "python") {
    fmt::print(stderr, "usage: tetune_option_reference markdown|python\n");
    return 2;
  }
  fmt::print("{}", format == "markdown" ? markdown() : python());
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
#include "option_flags.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <regex>
#include <type_traits>

namespace tetune::cli {
namespace {

const Options kDefaults;

bool is_flag(const OptionInfo& option) { return std::holds_alternative<bool Options::*>(option.member); }

std::string joined_names(const OptionInfo& option) {
  std::string names;
  for (const OptionChoice& choice : option.choices) names += (names.empty() ? "" : ",") + std::string(choice.name);
  return names;
}

/// Accepts the names of the choices and their former names; CLI::CheckedTransformer would accept numbers too.
CLI::Validator is_choice(const OptionInfo& option) {
  const auto check = [&option](std::string& word) -> std::string {
    if (find_choice(option, word) != nullptr) return "";
    return fmt::format("'{}' is not one of {}", word, joined_names(option));
  };
  return {check, "{" + joined_names(option) + "}"};
}

template <class T>
void define_choice(CLI::App& command, const OptionInfo& option, T& value, std::vector<std::string>& warnings) {
  const auto set = [&option, &value, &warnings](const std::string& word) {
    const OptionChoice& choice = *find_choice(option, word);
    value = static_cast<T>(choice.value);
    if (word == choice.name) return;
    warnings.push_back(fmt::format("{0} {1} is the former name of {0} {2}, and is accepted until version 0.3",
                                   flag_of(option), word, choice.name));
  };
  command.add_option_function<std::string>(flag_of(option), set, help_of(option))
      ->check(is_choice(option))
      ->default_str(option_value(option, kDefaults))
      ->group(option.group);
}

}  // namespace

std::string flag_of(const OptionInfo& option) {
  const std::string_view name = option.name;
  if (name == "frozen_regions") return "--freeze tag=";
  if (name == "frozen_patches") return "--freeze patch=";
  if (name == "frozen_vertices" || name == "targets") return "";
  std::string flag = "--" + std::string(name);
  std::replace(flag.begin(), flag.end(), '_', '-');
  return flag;
}

std::string flag_with_value(const OptionInfo& option, const std::string& value) {
  const std::string flag = flag_of(option);
  if (is_flag(option)) return value == "false" ? "--no-" + flag.substr(2) : flag;
  return flag.ends_with('=') ? flag + value : flag + " " + value;
}

std::string with_flags(const std::string& text) {
  // Names alone are replaced only if they cannot be words of the language.
  static const std::regex token(R"(\b([a-z_]+)=(-?[0-9]+(?:\.[0-9]+)?(?:e[-+]?[0-9]+)?|-?[a-z]+)|\b[a-z]+_[a-z]+\b)");
  std::string out;
  auto rest = text.begin();
  for (auto at = std::sregex_iterator(text.begin(), text.end(), token); at != std::sregex_iterator(); ++at) {
    const std::smatch& found = *at;
    const bool has_value = found[1].matched;
    const OptionInfo* option = find_option(has_value ? found[1].str() : found.str());
    if (option == nullptr || flag_of(*option).empty()) continue;
    out.append(rest, found[0].first);
    out +=
        has_value ? flag_with_value(*option, found[2].str()) : flag_of(*option).substr(0, flag_of(*option).find(' '));
    rest = found[0].second;
  }
  return out.append(rest, text.end());
}

std::string help_of(const OptionInfo& option) {
  std::string text = option.text;
  if (option.range.max > option.range.min) text += " (" + to_string(option.range) + ")";
  const char* between = ". ";
  for (const OptionChoice& choice : option.choices) {
    text += fmt::format("{}{}: {}", between, choice.name, choice.text);
    between = "; ";
  }
  return with_flags(text);
}

void define_option(CLI::App& command, const OptionInfo& option, Options& options, std::vector<std::string>& warnings) {
  const std::string flag = flag_of(option);
  const auto define = [&]<class T>(T Options::*member) {
    if constexpr (std::is_same_v<T, bool>) {
      const bool is_on = kDefaults.*member;
      const std::string names = is_on ? flag + ",!" + flag_with_value(option, "false") : flag;
      CLI::Option* o = command.add_flag(names, options.*member, help_of(option))->group(option.group);
      if (is_on) o->capture_default_str();
    } else if constexpr (std::is_enum_v<T>) {
      define_choice(command, option, options.*member, warnings);
    } else if constexpr (std::is_arithmetic_v<T>) {
      command.add_option(flag, options.*member, help_of(option))->capture_default_str()->group(option.group);
    }
  };
  std::visit(define, option.member);
}

std::vector<std::string> ineffective_flags(const CLI::App& command, const Options& options) {
  std::vector<std::string> warnings;
  for (const OptionInfo& option : option_table()) {
    const CLI::Option* flag = flag_of(option).empty() ? nullptr : command.get_option_no_throw(flag_of(option));
    const bool given = flag != nullptr && flag->count() > 0;
    const char* reason = given ? why_ineffective(option, options) : nullptr;
    if (reason == nullptr) continue;
    const std::string value = is_flag(option) ? option_value(option, options) : flag->results().front();
    warnings.push_back(flag_with_value(option, value) + " " + with_flags(reason));
  }
  return warnings;
}

nlohmann::ordered_json to_json(const Options& options) {
  nlohmann::ordered_json json;
  for (const OptionInfo& option : option_table()) {
    const auto add = [&]<class T>(T Options::*member) {
      nlohmann::ordered_json& value = json[option.name];
      if constexpr (std::is_enum_v<T>) {
        value = option_value(option, options);
      } else if constexpr (std::is_same_v<T, std::vector<Target>>) {
        value = nlohmann::ordered_json::array();
        for (const Target& t : options.*member) {
          value.push_back({{"measure", to_string(t.measure)}, {"value", t.value}});
        }
      } else if constexpr (!std::is_same_v<T, std::vector<std::uint8_t>>) {  // it has no flag
        value = options.*member;
      }
    };
    if (std::string_view(option.name) != "frozen_vertices") std::visit(add, option.member);
  }
  json["feature_angle_deg"] = options.feature_angle;  // the former name, until version 0.3
  return json;
}

}  // namespace tetune::cli

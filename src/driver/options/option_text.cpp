// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <system_error>
#include <type_traits>

#include "system/real_text.hpp"
#include "tetune/error.hpp"
#include "tetune/option_table.hpp"

namespace tetune {
namespace {

[[noreturn]] void refuse(const OptionInfo& option, std::string_view text, const std::string& allowed) {
  throw OptionError(std::string(option.name) + ": '" + std::string(text) + "' is not a value; give " + allowed);
}

template <class Number>
bool parse_number(std::string_view text, Number& number) {
  const char* const end = text.data() + text.size();
  if constexpr (std::is_floating_point_v<Number>) {
    const auto [at, error] = parse_real(text.data(), end, number);
    return error == std::errc() && at == end;
  } else {
    const auto [at, error] = std::from_chars(text.data(), end, number);
    return error == std::errc() && at == end;
  }
}

bool parse_item(std::string_view text, int& item) { return parse_number(text, item); }
bool parse_item(std::string_view text, std::uint8_t& item) {
  if (text != "0" && text != "1") return false;
  item = text == "1" ? 1 : 0;
  return true;
}
bool parse_item(std::string_view text, Target& item) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos || !parse_number(text.substr(colon + 1), item.value)) return false;
  for (std::uint8_t k = 0; k < kMeasures; ++k) {
    const Measure measure{k};
    if (text.substr(0, colon) != to_string(measure)) continue;
    item.measure = measure;
    return true;
  }
  return false;
}

template <class Item>
std::string form_of() {
  if constexpr (std::is_same_v<Item, int>) return "whole numbers as 1,2";
  if constexpr (std::is_same_v<Item, std::uint8_t>) return "a 0 or 1 per vertex as 0,1";
  return "measures and limits as min_dihedral_deg:10,mean_ratio:0.2";
}

template <class Item>
std::vector<Item> parse_list(const OptionInfo& option, std::string_view text) {
  std::vector<Item> list;
  for (std::size_t begin = 0; !text.empty() && begin <= text.size();) {
    const std::string_view part = text.substr(begin, text.find(',', begin) - begin);
    Item item{};
    if (!parse_item(part, item)) refuse(option, part, form_of<Item>());
    list.push_back(item);
    begin += part.size() + 1;
  }
  return list;
}

template <class Choice>
Choice parse_choice(const OptionInfo& option, std::string_view text) {
  if (const OptionChoice* choice = find_choice(option, text)) return Choice{choice->value};
  std::string names;
  for (const OptionChoice& choice : option.choices) names += (names.empty() ? "" : ", ") + std::string(choice.name);
  refuse(option, text, "one of: " + names);
}

}  // namespace

void set_option(Options& options, std::string_view name, std::string_view text) {
  const OptionInfo* option = find_option(name);
  if (option == nullptr) {
    std::string names;
    for (const OptionInfo& known : option_table()) names += (names.empty() ? "" : ", ") + std::string(known.name);
    throw OptionError("there is no option '" + std::string(name) + "'; the options are " + names);
  }
  const auto set = [&]<class T>(T Options::*member) {
    T& value = options.*member;
    if constexpr (std::is_same_v<T, bool>) {
      if (text != "true" && text != "false") refuse(*option, text, "true or false");
      value = text == "true";
    } else if constexpr (std::is_arithmetic_v<T>) {
      T number{};
      if (!parse_number(text, number)) refuse(*option, text, "a number: " + to_string(option->range));
      value = number;
    } else if constexpr (std::is_enum_v<T>) {
      value = parse_choice<T>(*option, text);
    } else {
      value = parse_list<typename T::value_type>(*option, text);
    }
  };
  std::visit(set, option->member);
}

}  // namespace tetune

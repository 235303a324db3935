// SPDX-License-Identifier: Apache-2.0
#include "io/inp/inp_format.hpp"

#include <algorithm>
#include <charconv>

#include "io/plain_text.hpp"
#include "system/real_text.hpp"

namespace tetune {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

/// Calls take(part) for the parts between commas that are outside quotation marks.
template <class Take>
void split(std::string_view text, const Take& take) {
  bool is_quoted = false;
  std::size_t start = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') is_quoted = !is_quoted;
    if (text[i] != ',' || is_quoted) continue;
    take(text.substr(start, i - start));
    start = i + 1;
  }
  take(text.substr(start));
}

constexpr int kMaxRealLength = 20;

/// Writes the shortest digits of a number in one of three notations; returns the text.
std::string_view written(double value, int notation, int digits, std::array<char, 512>& buffer) {
  char* const begin = buffer.data();
  char* const end = begin + buffer.size();
  std::to_chars_result result{};
  if (notation == 0) result = print_real(begin, end, value);
  if (notation == 1) result = print_real(begin, end, value, std::chars_format::fixed);
  if (notation >= 2) {
    result = digits == 0 ? print_real(begin, end, value, std::chars_format::scientific)
                         : print_real(begin, end, value, std::chars_format::scientific, digits - 1);
  }
  char* last = result.ptr;
  char* const exponent = std::find(begin, last, 'e');
  if (exponent != last) {  // without a plus sign and leading zeros
    char* from = exponent + 1;
    char* to = from;
    if (*from == '-') ++to;
    if (*from == '-' || *from == '+') ++from;
    while (from + 1 < last && *from == '0') ++from;
    last = std::copy(from, last, to);
  }
  char* const first_digit = begin + (*begin == '-' ? 1 : 0);
  if (last - begin > kMaxRealLength && *first_digit == '0' && first_digit[1] == '.') {
    last = std::copy(first_digit + 1, last, first_digit);
  }
  return {begin, std::size_t(last - begin)};
}

}  // namespace

const std::string* InpKeyword::find(std::string_view parameter) const {
  for (const auto& [key, value] : parameters) {
    if (key == parameter) return &value;
  }
  return nullptr;
}

InpKeyword parse_inp_keyword(std::string_view line) {
  InpKeyword keyword;
  bool is_first = true;
  split(line.substr(1), [&](std::string_view part) {
    const std::size_t equals = part.find('=');
    const std::string key = inp_name(part.substr(0, equals));
    if (is_first) {
      keyword.name = key;
    } else if (!key.empty()) {
      const std::string_view value = equals == std::string_view::npos ? "" : part.substr(equals + 1);
      keyword.parameters.emplace_back(key, trimmed(value));
    }
    is_first = false;
  });
  return keyword;
}

std::vector<std::string_view> inp_fields(std::string_view line) {
  std::vector<std::string_view> fields;
  split(line, [&fields](std::string_view part) { fields.push_back(trimmed(part)); });
  if (fields.back().empty()) fields.pop_back();
  return fields;
}

namespace {

bool is_quoted(std::string_view text) { return text.size() >= 2 && text.front() == '"' && text.back() == '"'; }

}  // namespace

std::string unquoted_inp_name(std::string_view written) {
  const std::string_view text = trimmed(written);
  return std::string(is_quoted(text) ? text.substr(1, text.size() - 2) : text);
}

std::string inp_name(std::string_view written) {
  const std::string_view text = trimmed(written);
  if (is_quoted(text)) return unquoted_inp_name(text);
  std::string name;
  for (const char c : text) {
    if (!is_blank(c)) name.push_back(in_upper_case(c));
  }
  return name;
}

bool parse_inp_integer(std::string_view field, std::int64_t& value) {
  if (field.size() > 1 && field.front() == '+') field.remove_prefix(1);
  if (field.empty() || field.size() > 18) return false;
  const auto [stop, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error == std::errc() && stop == field.data() + field.size();
}

namespace {

using InpRole = InpElementType::Role;

struct InpTypeEntry {
  const char* name;
  InpElementType type;
};

/// Solids, after the letters of their family. The digits of a name end where another character follows. Longer names
/// come first.
constexpr std::array<InpTypeEntry, 9> kInpSolidTypes{{
    {"3D10", {InpRole::quadratic_tetrahedron, 10}},
    {"3D20", {InpRole::block, 20, "Hexahedra"}},
    {"3D15V", {InpRole::unknown, 15}},  // and possibly nodes in the middles of faces
    {"3D15", {InpRole::block, 15, "Prisms"}},
    {"3D27", {InpRole::unknown, 27}},
    {"3D4", {InpRole::tetrahedron, 4}},
    {"3D5", {InpRole::block, 5, "Pyramids"}},
    {"3D6", {InpRole::block, 6, "Prisms"}},
    {"3D8", {InpRole::block, 8, "Hexahedra"}},
}};
constexpr std::array<InpTypeEntry, 36> kInpOtherTypes{{
    {"STRI3", {InpRole::triangle, 3}},
    {"S3", {InpRole::triangle, 3}},
    {"DS3", {InpRole::triangle, 3}},
    {"M3D3", {InpRole::triangle, 3}},
    {"R3D3", {InpRole::triangle, 3}},
    {"SFM3D3", {InpRole::triangle, 3}},
    {"CPS3", {InpRole::triangle, 3}},
    {"CPE3", {InpRole::triangle, 3}},
    {"S4", {InpRole::block, 4, "Quadrilaterals"}},
    {"DS4", {InpRole::block, 4, "Quadrilaterals"}},
    {"M3D4", {InpRole::block, 4, "Quadrilaterals"}},
    {"R3D4", {InpRole::block, 4, "Quadrilaterals"}},
    {"SFM3D4", {InpRole::block, 4, "Quadrilaterals"}},
    {"CPS4", {InpRole::block, 4, "Quadrilaterals"}},
    {"CPE4", {InpRole::block, 4, "Quadrilaterals"}},
    {"S8", {InpRole::block, 8, "Quadrilaterals"}},
    {"DS8", {InpRole::block, 8, "Quadrilaterals"}},
    {"M3D8", {InpRole::block, 8, "Quadrilaterals"}},
    {"SFM3D8", {InpRole::block, 8, "Quadrilaterals"}},
    {"CPS8", {InpRole::block, 8, "Quadrilaterals"}},
    {"CPE8", {InpRole::block, 8, "Quadrilaterals"}},
    {"SC8", {InpRole::block, 8, "Hexahedra"}},
    {"CSS8", {InpRole::block, 8, "Hexahedra"}},
    {"SC6", {InpRole::block, 6, "Prisms"}},
    {"B31", {InpRole::edge, 2}},
    {"T3D2", {InpRole::edge, 2}},
    {"RB3D2", {InpRole::edge, 2}},
    {"B32", {InpRole::quadratic_edge}},
    {"T3D3", {InpRole::quadratic_edge}},
    {"STRI65", {InpRole::quadratic_triangle, 6}},
    {"S6", {InpRole::quadratic_triangle, 6}},
    {"DS6", {InpRole::quadratic_triangle, 6}},
    {"M3D6", {InpRole::quadratic_triangle, 6}},
    {"SFM3D6", {InpRole::quadratic_triangle, 6}},
    {"CPS6", {InpRole::quadratic_triangle, 6}},
    {"CPE6", {InpRole::quadratic_triangle, 6}},
}};

/// Whether a type is this name, with any characters but digits after it.
bool is_inp_type(std::string_view type, std::string_view name) {
  return type.starts_with(name) && (type.size() == name.size() || type[name.size()] < '0' || type[name.size()] > '9');
}

}  // namespace

InpElementType inp_element_type(const std::string& type) {
  // The solid families: structural, thermal, acoustic, fluid, coupled and electromagnetic elements.
  for (const char* family : {"C", "DC", "AC", "F", "FC", "DCC", "Q", "EMC"}) {
    for (const InpTypeEntry& entry : kInpSolidTypes) {
      if (is_inp_type(type, std::string(family) + entry.name)) return entry.type;
    }
  }
  for (const InpTypeEntry& entry : kInpOtherTypes) {
    if (is_inp_type(type, entry.name)) return entry.type;
  }
  return {};
}

bool append_inp_real(std::string& out, double value) {
  std::array<char, 512> buffer;
  for (int notation = 0; notation < 3; ++notation) {
    const std::string_view text = written(value, notation, 0, buffer);
    if (text.size() <= kMaxRealLength) {
      out += text;
      return true;
    }
  }
  for (int digits = 17;; --digits) {
    const std::string_view text = written(value, 3, digits, buffer);
    if (text.size() > kMaxRealLength) continue;
    out += text;
    return false;
  }
}

void append_inp_labels(std::string& out, const std::vector<std::int64_t>& labels, std::string_view newline) {
  constexpr std::size_t kPerLine = 16;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    out += std::to_string(labels[i]);
    out += i % kPerLine + 1 == kPerLine || i + 1 == labels.size() ? newline : std::string_view(", ");
  }
}

}  // namespace tetune

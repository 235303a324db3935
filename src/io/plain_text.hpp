// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

/// ASCII text of files, in which the locale has no part.
namespace tetune {

/// With which some programs start text in UTF-8.
inline constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

inline char in_upper_case(char c) { return c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c; }
inline std::string in_upper_case(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = in_upper_case(c);
  return result;
}

/// Text without blanks and ends of lines around it.
inline std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) + 1 - first);
}

/// Text of a file for messages: bytes that are no plain characters are replaced.
inline std::string printable(std::string_view text) {
  std::string shown(text);
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return shown;
}

/// Text without control characters, which are replaced; other bytes stay, in any encoding.
inline std::string without_control_characters(std::string_view text) {
  std::string result(text);
  std::replace_if(
      result.begin(), result.end(), [](char c) { return c >= '\0' && c < ' '; }, '?');
  return result;
}

/// Texts with commas between them, of which the first eight are listed and the others counted.
template <class Texts>
std::string listed_texts(const Texts& texts) {
  constexpr std::size_t kMaxListed = 8;
  std::string list;
  std::size_t n = 0;
  for (const auto& text : texts) {
    if (n++ < kMaxListed) list.append(list.empty() ? "" : ", ").append(text);
  }
  return n > kMaxListed ? list + " and " + std::to_string(n - kMaxListed) + " more" : list;
}

}  // namespace tetune

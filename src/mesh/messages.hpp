// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <initializer_list>
#include <string>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune {

/// The name of an enumerator, given the names of all in their order.
template <class Enum>
const char* name_of(Enum enumerator, std::initializer_list<const char*> names) {
  const auto position = std::size_t(enumerator);
  return position < names.size() ? names.begin()[position] : "unknown";
}

/// The number of ids that a message lists.
inline constexpr std::size_t kShownIds = 5;

/// Appends the first zero-based ids to a message, as " (first, counted from 1: 3, 8)"; nothing if there are none.
inline void append_first_ids(const std::vector<Index>& ids, bool one_based, std::string& text) {
  if (ids.empty()) return;
  text += one_based ? " (first, counted from 1" : " (first, counted from 0";
  for (std::size_t i = 0; i < std::min(ids.size(), kShownIds); ++i) {
    text += i == 0 ? ": " : ", ";
    text += std::to_string(ids[i] + (one_based ? 1 : 0));
  }
  text += ")";
}

/// As append_first_ids(), as a text of its own.
inline std::string first_ids(const std::vector<Index>& ids, bool one_based) {
  std::string text;
  append_first_ids(ids, one_based, text);
  return text;
}

/// A number as a part of a message, with six digits: "1e-07".
inline std::string short_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// A position as a part of a message: "near 0.5 -2 1e+06".
inline std::string place_text(const Point3& p) {
  return "near " + short_text(p[0]) + " " + short_text(p[1]) + " " + short_text(p[2]);
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace tetune::cli {

/// The Levenshtein distance: the number of characters to change, add or remove.
inline std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, substituted}));
    }
  }
  return row.back();
}

/// The most similar of the known names, the first of several, or one that begins with the name; empty if there is
/// neither.
inline std::string nearest_name(const std::string& name, const std::vector<std::string>& known) {
  std::string nearest;
  std::size_t min_distance = std::min<std::size_t>(3, name.size() / 3) + 1;
  for (const std::string& candidate : known) {
    const std::size_t d = edit_distance(name, candidate);
    if (d >= min_distance) continue;
    min_distance = d;
    nearest = candidate;
  }
  if (!nearest.empty() || name.size() < 4) return nearest;
  const auto begins = [&name](const std::string& candidate) { return candidate.starts_with(name); };
  const auto longer = std::find_if(known.begin(), known.end(), begins);
  return longer == known.end() ? "" : *longer;
}

}  // namespace tetune::cli

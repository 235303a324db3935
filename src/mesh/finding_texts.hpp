// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "mesh/messages.hpp"
#include "tetune/validate.hpp"

/// Parts of the messages on findings.
namespace tetune {

/// The part of a message on an index out of range: ": index 5, but there are 5 vertices (0 to 4)".
inline std::string text_of(const BadIndex& bad, bool one_based) {
  const int first = one_based ? 1 : 0;
  std::string text = ": index " + std::to_string(bad.index + first);
  if (bad.entries == 0) return text + ", but there are no " + bad.list;
  text += ", but there are " + std::to_string(bad.entries) + " " + bad.list + " (" + std::to_string(first) + " to " +
          std::to_string(bad.entries - 1 + first) + ")";
  return bad.from_one && !one_based ? text + "; if the ids count from 1, subtract 1" : text;
}

/// "; the largest coordinate is 1e+200, of vertex 5, which may be wrong".
inline std::string text_of(const LargestCoordinate& largest, bool one_based) {
  return "; the largest coordinate is " + short_text(largest.value) + ", of vertex " +
         std::to_string(std::int64_t(largest.vertex) + (one_based ? 1 : 0)) + ", which may be wrong";
}

/// The advice where nothing can be untangled.
inline const char* advice_on(const std::vector<Finding>& findings) {
  const bool are_lengths = std::all_of(findings.begin(), findings.end(), [](const Finding& f) {
    return f.defect == Defect::bad_array_length && f.expected >= 0;
  });
  return are_lengths ? "in the program that fills these arrays, give them that many entries."
                     : "repair or remove these in the program that made the mesh.";
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "map_file.hpp"

#include <charconv>
#include <vector>

namespace tetune::cli {
namespace {

void add_line(std::string& text, std::int64_t first, std::int64_t second) {
  char line[48];
  char* at = std::to_chars(line, line + 20, first).ptr;
  *at++ = ' ';
  at = std::to_chars(at, at + 20, second).ptr;
  *at++ = '\n';
  text.append(line, static_cast<std::size_t>(at - line));
}

/// `new2old` is empty if nothing has changed.
void add_section(std::string& text, const char* name, const std::vector<Index>& new2old, std::size_t new_count,
                 std::int64_t old_count) {
  std::vector<bool> is_kept(static_cast<std::size_t>(old_count), new2old.empty());
  for (const Index old : new2old) {
    if (old >= 0) is_kept[static_cast<std::size_t>(old)] = true;
  }
  std::size_t lines = new_count;
  for (const bool kept : is_kept) lines += kept ? 0 : 1;
  text += name;
  text += ' ' + std::to_string(lines) + '\n';
  for (std::size_t i = 0; i < new_count; ++i) {
    const auto now = static_cast<std::int64_t>(i) + 1;
    add_line(text, new2old.empty() ? now : new2old[i] + 1, now);
  }
  for (std::size_t i = 0; i < is_kept.size(); ++i) {
    if (!is_kept[i]) add_line(text, static_cast<std::int64_t>(i) + 1, 0);
  }
}

}  // namespace

std::string map_text(const Report& report, std::size_t vertices, std::size_t tets) {
  std::string text = "# tetune map: old new, counted from 1; 0: none\n";
  add_section(text, "Vertices", report.vertex2original, vertices, report.vertices);
  add_section(text, "Tetrahedra", report.tet2original, tets, report.tets_before);
  return text;
}

}  // namespace tetune::cli

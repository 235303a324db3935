// SPDX-License-Identifier: GPL-2.0-or-later
#include "ignored_content.hpp"

#include <algorithm>
#include <fstream>
#include <set>
#include <string_view>
#include <vector>

namespace tetune::plugin {
namespace {

constexpr std::size_t kShownNames = 8;

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") + 1 - first);
}

/// The names that a file has beside those that Gmsh reads, in their order.
class IgnoredNames {
 public:
  void add(const std::string& name) {
    if (seen_.insert(name).second) names_.push_back(name);
  }
  void warn(const char* of, Warnings& warnings) const {
    if (names_.empty()) return;
    std::string list;
    for (std::size_t i = 0; i < std::min(names_.size(), kShownNames); ++i) list += (i == 0 ? "" : ", ") + names_[i];
    if (names_.size() > kShownNames) list += " and " + std::to_string(names_.size() - kShownNames) + " more";
    warnings.push_back(std::string(of) + " " + list + " are not kept");
  }

 private:
  std::set<std::string> seen_;
  std::vector<std::string> names_;
};

void warn_of_end(std::string_view last, const char* expected, Warnings& warnings) {
  if (last.find(expected) != std::string_view::npos) return;
  warnings.push_back(std::string("it does not end with ") + expected + "; the file may be cut short");
}

void check_ideas(std::ifstream& in, Warnings& warnings) {
  static const std::set<std::string> kRead{"15", "781", "2411", "780", "2412", "2477"};
  IgnoredNames sets;
  bool is_inside = false;
  bool is_number = false;
  std::string text;
  std::string last;
  std::string set;  // its number
  while (std::getline(in, text)) {
    const std::string_view content = trimmed(text);
    if (content.empty()) continue;
    last = content;
    if (is_number) set = last;
    if (is_number && kRead.count(set) == 0) sets.add(set);
    is_number = content == "-1" && !is_inside;
    if (content == "-1") is_inside = !is_inside;
  }
  // A line of an unknown data set may be -1 as well.
  if (is_inside && !is_number && kRead.count(set) != 0) {
    throw FileError("it ends within the data set " + set +
                    ", before the -1 after its lines; the file is cut short: write or copy it again");
  }
  sets.warn("the data sets", warnings);
  warn_of_end(is_inside ? "" : last, "-1", warnings);
}

}  // namespace

void check_ignored_content(const std::string& file, const std::string& ending, Warnings& warnings) {
  std::ifstream in(file);
  if (ending == ".unv") check_ideas(in, warnings);
}

}  // namespace tetune::plugin

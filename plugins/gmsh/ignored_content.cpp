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

std::string upper(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = 'a' <= c && c <= 'z' ? char(c - 'a' + 'A') : c;
  return result;
}

/// The names that a file has beside those that Gmsh reads, in their order.
class IgnoredNames {
 public:
  void add(const std::string& name) {
    if (seen_.insert(name).second) names_.push_back(name);
  }
  bool is_empty() const { return names_.empty(); }
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

/// A line of bulk data: fields of 8 characters, of 16 where the name ends with *, or between commas.
class BulkLine {
 public:
  explicit BulkLine(std::string_view line) : line_(line) {
    const std::string_view first = line.substr(0, std::min({line.find(','), line.size(), std::size_t{8}}));
    name_ = upper(trimmed(first));
    is_large_ = name_.ends_with('*');
    if (is_large_) name_.pop_back();
  }
  const std::string& name() const { return name_; }
  /// Field k after the name, from 1.
  std::string_view field(std::size_t k) const {
    if (line_.find(',') != std::string_view::npos) {
      std::string_view rest = line_;
      for (std::size_t i = 0; i < k; ++i) {
        const std::size_t comma = rest.find(',');
        if (comma == std::string_view::npos) return {};
        rest.remove_prefix(comma + 1);
      }
      return trimmed(rest.substr(0, rest.find(',')));
    }
    const std::size_t width = is_large_ ? 16 : 8;
    const std::size_t begin = 8 + (k - 1) * width;
    return begin >= line_.size() ? std::string_view{} : trimmed(line_.substr(begin, width));
  }

 private:
  std::string_view line_;
  std::string name_;
  bool is_large_ = false;
};

/// Refuses nodes in a coordinate system of their own.
void check_coordinate_system(const BulkLine& line, std::size_t number) {
  const bool is_node = line.name() == "GRID";
  if (!is_node && line.name() != "GRDSET") return;
  const std::string_view system = line.field(2);
  if (system.empty() || system == "0") return;
  throw FileError("line " + std::to_string(number) + ": " + (is_node ? "a node is" : "nodes are") +
                  " in the coordinate system " + std::string(system) +
                  "; only the basic one is read. Write the coordinates of all nodes in that");
}

void warn_of_end(std::string_view last, const char* expected, Warnings& warnings) {
  if (last.find(expected) != std::string_view::npos) return;
  warnings.push_back(std::string("it does not end with ") + expected + "; the file may be cut short");
}

void check_nastran(std::ifstream& in, Warnings& warnings) {
  static const std::set<std::string> kRead{"GRID",   "CBAR",   "CROD",  "CBEAM",  "CTRIA3", "CTRIA6", "CQUAD4",
                                           "CQUAD8", "CTETRA", "CHEXA", "CPENTA", "CPYRAM", "CPYRA",  "ENDDATA"};
  IgnoredNames cards;
  bool has_control = false;
  std::string text;
  std::string last;
  for (std::size_t number = 1; std::getline(in, text); ++number) {
    const std::string_view content = trimmed(text);
    if (content.empty()) continue;
    last = upper(content);
    // Comments and continued lines.
    if (std::string_view("$+*, \t").find(text[0]) != std::string_view::npos) continue;
    if (last.starts_with("BEGIN")) {
      has_control = has_control || !cards.is_empty();
      cards = {};
      continue;
    }
    const BulkLine line(text);
    check_coordinate_system(line, number);
    if (kRead.count(line.name()) == 0) cards.add(line.name());
  }
  if (has_control) warnings.emplace_back("the statements before BEGIN BULK are not kept");
  cards.warn("the cards", warnings);
  warn_of_end(last, "ENDDATA", warnings);
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
  if (ending == ".bdf") check_nastran(in, warnings);
  if (ending == ".unv") check_ideas(in, warnings);
}

}  // namespace tetune::plugin

// SPDX-License-Identifier: Apache-2.0
#include "io/inp/inp_data.hpp"

#include <algorithm>
#include <array>

namespace tetune {
namespace {

/// Whether a field is an integer, or a real number with a point. Names of sets may start with any character, and one
/// such as 2E5 is more likely a name than a number without a point.
bool is_number(std::string_view field) {
  if (field.front() == '+' || field.front() == '-') field.remove_prefix(1);
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (std::all_of(field.begin(), field.end(), is_digit)) return true;
  const auto is_of_real = [&](char c) {
    return is_digit(c) || std::string_view(".+-eEdD").find(c) != std::string_view::npos;
  };
  return field.find('.') != std::string_view::npos && std::all_of(field.begin(), field.end(), is_of_real);
}

void note_name(std::string_view field, const InpCardKind& kind, InpScan& scan) {
  if (field.empty() || is_number(field)) return;
  std::string name = scan.key(field);
  if (kind.pairs) scan.paired.insert(name);
  if (kind.is_per_node) scan.loaded.insert(name);
  scan.mentioned.insert(std::move(name));
}

/// Whether a field is letters and the number of a face of a tetrahedron at `digit`, as S1 or P4NU.
bool is_face_place(std::string_view field, std::size_t digit) {
  const auto is_letter = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); };
  if (digit == std::string_view::npos || digit == 0 || field[digit] < '1' || field[digit] > '4') return false;
  const bool is_long = digit + 1 < field.size() && field[digit + 1] >= '0' && field[digit + 1] <= '9';
  const std::string_view letters = field.substr(0, digit);
  return !is_long && std::all_of(letters.begin(), letters.end(), is_letter);
}

void check_count(const InpCursor& cursor, std::size_t n, Index max) {
  if (const std::string excess = excess_of(std::int64_t(n), max); !excess.empty())
    cursor.fail("the deck has " + excess);
}

/// The first line of an element, and its number.
struct ElementStart {
  std::int64_t line, label;
};

[[noreturn]] void fail_count(const InpCursor& cursor, const ElementStart& element, std::size_t found,
                             std::size_t expected) {
  cursor.fail_at(element.line, "element " + std::to_string(element.label) + " has " + std::to_string(found) +
                                   " nodes instead of " + std::to_string(expected));
}

/// Refuses an element that continues in a line with more numbers than it lacks: that is the line of another element.
void check_last_line(InpCursor& cursor, const ElementStart& element, std::size_t expected) {
  if (cursor.line() == element.line || cursor.line_done()) return;
  cursor.fail_at(element.line, "element " + std::to_string(element.label) + " has fewer than " +
                                   std::to_string(expected) + " nodes before line " + std::to_string(cursor.line()) +
                                   ", which has more numbers than it lacks; complete the element");
}

void add_element(InpScan& scan, std::int64_t label, Index tet, Index set) {
  scan.model.element_labels.push_back(label);
  scan.model.element2tet.push_back(tet);
  scan.element2set.push_back(set);
}

}  // namespace

void read_inp_nodes(InpCursor& cursor, InpModel& model) {
  while (!cursor.at_end() && cursor.line_kind() == InpCursor::Line::data) {
    model.node_lines.push_back(cursor.at());
    model.node_labels.push_back(cursor.label("number of a node"));
    Point3 p{};
    for (double& x : p) {
      if (!cursor.take_comma()) break;
      x = cursor.real();
    }
    model.points.push_back(p);
    cursor.take_line();  // a direction of normals may follow
  }
  check_count(cursor, model.points.size(), kMaxEntries);
}

void read_inp_tets(InpCursor& cursor, Index set, InpScan& scan) {
  InpModel& model = scan.model;
  const Index card = to_index(model.tet_cards.size() - 1);
  const std::size_t expected = to_size_t(scan.nodes_per_tet);
  while (!cursor.at_end() && cursor.line_kind() == InpCursor::Line::data) {
    model.tet_lines.push_back(cursor.at());
    const ElementStart element{cursor.line(), cursor.label("number of an element")};
    for (std::size_t k = 0; k < expected; ++k) {
      if (!cursor.take_comma()) fail_count(cursor, element, k, expected);
      if (cursor.line_done() && !cursor.at_end()) {
        cursor.end_line();
        cursor.skip_comments();
        if (cursor.at_end() || cursor.line_kind() != InpCursor::Line::data) fail_count(cursor, element, k, expected);
      }
      scan.tet_node_labels.push_back(cursor.label("number of a node"));
    }
    cursor.take_comma();
    check_last_line(cursor, element, expected);
    cursor.end_line();
    model.tet2element.push_back(to_index(model.element_labels.size()));
    model.tet2card.push_back(card);
    add_element(scan, element.label, to_index(model.tet2element.size() - 1), set);
  }
  check_count(cursor, model.tet2element.size(), kMaxTets);
}

void read_inp_other(InpCursor& cursor, const InpElementType& type, Index set, InpScan& scan) {
  const char* const line = cursor.at();
  const ElementStart element{cursor.line(), cursor.label("number of an element")};
  const std::size_t first = scan.other_nodes.size();
  const std::size_t expected = to_size_t(type.nodes);
  std::size_t n = 0;
  for (;;) {
    const bool has_comma = cursor.take_comma();
    if (cursor.line_done()) {
      cursor.end_line();
      const bool is_complete = expected == 0 && !has_comma;
      if (!is_complete) cursor.skip_comments();
      if (is_complete || cursor.at_end() || cursor.line_kind() != InpCursor::Line::data) break;
    }
    const std::int64_t node = cursor.label_or_zero("number of a node");
    if (node != 0) scan.other_nodes.push_back(node);  // network elements have 0 for no node
    if (++n != expected) continue;
    cursor.take_comma();
    check_last_line(cursor, element, expected);
    cursor.take_line();  // both programs ignore more numbers
    break;
  }
  const std::size_t found = scan.other_nodes.size() - first;
  if (type.role != InpElementType::Role::unknown && expected != 0 && found != expected)
    fail_count(cursor, element, found, expected);
  scan.others.push_back({to_index(scan.model.element_labels.size()), type, first, scan.other_nodes.size(), line});
  add_element(scan, element.label, -1, set);
  check_count(cursor, scan.other_nodes.size(), kMaxEntries);
}

void read_inp_triangle(InpCursor& cursor, const InpElementType& type, Index set, InpScan& scan) {
  const Index element = to_index(scan.model.element_labels.size());
  const Index card = to_index(scan.model.triangle_cards.size() - 1);
  const bool has_middles = type.role == InpElementType::Role::quadratic_triangle;
  scan.model.triangles.push_back({element, card, cursor.at(), {-1, -1, -1}, has_middles});
  read_inp_other(cursor, type, set, scan);
}

void read_inp_set_line(InpCursor& cursor, const InpCardKind& kind, InpScan& scan) {
  InpSetLines& lines = scan.set_lines.back();
  const bool generates = scan.model.set_cards.back().generates;
  if (scan.model.set_cards.back().follows_elements) {
    cursor.take_line();
    return;
  }
  const std::int64_t line = cursor.line();
  const std::vector<std::string_view> fields = inp_fields(cursor.take_line());
  if (generates) {
    std::array<std::int64_t, 3> range{0, 0, 1};
    bool is_range = fields.size() == 2 || fields.size() == 3;
    for (std::size_t k = 0; is_range && k < fields.size(); ++k) is_range = parse_inp_integer(fields[k], range[k]);
    if (!is_range || range[2] <= 0) {
      cursor.fail_at(line,
                     "this line of a set should be FIRST, LAST, STEP, as GENERATE requires, with a positive STEP");
    }
    lines.ranges.push_back(range);
    return;
  }
  for (const std::string_view field : fields) {
    std::int64_t label = 0;
    if (parse_inp_integer(field, label)) {
      lines.labels.push_back(label);
    } else if (!field.empty()) {
      note_name(field, kind, scan);
      lines.names.emplace_back(field);
    }
  }
}

void read_inp_face_line(InpCursor& cursor, const InpCardKind& kind, InpScan& scan) {
  const char* const start = cursor.at();
  const std::string_view line = cursor.take_line();
  std::string whole(start, cursor.at());
  if (!whole.ends_with('\n')) whole += scan.model.newline;
  const std::vector<std::string_view> fields = inp_fields(line);
  std::vector<InpFaceLine>& lines = scan.face_lines.back();
  InpFaceCard& card = scan.model.face_cards.back();
  const std::string_view place = fields.size() < 2 ? std::string_view() : fields[1];
  const std::size_t digit = place.find_first_of("0123456789");
  if (!is_face_place(place, digit) || fields[0].empty()) {
    note_inp_data(fields, kind, scan);
    lines.push_back({-1, 0, {}, whole});
    return;
  }
  const char* const comma = fields[0].data() + fields[0].size();
  std::string before(comma, place.data() + digit);
  std::string after(place.data() + digit + 1, line.data() + line.size());
  std::vector<InpFaceGroup>& groups = scan.model.face_groups;
  const auto [at, is_new] =
      scan.face_group_of.try_emplace({scan.face_lines.size(), before, after}, to_index(groups.size()));
  if (is_new) {
    card.groups.push_back(at->second);
    groups.push_back({std::move(before), std::move(after), {}, {}, {}});
  }
  lines.push_back({at->second, place[digit] - '0', std::string(fields[0]), whole});
}

void note_inp_data(const std::vector<std::string_view>& fields, const InpCardKind& kind, InpScan& scan) {
  for (std::size_t k = 0; k < fields.size(); ++k) {
    note_name(fields[k], kind, scan);
    const auto is_named = [&](InpCardKind::Fields named) {
      return named == InpCardKind::Fields::every || (named == InpCardKind::Fields::first && k == 0) ||
             (named == InpCardKind::Fields::every_third && k % 3 == 0 && fields.size() >= 3);
    };
    std::int64_t label = 0;
    if (!is_named(kind.nodes) && !is_named(kind.elements)) continue;
    if (!scan.parse_label(fields[k], label)) continue;
    if (is_named(kind.nodes)) (kind.is_of_fields() ? scan.nodes_with_fields : scan.held_nodes).push_back(label);
    if (is_named(kind.elements)) scan.held_elements.push_back(label);
  }
}

void note_inp_parameter(const std::string& key, const std::string& value, const InpCardKind& kind, InpScan& scan) {
  note_name(value, kind, scan);
  std::int64_t label = 0;
  if (key.ends_with("NODE") && scan.parse_label(value, label)) scan.held_nodes.push_back(label);
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
// The data sets of universal files, by the descriptions of I-deas that the Structural Dynamics Research Laboratory of
// the University of Cincinnati publishes.
#include "io/unv/unv_model.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <set>

#include "io/plain_text.hpp"
#include "io/second_order.hpp"
#include "io/unv/unv_format.hpp"

namespace tetune {
namespace {

class UnvParser {
 public:
  UnvParser(UnvLines& lines, std::vector<std::string>& warnings) : lines_(lines), warnings_(warnings) {}

  UnvModel read() {
    for (std::string set(lines_.next_set()); !set.empty(); set = lines_.next_set()) read_set(set);
    check_systems();
    return std::move(model_);
  }

 private:
  void read_set(const std::string& set) {
    if (set == "15") return read_nodes(true, true);
    if (set == "781") return read_nodes(false, true);
    if (set == "2411") return read_nodes(false, false);
    if (set == "780") return read_elements(true);
    if (set == "2412") return read_elements(false);
    if (set == "164") return read_units();
    if (set == "2420") return read_systems();
    model_.has_groups_of_gmsh = model_.has_groups_of_gmsh || set == kUnvGroupsOfGmsh;
    constexpr std::array<std::string_view, 4> kGroupsOfPairs{"2417", "2429", "2430", "2432"};
    constexpr std::array<std::string_view, 4> kGroupsOfFours{"2435", "2452", "2467", "2477"};
    if (std::find(kGroupsOfPairs.begin(), kGroupsOfPairs.end(), set) != kGroupsOfPairs.end()) return read_groups(2);
    if (std::find(kGroupsOfFours.begin(), kGroupsOfFours.end(), set) != kGroupsOfFours.end()) return read_groups(4);
    if (names_.insert(set).second) model_.ignored_sets.push_back(set);
    lines_.skip_set();
  }

  // Nodes.

  /// Single precision has one line for each node. Coordinates are in the definition system of each node or in that of
  /// the part.
  void read_nodes(bool is_single, bool has_definition) {
    for (std::string_view line; lines_.next(line);) {
      const std::vector<std::string_view>* fields =
          &(is_single ? lines_.fields(line, {kUnvIntegerWidth, kUnvIntegerWidth, kUnvIntegerWidth, kUnvIntegerWidth,
                                             kUnvSingleWidth, kUnvSingleWidth, kUnvSingleWidth})
                      : lines_.fields(line, {kUnvIntegerWidth, kUnvIntegerWidth, kUnvIntegerWidth, kUnvIntegerWidth}));
      const std::int64_t number = label((*fields)[0], "the number of a node");
      const std::int64_t system = lines_.integer((*fields)[1], "the number of a coordinate system");
      model_.node_numbers.push_back(number);
      model_.node_lines.push_back(lines_.line());
      Use& use = uses_[has_definition ? 1 : 0].try_emplace(system, Use{lines_.line(), 0}).first->second;
      ++use.nodes;
      std::size_t first = 4;
      if (!is_single) {
        fields = &lines_.fields(lines_.further(), {kUnvRealWidth, kUnvRealWidth, kUnvRealWidth});
        first = 0;
      }
      Point3 p{};
      for (std::size_t k = 0; k < 3; ++k) p[k] = lines_.real((*fields)[first + k], "a coordinate");
      model_.points.push_back(p);
    }
  }
  std::int64_t label(std::string_view field, const char* name) const {
    const std::int64_t number = lines_.integer(field, name);
    if (number < 0) lines_.fail(std::string(name) + " is negative");
    return number;
  }

  // Coordinate systems.

  /// The nodes that name a coordinate system.
  struct Use {
    std::int64_t line;  ///< of the first one
    std::size_t nodes;
  };

  void read_systems() {
    lines_.integers(lines_.further());  // number of the part
    lines_.text();                      // name of the part
    for (std::string_view line; lines_.next(line);) {
      const std::vector<std::int64_t>& numbers = lines_.integers(line);
      if (numbers.size() < 2) lines_.fail("a coordinate system should have a number, a kind and a color here");
      const std::int64_t number = numbers[0];
      bool is_global = numbers[1] == 0;
      lines_.text();  // name
      for (std::size_t row = 0; row < 4; ++row) {
        const std::vector<std::string_view>& fields =
            lines_.fields(lines_.further(), {kUnvRealWidth, kUnvRealWidth, kUnvRealWidth});
        for (std::size_t k = 0; k < 3; ++k) {
          is_global = lines_.real(fields[k], "a number of a matrix") == (k == row ? 1 : 0) && is_global;
        }
      }
      systems_[number] = is_global;
    }
  }
  /// Refuses or warns of coordinate systems other than the global Cartesian one, which 0 and 1 are where the file does
  /// not define them.
  void check_systems() const {
    std::string systems;
    std::size_t nodes = 0;
    for (const bool has_definition : {false, true}) {
      for (const auto& [system, use] : uses_[has_definition ? 1 : 0]) {
        const auto known = systems_.find(system);
        if (known == systems_.end() ? system == 0 || system == 1 : known->second) continue;
        const std::string number = std::to_string(system);
        if (has_definition && known != systems_.end()) {
          lines_.fail_at(use.line, "the coordinates of this node are in the coordinate system " + number +
                                       ", which is not the global Cartesian one; only that is read. Write the "
                                       "coordinates of all nodes in it");
        }
        nodes += use.nodes;
        if (systems.find(' ' + number + ',') == std::string::npos) systems += ' ' + number + ',';
      }
    }
    if (nodes == 0) return;
    systems.pop_back();
    warnings_.push_back(std::to_string(nodes) + " nodes name coordinate systems (" + systems.substr(1) +
                        ") that are not the global Cartesian one by the data sets 2420: their coordinates are taken " +
                        "as those of the part, as they are");
  }

  /// Checks the lines of the data set of units, and keeps them.
  void read_units() {
    const std::string_view first = lines_.further();
    lines_.integer(trimmed(first.substr(0, kUnvIntegerWidth)), "the number of a system of units");
    model_.units = printable(first) + '\n';
    for (std::string_view line; lines_.next(line);) {
      for (const std::string_view field : lines_.fields(line, {kUnvRealWidth, kUnvRealWidth, kUnvRealWidth})) {
        if (!field.empty()) lines_.real(field, "a factor of units");
      }
      model_.units += printable(line) + '\n';
    }
  }

  // Elements.

  void read_elements(bool has_bins) {
    for (std::string_view line; lines_.next(line);) {
      const std::vector<std::int64_t>& first = lines_.integers(line, has_bins ? 8 : 6, "an element");
      if (first[0] < 0) lines_.fail("the number of this element is negative");
      const std::int64_t descriptor = first[1], n = first.back();
      UnvElement found{find_unv_element_kind(descriptor),
                       lines_.line(),
                       first[0],
                       model_.element_nodes.size(),
                       as_int(first[has_bins ? 3U : 2U]),
                       as_int(first[has_bins ? 5U : 3U]),
                       0};
      if (n < 1) lines_.fail("this element should have nodes, and has " + std::to_string(n));
      if (found.kind != nullptr) check_size(*found.kind, descriptor, n);
      std::string_view nodes = lines_.further();
      if (descriptor <= kMaxUnvBeam && has_beam_line(nodes, n)) {
        count_section(nodes);
        nodes = lines_.further();
      }
      read_nodes_of_element(nodes, n, found.kind != nullptr);
      if (found.kind == nullptr) {
        ++model_.ignored_elements[descriptor];
        continue;
      }
      found.nodes = std::uint8_t(n);
      model_.elements.push_back(found);
    }
  }
  int as_int(std::int64_t number) const {
    constexpr std::int64_t kMax = std::numeric_limits<int>::max();
    if (number >= -kMax && number <= kMax) return int(number);
    lines_.fail("numbers of properties and materials are at most 2147483647, and this one is " +
                std::to_string(number));
  }
  void check_size(const UnvElementKind& kind, std::int64_t descriptor, std::int64_t n) const {
    const std::string what = "this element with the FE descriptor " + std::to_string(descriptor);
    if (kind.role == UnvElementKind::Role::unread) {
      lines_.fail(what + " is of an order that tetune does not read; make the mesh with elements of first or second " +
                  "order");
    }
    if (n == kind.vertices || n == kind.nodes) return;
    const bool is_other = kind.role == UnvElementKind::Role::other;
    lines_.fail(what + " should have " + std::to_string(kind.vertices) + " or " + std::to_string(kind.nodes) +
                " nodes, and has " + std::to_string(n) +
                (is_other && n > kind.nodes ? std::string("; ") + kNodesOnFaces : ""));
  }
  /// Whether a line after the first of a beam is that of its orientation, which some programs leave out.
  bool has_beam_line(std::string_view line, std::int64_t n) {
    const std::int64_t size = std::ssize(lines_.integers(line));
    return size != n || (size == 3 && lines_.size_of_next() == 3);
  }
  /// Counts beams with an orientation or cross sections, which are not kept.
  void count_section(std::string_view line) {
    const std::vector<std::int64_t>& numbers = lines_.integers(line);
    if (std::any_of(numbers.begin(), numbers.end(), [](std::int64_t k) { return k > 1; })) {
      ++model_.beams_with_sections;
    }
  }
  void read_nodes_of_element(std::string_view line, std::int64_t n, bool is_kept) {
    for (std::int64_t read = 0;;) {
      for (const std::int64_t node : lines_.integers(line)) {
        if (++read > n) lines_.fail("this element has more than its " + std::to_string(n) + " nodes");
        if (node < 0) lines_.fail("the number of a node is negative");
        if (is_kept) model_.element_nodes.push_back(node);
      }
      if (read == n) return;
      line = lines_.further();
    }
  }

  // Groups.

  /// Reads groups whose entities have `size` integers each: first a kind and a number.
  void read_groups(std::size_t size) {
    for (std::string_view line; lines_.next(line);) {
      const std::vector<std::int64_t>& first = lines_.integers(line, 8, "a group");
      const std::int64_t entities = first.back();
      UnvGroup group{first[0], {}, {}, {}};
      if (group.number < 0 || entities < 0) lines_.fail("the number of a group, or that of its entities, is negative");
      group.name = without_control_characters(trimmed(lines_.text()));
      for (std::int64_t read = 0; read < entities;) {
        const std::vector<std::int64_t>& numbers = lines_.integers(lines_.further());
        if (numbers.size() % size != 0) {
          lines_.fail("each entity of a group should have " + std::to_string(size) + " integers; this line has " +
                      std::to_string(numbers.size()));
        }
        for (std::size_t k = 0; k < numbers.size(); k += size, ++read) add_member(group, numbers[k], numbers[k + 1]);
        if (read > entities) lines_.fail("this group has more than its " + std::to_string(entities) + " entities");
      }
      model_.groups.push_back(std::move(group));
    }
  }
  void add_member(UnvGroup& group, std::int64_t kind, std::int64_t number) {
    if (number < 0) lines_.fail("the number of an entity is negative");
    if (kind == kUnvNode) {
      group.nodes.push_back(number);
    } else if (kind == kUnvElement) {
      group.elements.push_back(number);
    } else {
      ++model_.ignored_members;
    }
  }

  UnvLines& lines_;
  std::vector<std::string>& warnings_;
  UnvModel model_;
  std::set<std::string> names_;
  std::array<std::map<std::int64_t, Use>, 2> uses_;  ///< by coordinate system: of the part (0), of definition (1)
  std::map<std::int64_t, bool> systems_;             ///< whether a defined system is the global one
};

}  // namespace

UnvModel read_unv_model(UnvLines& lines, std::vector<std::string>& warnings) {
  return UnvParser(lines, warnings).read();
}

}  // namespace tetune

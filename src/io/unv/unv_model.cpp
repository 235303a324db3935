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
    if (set == "15") return read_nodes_of_one_line();
    if (set == "781") return read_nodes_of_two_lines(uses_of_definition_);
    if (set == "2411") return read_nodes_of_two_lines(uses_of_part_);
    if (set == "780") return read_elements({8, 3, 5});
    if (set == "2412") return read_elements({6, 2, 3});
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

  using Fields = std::vector<std::string_view>;

  /// The nodes that name a coordinate system.
  struct Use {
    std::int64_t line;  ///< of the first one
    std::size_t nodes;
  };
  using Uses = std::map<std::int64_t, Use>;  ///< by the number of the system

  /// Reads nodes of single precision, in the definition system of each.
  void read_nodes_of_one_line() {
    for (std::string_view line; lines_.next(line);) {
      const Fields& fields = lines_.fields(line, {kUnvIntegerWidth, kUnvIntegerWidth, kUnvIntegerWidth,
                                                  kUnvIntegerWidth, kUnvSingleWidth, kUnvSingleWidth, kUnvSingleWidth});
      read_node_number(fields, uses_of_definition_);
      read_point(fields, 4);
    }
  }
  /// Reads nodes of double precision.
  void read_nodes_of_two_lines(Uses& uses) {
    for (std::string_view line; lines_.next(line);) {
      read_node_number(lines_.fields(line, {kUnvIntegerWidth, kUnvIntegerWidth, kUnvIntegerWidth, kUnvIntegerWidth}),
                       uses);
      read_point(lines_.fields(lines_.further(), {kUnvRealWidth, kUnvRealWidth, kUnvRealWidth}), 0);
    }
  }
  void read_node_number(const Fields& fields, Uses& uses) {
    model_.node_numbers.push_back(label(fields[0], "the number of a node"));
    model_.node_lines.push_back(lines_.line());
    const std::int64_t system = lines_.integer(fields[1], "the number of a coordinate system");
    ++uses.try_emplace(system, Use{lines_.line(), 0}).first->second.nodes;
  }
  void read_point(const Fields& fields, std::size_t first) {
    Point3 p{};
    for (std::size_t k = 0; k < 3; ++k) p[k] = lines_.real(fields[first + k], "a coordinate");
    model_.points.push_back(p);
  }
  std::int64_t label(std::string_view field, const char* name) const {
    const std::int64_t number = lines_.integer(field, name);
    if (number < 0) lines_.fail(std::string(name) + " is negative");
    return number;
  }

  // Coordinate systems.

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
    std::set<std::int64_t> systems;
    std::size_t nodes = 0;
    for (const Uses* uses : {&uses_of_part_, &uses_of_definition_}) {
      for (const auto& [system, use] : *uses) {
        const auto known = systems_.find(system);
        if (known == systems_.end() ? system == 0 || system == 1 : known->second) continue;
        const std::string number = std::to_string(system);
        if (uses == &uses_of_definition_ && known != systems_.end()) {
          lines_.fail_at(use.line, "the coordinates of this node are in the coordinate system " + number +
                                       ", which is not the global Cartesian one; only that is read. Write the "
                                       "coordinates of all nodes in it");
        }
        nodes += use.nodes;
        systems.insert(system);
      }
    }
    if (nodes == 0) return;
    std::vector<std::string> numbers;
    for (const std::int64_t system : systems) numbers.push_back(std::to_string(system));
    warnings_.push_back(std::to_string(nodes) + " nodes name coordinate systems (" + listed_texts(numbers) +
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

  /// The first line of an element: its number of integers, and the positions of the property and the material.
  struct ElementLine {
    std::size_t integers, property, material;
  };

  void read_elements(const ElementLine& layout) {
    for (std::string_view line; lines_.next(line);) {
      const std::vector<std::int64_t>& first = lines_.integers(line, layout.integers, "an element");
      if (first[0] < 0) lines_.fail("the number of this element is negative");
      const std::int64_t descriptor = first[1], n = first.back();
      UnvElement found{find_unv_element_kind(descriptor),
                       lines_.line(),
                       first[0],
                       model_.element_nodes.size(),
                       as_int(first[layout.property]),
                       as_int(first[layout.material]),
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
  Uses uses_of_part_, uses_of_definition_;  ///< of systems for output, and of those of the coordinates
  std::map<std::int64_t, bool> systems_;    ///< whether a defined system is the global one
};

}  // namespace

UnvModel read_unv_model(UnvLines& lines, std::vector<std::string>& warnings) {
  return UnvParser(lines, warnings).read();
}

}  // namespace tetune

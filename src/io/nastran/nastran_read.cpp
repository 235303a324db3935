// SPDX-License-Identifier: Apache-2.0
// Nastran's bulk data (.bdf, .nas): the Quick Reference Guides of MSC Nastran and Simcenter Nastran.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "backend/span.hpp"
#include "io/element_collector.hpp"
#include "io/nastran/nastran_cards.hpp"
#include "io/nastran/nastran_elements.hpp"
#include "io/nastran/nastran_fields.hpp"
#include "io/nastran/nastran_systems.hpp"
#include "io/node_numbers.hpp"
#include "io/number_index.hpp"
#include "io/plain_text.hpp"
#include "io/real_field.hpp"
#include "io/registry.hpp"
#include "io/second_order.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// An element whose nodes are not resolved.
struct NastranElement {
  NastranPlace place;
  const NastranElementKind* kind;
  int number;
  int property;            ///< 0: it has none
  std::uint8_t nodes;      ///< that are listed: without the mid-side nodes where it has none
  std::size_t first_node;  ///< position in the list of the nodes of all elements
};

/// Whether a card that is not read names nodes or elements by their numbers.
bool names_entities(std::string_view card) {
  constexpr std::array<std::string_view, 34> kStarts{
      "ASET",    "BCONP",  "BLSEG",  "BSET", "BSURF", "CSET", "DAREA",  "DEFORM", "DMIG", "FORCE", "MOMENT", "MPC",
      "OMIT",    "PLOAD",  "PLOTEL", "QBDY", "QHBDY", "QSET", "QVOL",   "RADBC",  "RBAR", "RBE",   "RJOINT", "RROD",
      "RSPLINE", "RSSCON", "SESET",  "SET",  "SLOAD", "SPC",  "SUPORT", "TEMP",   "TIC",  "VIEW"};
  if (card.ends_with("ADD") || card == "TEMPD" || card == "CREEP") return false;
  // Elements.
  if (card.starts_with('C')) return true;
  return std::any_of(kStarts.begin(), kStarts.end(),
                     [card](std::string_view start) { return card.starts_with(start); });
}

class NastranReader {
 public:
  NastranReader(const std::string& path, const IoContext& context)
      : path_(path),
        context_(context),
        cards_(
            path,
            [](const std::string& name) {
              return name == "GRID" || name == "GRDSET" || find_system_kind(name) ||
                     find_nastran_element_kind(name) != nullptr;
            },
            [this](const NastranCard& card) { take(card); }),
        systems_([this](NastranPlace place, const std::string& text) { cards_.fail(place, text); },
                 [this](int node, NastranPlace place) { return position_of(node, place); }) {}

  TetMesh read() {
    cards_.read();
    if (node_numbers_.empty()) {
      cards_.fail(cards_.end(), "the file ends without a GRID card: it is not a mesh in Nastran's bulk data");
    }
    check_count(node_numbers_.size());
    check_count(elements_.size());
    move_to_basic_system();
    index_nodes();
    check_element_numbers();
    for (const NastranElement& element : elements_) add(element);
    mesh_.point_tags.assign(mesh_.points.size(), 0);
    keep_numbers_of_vertices();
    warn_of_cards();
    warn_of_elements();
    erase_mid_side_nodes();
    if (!cards_.has_end()) warn("it does not end with ENDDATA; the file may be cut short");
    return std::move(mesh_);
  }

 private:
  void warn(const std::string& text) const { context_.warn(path_ + ": " + text); }

  void check_count(std::size_t n) const {
    if (const std::string excess = excess_of(std::int64_t(n), kMaxEntries); !excess.empty()) {
      cards_.fail(cards_.end(), "the file has " + excess);
    }
  }

  void take(const NastranCard& card) {
    if (card.name == "GRID") return read_grid(card);
    if (card.name == "GRDSET") {
      default_system_ = system(card, card.field(1)).value_or(0);
      return;
    }
    if (const auto kind = find_system_kind(card.name)) return read_system(card, *kind);
    read_element(card, *find_nastran_element_kind(card.name));
  }

  [[noreturn]] void fail_field(const NastranCard& card, std::size_t k, const std::string& expected) const {
    const std::string_view found = card.field(k);
    cards_.fail(card.place, card.name + ": field " + std::to_string(k + 2) + " should be " + expected + ", and is " +
                                (found.empty() ? "blank" : "\"" + nastran_shown(found) + "\"") +
                                "; fixed fields are 8 columns wide, or 16 where * follows the name of the card");
  }
  int positive(const NastranCard& card, std::size_t k, const char* name) const {
    const std::optional<int> value = parse_nastran_integer(card.field(k));
    if (!value || *value <= 0) fail_field(card, k, name + std::string(", a positive integer"));
    return *value;
  }

  // Nodes.

  /// The coordinate system in a field; nothing where it is blank.
  std::optional<int> system(const NastranCard& card, std::string_view field) const {
    if (field.empty()) return {};
    const std::optional<int> number = parse_nastran_integer(field);
    if (!number || *number < 0) fail_field(card, 1, "the number of a coordinate system");
    return number;
  }

  void read_grid(const NastranCard& card) {
    node_numbers_.push_back(positive(card, 0, "the number of the node"));
    node_places_.push_back(card.place);
    node_systems_.push_back(system(card, card.field(1)).value_or(kDefaultSystem));
    mesh_.points.push_back(to_point(coordinates(card, 2)));
    note_rest(card, 5);
  }
  /// The coordinates in three fields; 0 where one is blank.
  Vec3 coordinates(const NastranCard& card, std::size_t first) const {
    Point3 p{};
    for (std::size_t k = 0; k < 3; ++k) {
      if (card.field(first + k).empty()) continue;
      const std::optional<double> x = parse_fortran_real(card.field(first + k));
      if (!x || !std::isfinite(*x)) fail_field(card, first + k, "a coordinate");
      p[k] = *x;
    }
    return vec(p);
  }

  // Coordinate systems.

  /// The kind of the systems that a card defines.
  static std::optional<NastranSystem::Kind> find_system_kind(const std::string& name) {
    using Kind = NastranSystem::Kind;
    if (name.size() != 6 || !(name.starts_with("CORD1") || name.starts_with("CORD2"))) return {};
    return name[5] == 'R'   ? std::optional(Kind::rectangular)
           : name[5] == 'C' ? std::optional(Kind::cylindrical)
           : name[5] == 'S' ? std::optional(Kind::spherical)
                            : std::nullopt;
  }
  void read_system(const NastranCard& card, NastranSystem::Kind kind) {
    NastranSystem read{.kind = kind, .place = card.place, .has_nodes = card.name[4] == '1'};
    if (!read.has_nodes) {
      read.reference = system(card, card.field(1)).value_or(0);
      for (std::size_t k = 0; k < 3; ++k) read.points[k] = coordinates(card, 2 + 3 * k);
      return systems_.add(positive(card, 0, "the number of the coordinate system"), read);
    }
    for (std::size_t first = 0; first == 0 || (first == 4 && !card.field(first).empty()); first += 4) {
      for (std::size_t k = 0; k < 3; ++k) read.nodes[k] = positive(card, first + 1 + k, "the number of a node");
      systems_.add(positive(card, first, "the number of the coordinate system"), read);
    }
  }
  Vec3 position_of(int node, NastranPlace place) {
    const auto at = std::find(node_numbers_.begin(), node_numbers_.end(), node);
    if (at == node_numbers_.end()) {
      cards_.fail(place, "a coordinate system has node " + std::to_string(node) + ", and no GRID card has this number");
    }
    return in_basic(at - node_numbers_.begin());
  }
  Vec3 in_basic(std::ptrdiff_t node) {
    return systems_.in_basic(span_of(node_systems_)[node], vec(span_of(mesh_.points)[node]),
                             span_of(node_places_)[node]);
  }
  /// GRDSET and the coordinate systems may follow the nodes that they are for.
  void move_to_basic_system() {
    for (int& system : node_systems_) system = system == kDefaultSystem ? default_system_ : system;
    const auto others = std::ssize(node_systems_) - std::count(node_systems_.begin(), node_systems_.end(), 0);
    if (others == 0) return;
    std::vector<Point3> moved;
    for (std::ptrdiff_t v = 0; v < std::ssize(mesh_.points); ++v) moved.push_back(to_point(in_basic(v)));
    mesh_.points = std::move(moved);
    warn(std::to_string(others) +
         " nodes are in other coordinate systems than the basic one, in which they are written");
  }

  void index_nodes() {
    nodes_ = merge_repeated_nodes(node_numbers_, mesh_.points, [this](Index first, Index second) {
      cards_.fail(span_of(node_places_)[second], "GRID " + std::to_string(span_of(node_numbers_)[second]) +
                                                     " is also in " + cards_.text_of(span_of(node_places_)[first]) +
                                                     ", at another position; give one of these nodes another number");
    });
  }

  // Elements.

  void read_element(const NastranCard& card, const NastranElementKind& kind) {
    const int number = positive(card, 0, "the number of the element");
    const int property = card.field(1).empty() ? 0 : positive(card, 1, "the number of the property");
    ++(property == 0 ? without_property_ : with_property_)[kind.dimension()];
    const std::size_t first_node = element_nodes_.size();
    std::uint8_t middles = 0;
    for (std::uint8_t k = 0; k < kind.nodes; ++k) {
      const std::string_view field = card.field(2U + k);
      // Mid-side nodes may be left out.
      const bool is_absent = k >= kind.vertices && (field.empty() || field == "0");
      element_nodes_.push_back(is_absent ? 0 : positive(card, 2U + k, "the number of a node"));
      if (!is_absent && k >= kind.vertices) ++middles;
    }
    const std::uint8_t nodes = middles == 0 ? kind.vertices : kind.nodes;
    element_nodes_.resize(first_node + nodes);
    if (!kind.block.empty() && kind.vertices + middles != nodes) refuse_partial(card, kind);
    if (card.marker.size() > 1 && (card.marker[0] == '+' || card.marker[0] == '*')) {
      cards_.fail(card.place, "the card continues in a line that starts with " + nastran_shown(card.marker) +
                                  ", which does not follow; put it below its card");
    }
    elements_.push_back({card.place, &kind, number, property, nodes, first_node});
    if (kind.card == "CBAR" || kind.card == "CBEAM") bars_.insert(card.name);
    note_rest(card, 2U + kind.nodes);
  }
  /// Such elements do not change, and would get the nodes that they lack on writing.
  [[noreturn]] void refuse_partial(const NastranCard& card, const NastranElementKind& kind) const {
    cards_.fail(card.place, card.name + " lacks some of its " + std::to_string(kind.nodes - kind.vertices) +
                                " mid-side nodes; of these tetune reads all or none. Give this element all of them, "
                                "or none");
  }
  /// Lists the card if it has fields that are not kept.
  void note_rest(const NastranCard& card, std::size_t from) {
    for (std::size_t k = from; k < card.fields.size(); ++k) {
      if (!card.fields[k].empty() && card.fields[k] != "0") rests_.insert(card.name);
    }
  }

  void check_element_numbers() {
    std::vector<std::int64_t> numbers;
    numbers.reserve(elements_.size());
    for (const NastranElement& element : elements_) numbers.push_back(element.number);
    const NumberIndex index(numbers);
    const std::vector<Index>& order = index.order();
    if (!order.empty()) is_renumbered_ = span_of(numbers)[order.back()] != std::ssize(numbers);
    if (index.repeated() < 0) return;
    for (std::size_t i = 1; i < order.size(); ++i) {
      const NastranElement& a = span_of(elements_)[order[i - 1]];
      const NastranElement& b = span_of(elements_)[order[i]];
      if (a.number != b.number) continue;
      cards_.fail(b.place, "the element " + std::to_string(b.number) + " is also in " + cards_.text_of(a.place) +
                               "; give one of these elements another number");
    }
  }

  Index vertex(const NastranElement& element, int number) const {
    const Index rank = nodes_.rank(number);
    if (rank < 0) {
      cards_.fail(element.place, std::string(element.kind->card) + " " + std::to_string(element.number) + " has node " +
                                     std::to_string(number) + ", and no GRID card has this number");
    }
    return span_of(nodes_.order())[rank];
  }

  /// An element without a property has that of its own number. Where no element of the dimension has one, as in files
  /// of meshes alone, they have no tag: each would be a region or patch of its own.
  int tag_of(const NastranElement& element) const {
    if (element.property != 0) return element.property;
    return with_property_[element.kind->dimension()] > 0 ? element.number : 0;
  }

  void add(const NastranElement& element) {
    const NastranElementKind& kind = *element.kind;
    std::array<Index, kMaxNodes> v;
    v.fill(-1);
    for (std::size_t k = 0; k < element.nodes; ++k) {
      if (const int number = element_nodes_[element.first_node + k]; number != 0) v[k] = vertex(element, number);
    }
    const std::span<const Index> nodes = std::span(v).first(element.nodes);
    if (kind.block.empty()) return collector_.add_simplex(nodes, kind.vertices, tag_of(element));
    collector_.add_other(kind.block, nodes, tag_of(element));
  }

  void keep_numbers_of_vertices() {
    const auto for_each_vertex = [this](const auto& visit) {
      for (const NastranElement& element : elements_) {
        for (std::size_t k = 0; k < element.kind->vertices; ++k) {
          visit(element, vertex(element, element_nodes_[element.first_node + k]));
        }
      }
    };
    keep_numbers(node_numbers_, collector_.middles(), mesh_, for_each_vertex,
                 [this](const NastranElement& element, const std::string& text) { cards_.fail(element.place, text); });
  }

  void erase_mid_side_nodes() {
    MiddleList& middles = collector_.middles();
    middles.complete[1] = mesh_.edges.size();  // rods have no mid-side nodes, and get none on writing
    try {
      const auto number_of = [this](Index v) { return span_of(node_numbers_)[v]; };
      for (const std::string& text : erase_middles(middles, mesh_, number_of)) warn(text);
    } catch (const FileError& e) {
      throw FileError(path_ + ": " + e.what());
    }
  }

  // Warnings.

  void warn_of_cards() const {
    if (cards_.has_control()) warn("the statements before BEGIN BULK are not kept");
    if (cards_.ignored().empty()) return;
    warn("the cards " + listed_texts(cards_.ignored()) + " are not kept");
    std::vector<std::string> by_number;
    std::copy_if(cards_.ignored().begin(), cards_.ignored().end(), std::back_inserter(by_number), names_entities);
    if (by_number.empty()) return;
    warn("of these, " + listed_texts(by_number) +
         " may name nodes or elements by their numbers: vertices keep theirs in this format, but elements and " +
         "mid-side nodes get others");
  }

  void warn_of_elements() const {
    if (!rests_.empty()) {
      warn("fields after the nodes or coordinates of " + listed_texts(rests_) +
           " are not kept, such as orientations, offsets, thicknesses and constraints");
    }
    if (!bars_.empty()) warn(listed_texts(bars_) + " are read as edges, which are written as CROD");
    for (std::size_t dimension = 1; dimension <= 3; ++dimension) {
      if (without_property_[dimension] == 0) continue;
      warn(std::to_string(without_property_[dimension]) + " elements of dimension " + std::to_string(dimension) +
           " have no number of a property: " +
           (with_property_[dimension] > 0 ? "it is that of the element" : "they have no tag"));
    }
    if (is_renumbered_) {
      warn("the elements are not numbered from 1 to " + std::to_string(elements_.size()) + ": they get these numbers");
    }
  }

  const std::string& path_;
  const IoContext& context_;
  NastranCards cards_;
  TetMesh mesh_;
  ElementCollector collector_{mesh_, MiddleOrder::base_between_top};
  std::vector<std::int64_t> node_numbers_;
  std::vector<NastranPlace> node_places_;
  NumberIndex nodes_;
  static constexpr int kDefaultSystem = -1;  ///< that of GRDSET
  std::vector<int> node_systems_;            ///< per node
  int default_system_ = 0;
  NastranSystems systems_;
  std::vector<NastranElement> elements_;
  std::vector<int> element_nodes_;                                   ///< 0: none
  std::array<std::size_t, 4> with_property_{}, without_property_{};  ///< numbers of elements, by dimension
  bool is_renumbered_ = false;
  std::set<std::string> rests_, bars_;  ///< names of cards
};

}  // namespace

TetMesh read_nastran(const std::string& path, const IoContext& context) { return NastranReader(path, context).read(); }

std::vector<std::string> included_nastran_files(const std::string& path) {
  NastranCards cards(
      path, [](const std::string&) { return false; }, [](const NastranCard&) {});
  cards.read();
  return {cards.files().begin() + 1, cards.files().end()};
}

}  // namespace tetune

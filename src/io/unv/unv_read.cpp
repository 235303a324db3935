// SPDX-License-Identifier: Apache-2.0
// Universal files of I-deas (.unv): the mesh of their contents.
#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "backend/span.hpp"
#include "io/combinations.hpp"
#include "io/element_collector.hpp"
#include "io/node_numbers.hpp"
#include "io/number_index.hpp"
#include "io/plain_text.hpp"
#include "io/registry.hpp"
#include "io/second_order.hpp"
#include "io/unv/unv_format.hpp"
#include "io/unv/unv_model.hpp"
#include "io/unv/unv_tags.hpp"
#include "mesh/node_sets.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// The number of a data set that is not read, with its contents where these are known.
std::string described_set(const std::string& number) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 13> kKnown{{{"18", "coordinate systems"},
                                                                                  {"55", "results"},
                                                                                  {"56", "results"},
                                                                                  {"57", "results"},
                                                                                  {"58", "functions"},
                                                                                  {"82", "trace lines"},
                                                                                  {"151", "header"},
                                                                                  {"790", "loads"},
                                                                                  {"791", "restraints"},
                                                                                  {"2400", "header of the model"},
                                                                                  {"2414", "results"},
                                                                                  {"2416", "results"},
                                                                                  {"2448", "physical properties"}}};
  const auto* const known =
      std::find_if(kKnown.begin(), kKnown.end(), [&](const auto& entry) { return entry.first == number; });
  return known == kKnown.end() ? number : number + " (" + std::string(known->second) + ")";
}

class UnvReader {
 public:
  UnvReader(const std::string& path, const IoContext& context)
      : path_(path), context_(context), file_(path), lines_(path, file_.bytes()) {}

  TetMesh read() {
    std::vector<std::string> warnings;
    model_ = read_unv_model(lines_, warnings);
    for (const std::string& text : warnings) warn(text);
    if (model_.points.empty()) {
      lines_.fail_at(lines_.line(), "the file ends without nodes (data set 2411): it is not a mesh");
    }
    for (const std::size_t n : {model_.points.size(), model_.elements.size()}) {
      const std::string excess = excess_of(std::int64_t(n), kMaxEntries);
      if (!excess.empty()) lines_.fail_at(lines_.line(), "the file has " + excess);
    }
    index_nodes();
    index_elements();
    find_classes();
    for (std::size_t e = 0; e < model_.elements.size(); ++e) add(e);
    mesh_.point_tags.assign(mesh_.points.size(), 0);
    add_node_sets();
    keep_numbers_of_vertices();
    mesh_.dialect =
        std::string(kUnvDialect) + (model_.has_groups_of_gmsh ? kUnvGroupsOfGmsh : kUnvGroups) + '\n' + model_.units;
    warn_of_contents();
    try {
      const auto number_of = [this](Index v) { return span_of(model_.node_numbers)[v]; };
      for (const std::string& text : erase_middles(collector_.middles(), mesh_, number_of)) warn(text);
    } catch (const FileError& e) {
      throw FileError(path_ + ": " + e.what());
    }
    return std::move(mesh_);
  }

 private:
  void warn(const std::string& text) const { context_.warn(path_ + ": " + text); }

  void index_nodes() {
    mesh_.points = std::move(model_.points);
    nodes_ = merge_repeated_nodes(model_.node_numbers, mesh_.points, [this](Index first, Index second) {
      fail_repeated("node", span_of(model_.node_numbers)[second], span_of(model_.node_lines)[first],
                    span_of(model_.node_lines)[second], "at another position");
    });
  }
  [[noreturn]] void fail_repeated(const char* what, std::int64_t number, std::int64_t before, std::int64_t line,
                                  const char* how) const {
    lines_.fail_at(line, "the " + std::string(what) + " " + std::to_string(number) + " is also in line " +
                             std::to_string(before) + ", " + how + "; give one of them another number");
  }

  /// Erases each element that repeats the number and the nodes of one before it.
  void index_elements() {
    std::vector<UnvElement>& elements = model_.elements;
    std::vector<std::int64_t> numbers;
    const auto number_all = [&] {
      numbers.clear();
      for (const UnvElement& element : elements) numbers.push_back(element.number);
      elements_ = NumberIndex(numbers);
    };
    number_all();
    const std::vector<Index>& order = elements_.order();
    if (!order.empty()) {
      is_renumbered_ = span_of(numbers)[order.front()] != 1 || span_of(numbers)[order.back()] != std::ssize(numbers);
    }
    if (elements_.repeated() < 0) return;
    for (std::size_t i = 1; i < order.size(); ++i) {
      const UnvElement& a = span_of(elements)[order[i - 1]];
      UnvElement& b = span_of(elements)[order[i]];
      if (a.number != b.number) continue;
      const auto first = [&](const UnvElement& e) {
        return model_.element_nodes.begin() + std::ptrdiff_t(e.first_node);
      };
      const bool is_same = a.kind == b.kind && a.nodes == b.nodes && std::equal(first(a), first(a) + a.nodes, first(b));
      if (!is_same) fail_repeated("element", b.number, a.line, b.line, "with other nodes");
      b.line = 0;
    }
    std::erase_if(elements, [](const UnvElement& e) { return e.line == 0; });
    number_all();
  }

  /// Finds the class of each element, by the groups that it is in, and the tag of each class.
  void find_classes() {
    Combinations<Index> combinations;
    std::vector<Index> combination(model_.elements.size(), 0);
    for (Index g = 0; g < std::ssize(model_.groups); ++g) {
      UnvGroup& group = span_of(model_.groups)[g];
      bool is_empty = group.nodes.empty();
      for (const std::int64_t number : group.elements) {
        const Index rank = elements_.rank(number);
        if (rank < 0) {
          ++missing_;
          continue;
        }
        is_empty = false;
        Index& at = span_of(combination)[span_of(elements_.order())[rank]];
        const std::vector<Index>& members = combinations.of(at);
        if (members.empty() || members.back() != g) at = combinations.with(at, g);
      }
      if (is_empty) warn("the group \"" + group.name + "\" has no nodes and elements of the mesh; it is not kept");
    }
    for (std::size_t e = 0; e < combination.size(); ++e) {
      const UnvElement& element = model_.elements[e];
      const std::array<Index, 3> key{element.kind->dimension, element.property, combination[e]};
      const auto [at, is_new] = key2class_.try_emplace(key, std::ssize(classes_));
      if (is_new) classes_.push_back({key[0], key[1], combinations.of(key[2])});
      element2class_.push_back(at->second);
    }
    std::vector<std::int64_t> numbers;
    std::vector<std::string> names;
    for (const UnvGroup& group : model_.groups) {
      numbers.push_back(group.number);
      names.push_back(group.name);
    }
    const std::map<UnvClass, int> class2tag = tags_of_unv_classes(classes_, numbers);
    for (const UnvClass& c : classes_) tags_.push_back(class2tag.at(c));
    mesh_.groups = unv_groups(class2tag, names, numbers);
    if (const std::size_t changed = count_changed_properties(class2tag); changed > 0) {
      warn("elements with one property number are in different groups: " + std::to_string(changed) +
           " of these sets of elements get other tags than that number");
    }
  }

  /// Node k of an element, of which the vertices come first.
  Index node_of(const UnvElement& element, std::size_t k) const {
    const std::size_t place = element.kind->place(element.nodes, k);
    const std::int64_t number = model_.element_nodes[element.first_node + place];
    const Index rank = nodes_.rank(number);
    if (rank >= 0) return span_of(nodes_.order())[rank];
    lines_.fail_at(element.line,
                   "this element has node " + std::to_string(number) + ", and no node of the file has this number");
  }

  void add(std::size_t e) {
    const UnvElement& element = model_.elements[e];
    const UnvElementKind& kind = *element.kind;
    const int tag = span_of(tags_)[element2class_[e]];
    std::array<Index, kMaxNodes> v{};
    for (std::size_t k = 0; k < element.nodes; ++k) v[k] = node_of(element, k);
    const std::span<const Index> nodes = std::span(v).first(element.nodes);
    if (kind.block.empty()) return collector_.add_simplex(nodes, kind.vertices, tag);
    collector_.add_other(kind.block, nodes, tag);
  }

  void add_node_sets() {
    std::int64_t free = 1;
    std::set<std::string> names;
    for (const UnvGroup& group : model_.groups) {
      std::vector<std::uint8_t> in_set(group.nodes.empty() ? 0 : mesh_.points.size(), 0);
      bool is_empty = true;
      for (const std::int64_t number : group.nodes) {
        const Index rank = nodes_.rank(number);
        if (rank < 0) {
          ++missing_;
          continue;
        }
        span_of(in_set)[span_of(nodes_.order())[rank]] = 1;
        is_empty = false;
      }
      if (is_empty) continue;
      const auto name = [&](std::int64_t number) {
        return std::string(kNodeSet) + std::to_string(number) + (group.name.empty() ? "" : ":" + group.name);
      };
      std::string unique = name(group.number);
      while (!names.insert(unique).second) unique = name(free++);
      mesh_.point_data.push_back({unique, 1, std::move(in_set)});
    }
  }

  void keep_numbers_of_vertices() {
    const auto for_each_vertex = [this](const auto& visit) {
      for (const UnvElement& element : model_.elements) {
        for (std::size_t k = 0; k < element.kind->vertices; ++k) visit(element, node_of(element, k));
      }
    };
    keep_numbers(model_.node_numbers, collector_.middles(), mesh_, for_each_vertex,
                 [this](const UnvElement& element, const std::string& text) { lines_.fail_at(element.line, text); });
    // TetMesh::deck_nodes has 0 for inserted vertices, so that it cannot hold a node of this number.
    if (nodes_.rank(0) < 0) return;
    mesh_.deck_nodes.clear();
    warn("a node has the number 0: the nodes are numbered from 1");
  }

  void warn_of_contents() const {
    if (!model_.ignored_sets.empty()) {
      std::vector<std::string> sets;
      for (const std::string& number : model_.ignored_sets) sets.push_back(described_set(number));
      warn("the data sets " + listed_texts(sets) + " are not kept");
    }
    if (lines_.is_open()) warn("it does not end with -1 after the lines of a data set; the file may be cut short");
    if (model_.elements.empty() && model_.ignored_elements.empty()) {
      warn("it has nodes and no elements (data set 2412); the file may be cut short after line " +
           std::to_string(lines_.line()));
    }
    if (!model_.ignored_elements.empty()) {
      std::vector<std::string> descriptors;
      std::size_t n = 0;
      for (const auto& [descriptor, count] : model_.ignored_elements) {
        descriptors.push_back(std::to_string(descriptor));
        n += count;
      }
      warn(std::to_string(n) + " elements with the FE descriptors " + listed_texts(descriptors) + " are not kept");
    }
    if (model_.beams_with_sections > 0) {
      warn("the orientations and cross sections of " + std::to_string(model_.beams_with_sections) +
           " beams are not kept");
    }
    if (model_.ignored_members > 0) {
      warn(std::to_string(model_.ignored_members) + " entities of groups are neither nodes nor elements; they are " +
           "not kept");
    }
    if (missing_ > 0) {
      warn(std::to_string(missing_) + " entities of groups are nodes or elements that the mesh does not have");
    }
    // Numbers of materials that are all equal, or those of the properties, which are written again, are no loss.
    const auto differs = [this](const UnvElement& e) { return e.material != model_.elements[0].material; };
    const auto is_other = [](const UnvElement& e) { return e.material != e.property; };
    const auto any = [this](const auto& is) { return std::any_of(model_.elements.begin(), model_.elements.end(), is); };
    if (any(differs) && any(is_other)) {
      warn("the numbers of materials of elements are not kept");
    }
    if (is_renumbered_) {
      warn("the elements are not numbered from 1 to " + std::to_string(model_.elements.size()) +
           ": they get these numbers");
    }
  }

  const std::string& path_;
  const IoContext& context_;
  MappedFile file_;
  UnvLines lines_;
  UnvModel model_;
  TetMesh mesh_;
  ElementCollector collector_{mesh_, MiddleOrder::base_between_top};
  NumberIndex nodes_, elements_;
  std::map<std::array<Index, 3>, std::ptrdiff_t> key2class_;  ///< by dimension, property and combination of groups
  std::vector<UnvClass> classes_;
  std::vector<int> tags_;  ///< of classes
  std::vector<std::ptrdiff_t> element2class_;
  std::size_t missing_ = 0;
  bool is_renumbered_ = false;
};

}  // namespace

TetMesh read_unv(const std::string& path, const IoContext& context) { return UnvReader(path, context).read(); }

}  // namespace tetune

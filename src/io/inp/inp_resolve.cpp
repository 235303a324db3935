// SPDX-License-Identifier: Apache-2.0
// The nodes, elements and sets that the numbers and names in a deck refer to.
#include <algorithm>

#include "io/inp/inp_data.hpp"
#include "io/inp/inp_middles.hpp"
#include "io/second_order.hpp"
#include "mesh/tet.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

class InpResolver {
 public:
  InpResolver(InpScan& scan, TetMesh& mesh, const std::string& path, const IoContext& context)
      : scan_(scan), model_(scan.model), mesh_(mesh), path_(path), context_(context) {}

  void resolve() {
    model_.nodes = NumberIndex(model_.node_labels);
    model_.elements = NumberIndex(model_.element_labels);
    refuse_repeated();
    if (model_.points.empty()) refuse_ansys_deck(path_, model_.files.front());
    if (model_.points.empty()) fail("the deck has no *NODE card with nodes");
    if (model_.element_labels.empty()) fail("the deck has no *ELEMENT card with elements");
    mesh_.points = model_.points;
    mesh_.point_tags.assign(mesh_.points.size(), 0);
    mesh_.deck_nodes = model_.node_labels;
    resolve_tets();
    hold_unfit_others(scan_);
    for (const InpOther& other : scan_.others) resolve_other(other);
    sort_unique(model_.fixed_middles);
    check_inp_middles(model_, path_);
    resolve_sets();
    resolve_faces();
    resolve_conditions();
  }

 private:
  [[noreturn]] void fail(const std::string& text) const { throw FileError(path_ + ": " + text); }

  /// The place where an element is defined.
  InpPlace place_of_element(Index element) const {
    const Index tet = span_of(model_.element2tet)[element];
    if (tet >= 0) return scan_.place_of(span_of(model_.tet_lines)[tet]);
    return scan_.place_of(scan_.other(element).line);
  }
  void refuse_repeated() const {
    const auto refuse = [](const char* kind, const std::vector<std::int64_t>& labels, std::int64_t repeated,
                           const auto& place_of) {
      if (repeated < 0) return;
      const auto second = std::find(labels.rbegin(), labels.rend(), repeated);
      const auto first = std::find(labels.begin(), labels.end(), repeated);
      const InpPlace other = place_of(to_index(first - labels.begin()));
      place_of(to_index(labels.rend() - second - 1))
          .fail(std::string(kind) + " " + std::to_string(repeated) + " is defined twice, first at " + other.file + ":" +
                std::to_string(other.line));
    };
    refuse("node", model_.node_labels, model_.nodes.repeated(),
           [this](Index node) { return scan_.place_of(span_of(model_.node_lines)[node]); });
    refuse("element", model_.element_labels, model_.elements.repeated(),
           [this](Index element) { return place_of_element(element); });
  }

  Index node_of(std::int64_t label, Index element) const {
    const Index node = model_.node(label);
    if (node >= 0) return node;
    place_of_element(element).fail("element " + std::to_string(span_of(model_.element_labels)[element]) +
                                   " has the node " + std::to_string(label) + ", which is not defined");
  }

  void resolve_tets() {
    model_.tets.resize(model_.tet2element.size());
    auto label = scan_.tet_node_labels.begin();
    for (std::size_t t = 0; t < model_.tets.size(); ++t) {
      const Index element = model_.tet2element[t];
      for (Index& v : model_.tets[t]) v = node_of(*label++, element);
      if (!model_.is_second_order) continue;
      for (const auto& [a, b] : kTetEdges) {
        const auto& v = model_.tets[t];
        model_.middles.emplace_back(ascending(v[to_size_t(a)], v[to_size_t(b)]), node_of(*label++, element));
      }
    }
    scan_.tet_node_labels = {};
    mesh_.tets = model_.tets;
  }

  void resolve_other(const InpOther& other) {
    using Role = InpElementType::Role;
    std::vector<Index> v;
    for (std::size_t i = other.first_node; i < other.end_node; ++i) {
      v.push_back(node_of(scan_.other_nodes[i], other.element));
    }
    if (other.type.is_triangle()) {
      resolve_triangle(other, v);
    } else if (other.type.role == Role::block) {
      ElementBlock& block = inp_block(mesh_, other.type);
      block.element2vertex.insert(block.element2vertex.end(), v.begin(), v.begin() + block.vertices_per_element);
      block.tags.push_back(0);
      if (block.second_order) add_middles_of(*find_element_kind(other.type.kind), v);
    } else if (!other.type.is_edge()) {
      hold_nodes_of(other, scan_, model_, mesh_);
    }
  }

  void resolve_triangle(const InpOther& other, const std::vector<Index>& nodes) {
    InpTriangle& triangle = span_of(model_.triangles)[model_.triangle(other.element)];
    triangle.vertices = {nodes[0], nodes[1], nodes[2]};
  }

  void add_middles_of(const ElementKind& kind, const std::vector<Index>& nodes) {
    model_.is_second_order = true;
    MiddleList middles;
    add_middles(nodes, kind.edges, middles);
    for (const Middle& m : middles.nodes) {
      model_.middles.emplace_back(ascending(m.ends[0], m.ends[1]), m.node);
      model_.fixed_middles.push_back(m.node);
    }
  }

  /// The set that a card refers to by name, or -1.
  Index find_node_set(std::string_view written, bool in_assembly) const {
    return find_set(/*of_nodes=*/true, written, in_assembly);
  }
  Index find_element_set(std::string_view written, bool in_assembly) const {
    return find_set(/*of_nodes=*/false, written, in_assembly);
  }
  Index find_set(bool of_nodes, std::string_view written, bool in_assembly) const {
    const auto found = scan_.names.find({of_nodes, model_.references.key(written, in_assembly)});
    return found == scan_.names.end() ? -1 : found->second;
  }

  void resolve_sets() {
    for (std::size_t c = 0, first = 0; c < model_.node_cards.size(); ++c) {
      // Nodes of a card are consecutive, and cards in the order of the nodes.
      const std::size_t last =
          c + 1 < model_.node_cards.size() ? to_size_t(model_.node_cards[c + 1].first) : model_.node_labels.size();
      const Index set = model_.node_cards[c].set;
      for (; first < last; ++first) {
        if (set >= 0) span_of(model_.sets)[set].members.push_back(to_index(first));
      }
    }
    for (std::size_t e = 0; e < scan_.element2set.size(); ++e) {
      const Index set = scan_.element2set[e];
      if (set >= 0) span_of(model_.sets)[set].members.push_back(to_index(e));
    }
    for (std::size_t c = 0; c < model_.set_cards.size(); ++c) resolve_set_card(c);
    for (InpSet& set : model_.sets) sort_unique(set.members);
    split_inp_sets(model_);
  }

  void resolve_set_card(std::size_t c) {
    InpSetCard& card = model_.set_cards[c];
    InpSet& set = span_of(model_.sets)[card.set];
    InpSetLines& lines = scan_.set_lines[c];
    const auto find = [&](std::int64_t label) { return set.of_nodes ? model_.node(label) : model_.element(label); };
    std::size_t missing = 0;
    for (const std::int64_t label : lines.labels) {
      const Index found = find(label);
      if (found >= 0) {
        card.members.push_back(found);
      } else {
        ++missing;
      }
    }
    if (missing > 0) {
      context_.warn(path_ + ": " + std::to_string(missing) + " numbers in the set " + set.name + " do not exist");
    }
    for (const auto& range : lines.ranges) add_range(range, set.of_nodes, card.members);
    sort_unique(card.members);
    set.members.insert(set.members.end(), card.members.begin(), card.members.end());
    for (const std::string& name : lines.names) {
      Index nested = find_set(set.of_nodes, name, card.in_assembly);
      if (nested < 0 && card.in_assembly) nested = find_set(set.of_nodes, name, false);  // of the instance of the card
      if (nested < 0) scan_.set_places[c].fail("the set " + set.name + " lists " + name + ", which is not defined");
      card.nested.push_back(nested);
      card.names.push_back(name);
      const std::vector<Index> more = span_of(model_.sets)[nested].members;
      set.members.insert(set.members.end(), more.begin(), more.end());
    }
    // Sets of sets would double their members with each level.
    if (!lines.names.empty()) sort_unique(set.members);
    if (card.follows_elements) add_nodes_of(find_element_set(lines.elements, card.in_assembly), set.members);
    lines = {};
  }

  void add_range(const std::array<std::int64_t, 3>& range, bool of_nodes, std::vector<Index>& members) const {
    const auto& [first, last, step] = range;
    const NumberIndex& index = of_nodes ? model_.nodes : model_.elements;
    const std::vector<std::int64_t>& labels = of_nodes ? model_.node_labels : model_.element_labels;
    const auto is_below = [&labels](Index at, std::int64_t label) { return span_of(labels)[at] < label; };
    auto at = std::lower_bound(index.order().begin(), index.order().end(), first, is_below);
    for (; at != index.order().end() && span_of(labels)[*at] <= last; ++at) {
      if ((span_of(labels)[*at] - first) % step == 0) members.push_back(*at);
    }
  }

  void add_nodes_of(Index elements, std::vector<Index>& nodes) const {
    if (elements < 0) return;
    for (const Index e : span_of(model_.sets)[elements].members) {
      const Index t = span_of(model_.element2tet)[e];
      if (t >= 0) nodes.insert(nodes.end(), span_of(model_.tets)[t].begin(), span_of(model_.tets)[t].end());
    }
  }

  void resolve_faces() {
    for (std::size_t c = 0; c < model_.face_cards.size(); ++c) {
      unknown_ = 0;
      for (const InpFaceLine& line : scan_.face_lines[c]) resolve_face_line(line, c);
      if (unknown_ == 0) continue;
      const InpPlace& where = scan_.face_places[c];
      context_.warn(where.file + ":" + std::to_string(where.line) + ": " + std::to_string(unknown_) +
                    " lines of this card have elements or sets that do not exist");
    }
    for (InpFaceGroup& group : model_.face_groups) sort_unique(group.faces);
  }

  void resolve_conditions() {
    for (InpCondition& condition : model_.conditions) {
      if (condition.may_continue) continue;
      for (InpConditionLine& line : condition.lines) {
        const std::vector<std::string_view> fields = inp_fields(line.text);
        std::int64_t label = 0;
        if (fields.empty()) continue;
        if (model_.references.parse_label(fields[0], condition.in_assembly, label)) {
          line.node = model_.node(label);
        } else {
          line.set = find_node_set(fields[0], condition.in_assembly);
        }
      }
    }
  }

  void resolve_face_line(const InpFaceLine& line, std::size_t c) {
    InpFaceCard& card = model_.face_cards[c];
    std::vector<Index> of;
    std::int64_t label = 0;
    Index set = -1;
    if (line.group >= 0 && model_.references.parse_label(line.of, card.in_assembly, label)) {
      of.push_back(model_.element(label));
    } else if (line.group >= 0) {
      set = find_element_set(line.of, card.in_assembly);
      if (set >= 0) of = span_of(model_.sets)[set].members;
    }
    const bool is_known = set >= 0 || (!of.empty() && of[0] >= 0);
    // In the assembly they may be those of other parts.
    if (line.group >= 0 && !is_known && !card.in_assembly) ++unknown_;
    const auto tet_of = [this](Index e) { return e < 0 ? -1 : span_of(model_.element2tet)[e]; };
    for (const Index e : of) {
      if (e >= 0 && tet_of(e) < 0) scan_.held_elements.push_back(span_of(model_.element_labels)[e]);
    }
    if (std::none_of(of.begin(), of.end(), [&](Index e) { return tet_of(e) >= 0; })) {
      card.other_lines += line.line;
      if (set >= 0) scan_.mentioned.insert(span_of(model_.sets)[set].key);
      return;
    }
    InpFaceGroup& group = span_of(model_.face_groups)[line.group];
    if (set >= 0) group.sets.push_back({set, line.face, line.line});
    if (set < 0) group.direct.push_back({of[0], line.face});
    for (const Index e : of) {
      if (tet_of(e) >= 0) {
        group.faces.push_back({e, line.face});
      } else {
        card.other_lines += model_.reference(span_of(model_.element_labels)[e], card.in_assembly) + group.before +
                            std::to_string(line.face) + group.after + model_.newline;
      }
    }
  }

  InpScan& scan_;
  InpModel& model_;
  TetMesh& mesh_;
  const std::string& path_;
  const IoContext& context_;
  std::size_t unknown_ = 0;  ///< lines of a card of faces
};

}  // namespace

void resolve_inp(InpScan& scan, TetMesh& mesh, const std::string& path, const IoContext& context) {
  InpResolver(scan, mesh, path, context).resolve();
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "io/inp/inp_match.hpp"

#include <algorithm>

#include "backend/cpu.hpp"
#include "mesh/csr.hpp"
#include "mesh/tet_orientation.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

std::array<Index, 4> sorted(std::array<Index, 4> v) {
  std::sort(v.begin(), v.end());
  return v;
}

struct LowestNode {
  Span<const std::array<Index, 4>> tets;
  Size operator()(Size t) const { return *std::min_element(tets[t].begin(), tets[t].end()); }
};

class InpMatcher {
 public:
  InpMatcher(const InpModel& model, const TetMesh& mesh) : model_(model), mesh_(mesh) {}

  InpMatch match() {
    if (mesh_.deck_nodes.size() != mesh_.points.size()) {
      throw FileError("the mesh has " + std::to_string(mesh_.points.size()) + " vertices, but the deck " +
                      std::to_string(mesh_.deck_nodes.size()) + " node numbers; write another format");
    }
    match_vertices();
    match_tets();
    last_label_ = *std::max_element(model_.element_labels.begin(), model_.element_labels.end());
    number_changed();
    match_triangles();
    number_changed_triangles();
    return std::move(match_);
  }

 private:
  void match_vertices() {
    std::int64_t next = *std::max_element(model_.node_labels.begin(), model_.node_labels.end());
    match_.node2vertex.assign(model_.node_labels.size(), -1);
    match_.vertex2node.assign(mesh_.points.size(), -1);
    match_.vertex_labels = mesh_.deck_nodes;
    for (Index v = 0; v < std::ssize(mesh_.points); ++v) {
      std::int64_t& label = span_of(match_.vertex_labels)[v];
      if (label == 0) {
        label = ++next;
        match_.inserted.push_back(v);
        continue;
      }
      const Index node = model_.node(label);
      if (node < 0 || span_of(match_.node2vertex)[node] >= 0) {
        throw FileError("the node " + std::to_string(label) +
                        (node < 0 ? " is not in the deck" : " is in the mesh twice") + kNotOfDeck);
      }
      span_of(match_.vertex2node)[v] = node;
      span_of(match_.node2vertex)[node] = v;
    }
  }

  /// The vertices of a tetrahedron of the deck; -1 for those that were removed.
  std::array<Index, 4> vertices_of(Index old) const {
    std::array<Index, 4> v = span_of(model_.tets)[old];
    for (Index& node : v) node = span_of(match_.node2vertex)[node];
    return v;
  }

  void match_tets() {
    const backend::Cpu cpu(1);
    Csr<backend::Cpu> rows;
    build_csr(cpu, std::ssize(model_.points), std::ssize(model_.tets), LowestNode{span_of(model_.tets)}, rows);
    const CsrView by_node = rows.view();
    match_.old2tet.assign(model_.tets.size(), -1);
    match_.is_same.assign(model_.tets.size(), 0);
    match_.tet_labels.assign(mesh_.tets.size(), 0);
    match_.listed = mesh_.tets;
    for (Index t = 0; t < std::ssize(mesh_.tets); ++t) {
      std::array<Index, 4>& listed = span_of(match_.listed)[t];
      if (mesh_.listed_inside_out) std::swap(listed[2], listed[3]);
      std::array<Index, 4> nodes;
      for (std::size_t k = 0; k < 4; ++k) nodes[k] = span_of(match_.vertex2node)[listed[k]];
      nodes = sorted(nodes);
      if (nodes[0] < 0) continue;
      for (Size i = by_node.begin(nodes[0]); i < by_node.end(nodes[0]); ++i) {
        const Index old = to_index(by_node.items[i]);
        const bool is_free = span_of(match_.old2tet)[old] < 0;
        if (!is_free || sorted(span_of(model_.tets)[old]) != nodes ||
            span_of(model_.tet_tags)[old] != span_of(mesh_.tet_tags)[t]) {
          continue;
        }
        take(old, t);
        const std::array<Index, 4> as_listed = vertices_of(old);
        if (as_listed != listed && !is_even_permutation(as_listed, listed)) break;
        listed = as_listed;
        span_of(match_.is_same)[old] = 1;
        break;
      }
    }
  }
  void take(Index old, Index t) {
    span_of(match_.old2tet)[old] = t;
    span_of(match_.tet_labels)[t] = span_of(model_.element_labels)[span_of(model_.tet2element)[old]];
  }

  /// Numbers the entities without a number: those of a group, a region or patch, get the numbers that it has lost, in
  /// the order of the deck, then new ones on the card of the group. `missing`: the last one first. `group_of(i)`: -1
  /// where entity i gets none.
  template <class GroupOf, class Take>
  void number_rest(std::vector<std::vector<Index>>& missing, const std::vector<Index>& group2card,
                   std::vector<std::int64_t>& labels, std::vector<std::vector<Index>>& added, const GroupOf& group_of,
                   const Take& take) {
    for (Index i = 0; i < std::ssize(labels); ++i) {
      const Index group = span_of(labels)[i] != 0 ? -1 : group_of(i);
      if (group < 0) continue;
      std::vector<Index>& free = span_of(missing)[group];
      if (free.empty()) {
        span_of(labels)[i] = ++last_label_;
        span_of(added)[span_of(group2card)[group]].push_back(i);
      } else {
        take(free.back(), i);
        free.pop_back();
      }
    }
  }

  void number_changed() {
    std::vector<std::vector<Index>> missing(model_.regions.size());
    std::vector<Index> last_card(model_.regions.size(), -1);
    for (Index old = to_index(model_.tets.size()) - 1; old >= 0; --old) {
      const Index region = find_inp_tag(model_.regions, span_of(model_.tet_tags)[old]);
      Index& card = span_of(last_card)[region];
      if (card < 0) card = span_of(model_.tet2card)[old];
      if (span_of(match_.old2tet)[old] < 0) span_of(missing)[region].push_back(old);
    }
    match_.added.resize(model_.tet_cards.size());
    const auto region_of = [&](Index t) {
      const int tag = span_of(mesh_.tet_tags)[t];
      const Index region = find_inp_tag(model_.regions, tag);
      if (region >= 0 && span_of(last_card)[region] >= 0) return region;
      throw FileError("a tetrahedron has the tag " + std::to_string(tag) + ", which none of the deck has" + kNotOfDeck);
    };
    number_rest(missing, last_card, match_.tet_labels, match_.added, region_of,
                [this](Index old, Index t) { take(old, t); });
  }

  void match_triangles() {
    std::vector<std::pair<std::array<Index, 3>, Index>> by_nodes;
    for (Index old = 0; old < std::ssize(model_.triangles); ++old) {
      const InpTriangle& t = span_of(model_.triangles)[old];
      if (t.is_face) by_nodes.emplace_back(ascending(t.vertices), old);
    }
    std::sort(by_nodes.begin(), by_nodes.end());
    match_.old2triangle.assign(model_.triangles.size(), -1);
    match_.is_same_triangle.assign(model_.triangles.size(), 0);
    match_.triangle_labels.assign(mesh_.triangles.size(), 0);
    if (by_nodes.empty()) return;
    for (Index i = 0; i < std::ssize(mesh_.triangles); ++i) {
      std::array<Index, 3> nodes = span_of(mesh_.triangles)[i];
      for (Index& v : nodes) v = span_of(match_.vertex2node)[v];
      const auto at = std::lower_bound(by_nodes.begin(), by_nodes.end(), std::pair{ascending(nodes), Index{0}});
      if (at == by_nodes.end() || at->first != ascending(nodes)) continue;
      const InpTriangle& old = span_of(model_.triangles)[at->second];
      if (old.tag != span_of(mesh_.triangle_tags)[i] || span_of(match_.old2triangle)[at->second] >= 0) continue;
      take_triangle(at->second, i);
      span_of(match_.is_same_triangle)[at->second] = is_rotation(nodes, old.vertices) ? 1 : 0;
    }
  }
  static bool is_rotation(std::array<Index, 3> a, const std::array<Index, 3>& b) {
    std::rotate(a.begin(), std::find(a.begin(), a.end(), b[0]), a.end());
    return a == b;
  }
  void take_triangle(Index old, Index i) {
    span_of(match_.old2triangle)[old] = i;
    span_of(match_.triangle_labels)[i] = span_of(model_.element_labels)[span_of(model_.triangles)[old].element];
  }

  void number_changed_triangles() {
    std::vector<std::vector<Index>> missing(model_.patches.size());
    for (Index old = to_index(model_.triangles.size()) - 1; old >= 0; --old) {
      const InpTriangle& t = span_of(model_.triangles)[old];
      if (!t.is_face || span_of(match_.old2triangle)[old] >= 0) continue;
      span_of(missing)[find_inp_tag(model_.patches, t.tag)].push_back(old);
    }
    std::vector<Index> cards;
    for (const InpPatch& patch : model_.patches) cards.push_back(patch.card);
    match_.added_triangles.resize(model_.triangle_cards.size());
    const auto patch_of = [&](Index i) {
      const Index patch = find_inp_tag(model_.patches, span_of(mesh_.triangle_tags)[i]);
      return patch >= 0 && span_of(cards)[patch] >= 0 ? patch : -1;
    };
    number_rest(missing, cards, match_.triangle_labels, match_.added_triangles, patch_of,
                [this](Index old, Index i) { take_triangle(old, i); });
  }

  const InpModel& model_;
  const TetMesh& mesh_;
  std::int64_t last_label_ = 0;  ///< of elements
  InpMatch match_;
};

}  // namespace

InpMatch match_inp(const InpModel& model, const TetMesh& mesh) { return InpMatcher(model, mesh).match(); }

}  // namespace tetune

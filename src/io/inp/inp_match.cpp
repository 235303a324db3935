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
    number_changed();
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

  void number_changed() {
    std::vector<std::vector<Index>> missing(model_.regions.size());
    std::vector<Index> last_card(model_.regions.size(), -1);
    for (Index old = 0; old < std::ssize(model_.tets); ++old) {
      const Index region = find_inp_tag(model_.regions, span_of(model_.tet_tags)[old]);
      span_of(last_card)[region] = span_of(model_.tet2card)[old];
      if (span_of(match_.old2tet)[old] < 0) span_of(missing)[region].push_back(old);
    }
    for (std::vector<Index>& list : missing) std::reverse(list.begin(), list.end());
    match_.added.resize(model_.tet_cards.size());
    std::int64_t next = *std::max_element(model_.element_labels.begin(), model_.element_labels.end());
    for (Index t = 0; t < std::ssize(mesh_.tets); ++t) {
      if (span_of(match_.tet_labels)[t] != 0) continue;
      const int tag = span_of(mesh_.tet_tags)[t];
      const Index region = find_inp_tag(model_.regions, tag);
      if (region < 0 || span_of(last_card)[region] < 0) {
        throw FileError("a tetrahedron has the tag " + std::to_string(tag) + ", which none of the deck has" +
                        kNotOfDeck);
      }
      std::vector<Index>& free = span_of(missing)[region];
      if (free.empty()) {
        span_of(match_.tet_labels)[t] = ++next;
        span_of(match_.added)[span_of(last_card)[region]].push_back(t);
      } else {
        take(free.back(), t);
        free.pop_back();
      }
    }
  }

  const InpModel& model_;
  const TetMesh& mesh_;
  InpMatch match_;
};

}  // namespace

InpMatch match_inp(const InpModel& model, const TetMesh& mesh) { return InpMatcher(model, mesh).match(); }

}  // namespace tetune

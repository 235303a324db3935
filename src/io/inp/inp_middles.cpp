// SPDX-License-Identifier: Apache-2.0
#include "io/inp/inp_middles.hpp"

#include <algorithm>
#include <set>

#include "backend/span.hpp"
#include "io/inp/inp_format.hpp"
#include "mesh/tet.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

std::string name_of(const InpModel& model, Index node) {
  return "node " + std::to_string(span_of(model.node_labels)[node]);
}

/// Per node, whether it is a mid-side node.
std::vector<std::uint8_t> middle_flags(const InpModel& model) {
  std::vector<std::uint8_t> flags(model.points.size(), 0);
  for (const auto& [ends, node] : model.middles) span_of(flags)[node] = 1;
  return flags;
}

/// The mid-side nodes of the elements with one of the tags.
template <class Elements, class Edges>
void collect(const InpModel& model, const Elements& elements, const std::vector<int>& element_tags,
             const std::vector<int>& tags, const Edges& edges, std::vector<Index>& nodes) {
  if (tags.empty()) return;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (std::find(tags.begin(), tags.end(), element_tags[i]) == tags.end()) continue;
    for (const auto& [a, b] : edges) {
      const auto ends = ascending(elements[i][to_size_t(a)], elements[i][to_size_t(b)]);
      const auto at = std::lower_bound(model.middles.begin(), model.middles.end(), std::pair{ends, Index{0}});
      if (at != model.middles.end() && at->first == ends) nodes.push_back(at->second);
    }
  }
}

/// Finds the mid-side nodes that keep their place.
void find_held(InpModel& model, const TetMesh& mesh, const std::vector<std::uint8_t>& is_middle) {
  for (const Index v : mesh.required_vertices) {
    if (span_of(is_middle)[v] != 0) model.held_middles.push_back(v);
  }
  for (InpSet& set : model.sets) {
    if (set.middles.empty()) continue;
    std::vector<Index> follow;
    if (!set.is_held) {
      collect(model, mesh.tets, mesh.tet_tags, set.regions, kTetEdges, follow);
      collect(model, mesh.triangles, mesh.triangle_tags, set.patches, kTriangleEdges, follow);
    }
    sort_unique(follow);
    set.adds_middles =
        !follow.empty() && std::includes(set.middles.begin(), set.middles.end(), follow.begin(), follow.end());
    if (!set.adds_middles) follow.clear();
    std::set_difference(set.middles.begin(), set.middles.end(), follow.begin(), follow.end(),
                        std::back_inserter(model.held_middles));
  }
  sort_unique(model.held_middles);
  erase_listed(model.held_middles, model.fixed_middles);
}

}  // namespace

void check_inp_middles(InpModel& model, const std::string& path) {
  sort_unique(model.middles);
  std::vector<std::uint8_t> taken(model.points.size(), 0);
  if (model.is_second_order) {
    for (const auto& tet : model.tets) {
      for (const Index v : tet) span_of(taken)[v] = 1;
    }
  }
  for (std::size_t i = 0; i < model.middles.size(); ++i) {
    const auto& [ends, node] = model.middles[i];
    const bool is_second = i > 0 && model.middles[i - 1].first == ends;
    if (!is_second && std::exchange(span_of(taken)[node], std::uint8_t{1}) == 0) continue;
    throw FileError(path + ": " + name_of(model, node) + " is a mid-side node of the edge between " +
                    name_of(model, ends[0]) + " and " + name_of(model, ends[1]) +
                    (is_second ? ", which has another one" : ", and also a vertex or on another edge") +
                    "; repair the second-order elements in the program that made them");
  }
}

void split_inp_sets(InpModel& model) {
  if (!model.is_second_order) return;
  const std::vector<std::uint8_t> is_middle = middle_flags(model);
  for (InpSet& set : model.sets) {
    if (!set.of_nodes) continue;
    const auto first = std::stable_partition(set.members.begin(), set.members.end(),
                                             [&](Index v) { return span_of(is_middle)[v] == 0; });
    set.middles.assign(first, set.members.end());
    set.members.erase(first, set.members.end());
  }
}

void erase_inp_middles(InpModel& model, TetMesh& mesh, const std::string& path) {
  if (!model.is_second_order) return;
  const std::vector<std::uint8_t> is_middle = middle_flags(model);
  const auto refuse = [&](Index v) {
    if (span_of(is_middle)[v] == 0) return;
    throw FileError(path + ": " + name_of(model, v) +
                    " is a mid-side node and a vertex of another element; give all elements the same order");
  };
  for (const auto& triangle : mesh.triangles) std::for_each(triangle.begin(), triangle.end(), refuse);
  for (const auto& edge : mesh.edges) std::for_each(edge.begin(), edge.end(), refuse);
  for (const ElementBlock& block : mesh.others) {
    std::for_each(block.element2vertex.begin(), block.element2vertex.end(), refuse);
  }
  find_held(model, mesh, is_middle);
  std::erase_if(mesh.required_vertices, [&](Index v) { return span_of(is_middle)[v] != 0; });
  std::set<std::array<Index, 2>> listed;
  for (const Index e : mesh.required_edges) listed.insert(ascending(span_of(mesh.edges)[e]));
  MiddleList middles;
  for (const auto& [ends, node] : model.middles) {
    middles.nodes.push_back({node, ends});
    if (!std::binary_search(model.held_middles.begin(), model.held_middles.end(), node)) continue;
    mesh.required_vertices.insert(mesh.required_vertices.end(), ends.begin(), ends.end());
    if (listed.contains(ends)) continue;  // as a beam, which is required too
    mesh.required_edges.push_back(to_index(mesh.edges.size()));
    mesh.edges.push_back(ends);
    mesh.edge_tags.push_back(0);
  }
  sort_unique(mesh.required_vertices);
  std::vector<std::int64_t> labels;
  for (std::size_t v = 0; v < is_middle.size(); ++v) {
    if (is_middle[v] == 0) labels.push_back(model.node_labels[v]);
  }
  mesh.deck_nodes = std::move(labels);
  mesh.second_order = true;
  erase_middles(middles, mesh);
  model.is_straight = mesh.curved_edges.empty();
}

Middles add_inp_middles(const InpModel& model, TetMesh& mesh) {
  TetMesh bare;
  bare.points = mesh.points;
  bare.tets = mesh.tets;
  bare.others = mesh.others;
  bare.second_order = true;
  bare.curved_edges = mesh.curved_edges;
  Middles middles(bare);
  std::vector<Index> nodes;
  for (const std::int64_t label : mesh.deck_nodes) nodes.push_back(label == 0 ? -1 : model.node(label));
  mesh.deck_nodes.resize(bare.points.size(), 0);
  std::vector<Index> node2vertex(model.points.size(), -1);
  const auto match = [&](Index a, Index b) {
    const Index p = span_of(nodes)[a];
    const Index q = span_of(nodes)[b];
    const auto ends = ascending(p, q);
    const auto at = std::lower_bound(model.middles.begin(), model.middles.end(), std::pair{ends, Index{0}});
    if (p < 0 || q < 0 || at == model.middles.end() || at->first != ends) return;
    const Index v = middles.of(a, b);
    span_of(node2vertex)[at->second] = v;
    span_of(mesh.deck_nodes)[v] = span_of(model.node_labels)[at->second];
    const bool is_still =
        span_of(model.points)[p] == span_of(mesh.points)[a] && span_of(model.points)[q] == span_of(mesh.points)[b];
    if (model.is_straight && mesh.curved_edges.empty() && is_still) {
      span_of(bare.points)[v] = span_of(model.points)[at->second];  // which differs by rounding
    }
  };
  for (const auto& tet : mesh.tets) {
    for (const auto& [i, j] : kTetEdges) match(tet[to_size_t(i)], tet[to_size_t(j)]);
  }
  for_each_other_middle(bare, match);
  mesh.points = std::move(bare.points);
  for (const Index node : model.held_middles) {
    if (span_of(node2vertex)[node] >= 0) continue;
    throw FileError("the edge of the mid-side " + name_of(model, node) +
                    ", which the deck names, is gone; make the edge required, or take the node out of its card");
  }
  return middles;
}

}  // namespace tetune

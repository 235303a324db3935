// SPDX-License-Identifier: Apache-2.0
#include "io/inp/inp_inserted.hpp"

#include <algorithm>

#include "mesh/transfer/inserted_vertices.hpp"

namespace tetune {
namespace {

/// The nodes by which inserted nodes join sets and get values: they keep their place, unless the mesh is in motion.
std::vector<Index> fixed_nodes(const InpModel& model) {
  std::vector<Index> nodes;
  for (const InpSet& set : model.sets) nodes.insert(nodes.end(), set.rest.begin(), set.rest.end());
  for (const InpCondition& condition : model.conditions) {
    for (const InpConditionLine& line : condition.lines) {
      if (line.node >= 0) nodes.push_back(line.node);
    }
  }
  sort_unique(nodes);
  return nodes;
}

/// The mesh of the deck. After a motion its nodes are where they are now, and tetrahedra without two fixed nodes, or
/// with one that is gone, are left out.
TetMesh mesh_of_deck(const InpModel& model, const TetMesh& mesh, const InpMatch& match,
                     const std::vector<Index>& fixed) {
  TetMesh deck;
  deck.points = model.points;
  deck.tets = model.tets;
  deck.tet_tags = model.tet_tags;
  const auto position = [&](Index node) {
    const Index v = span_of(match.node2vertex)[node];
    return v < 0 ? span_of(model.points)[node] : span_of(mesh.points)[v];
  };
  const auto has_moved = [&](Index node) { return position(node) != span_of(model.points)[node]; };
  if (std::none_of(fixed.begin(), fixed.end(), has_moved)) return deck;
  for (Index node = 0; node < std::ssize(deck.points); ++node) span_of(deck.points)[node] = position(node);
  std::erase_if(deck.tets, [&](const std::array<Index, 4>& tet) {
    const auto is_gone = [&](Index node) { return span_of(match.node2vertex)[node] < 0; };
    const auto is_fixed = [&](Index node) { return std::binary_search(fixed.begin(), fixed.end(), node); };
    return std::any_of(tet.begin(), tet.end(), is_gone) || std::count_if(tet.begin(), tet.end(), is_fixed) < 2;
  });
  deck.tet_tags.assign(deck.tets.size(), 0);
  return deck;
}

/// Sets the ends of the edges of mid-side nodes.
void find_ends(const TetMesh& mesh, const InpMatch& match, const Middles& middles, std::vector<InpInserted>& inserted) {
  std::vector<Index> vertex2inserted(mesh.points.size(), -1);
  for (std::size_t i = 0; i < inserted.size(); ++i) span_of(vertex2inserted)[match.inserted[i]] = to_index(i);
  for (const auto& tet : mesh.tets) {
    for (const auto& [i, j] : kTetEdges) {
      const std::array<Index, 2> ends{tet[to_size_t(i)], tet[to_size_t(j)]};
      const Index n = span_of(vertex2inserted)[middles.of(ends[0], ends[1])];
      if (n < 0) continue;
      InpInserted& node = span_of(inserted)[n];
      node.ends = ends;
      node.has_inserted_end =
          std::any_of(ends.begin(), ends.end(), [&](Index v) { return span_of(vertex2inserted)[v] >= 0; });
    }
  }
}

}  // namespace

std::vector<InpInserted> find_inp_inserted(const InpModel& model, const TetMesh& mesh, const InpMatch& match,
                                           const Middles* middles) {
  if (match.inserted.empty()) return {};
  const std::vector<Index> fixed = fixed_nodes(model);
  if (fixed.empty()) return {};
  std::vector<InpInserted> inserted(match.inserted.size());
  if (middles != nullptr) find_ends(mesh, match, *middles, inserted);
  std::vector<Index> vertices;
  for (const Index v : match.inserted) {
    if (middles == nullptr || !middles->is_middle(v)) vertices.push_back(v);
  }
  const std::vector<InsertedVertex> found = find_inserted(mesh_of_deck(model, mesh, match, fixed), mesh, vertices, {});
  for (std::size_t i = 0; i < found.size(); ++i) {  // vertices precede mid-side nodes
    inserted[i].support = found[i].support;
    inserted[i].nodes = support_of(found[i].place);
    const MeshPlace& place = found[i].place;
    for (const Index node : inserted[i].nodes) {
      const auto k = std::find(place.vertices.begin(), place.vertices.end(), node) - place.vertices.begin();
      inserted[i].weights.push_back(place.weights[to_size_t(k)]);
    }
  }
  return inserted;
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "io/inp/inp_inserted.hpp"

#include <algorithm>

#include "mesh/sorted.hpp"
#include "mesh/surface_edges.hpp"
#include "mesh/transfer/inserted_vertices.hpp"

namespace tetune {
namespace {

/// The vertices by which inserted nodes join sets and get values by number: they keep their place, unless the mesh is
/// in motion.
std::vector<Index> fixed_nodes(const InpModel& model) {
  std::vector<Index> nodes;
  for (const InpSet& set : model.sets) nodes.insert(nodes.end(), set.rest.begin(), set.rest.end());
  for (const InpCondition& condition : model.conditions) {
    for (const InpConditionLine& line : condition.lines) {
      if (line.node >= 0) nodes.push_back(line.node);
    }
  }
  sort_unique(nodes);
  std::vector<Index> middles;
  for (const auto& [ends, node] : model.middles) middles.push_back(node);
  sort_unique(middles);
  erase_listed(nodes, middles);
  return nodes;
}

/// The members of the sets that have values.
std::vector<Index> nodes_with_values_by_sets(const InpModel& model) {
  std::vector<std::uint8_t> has_values(model.sets.size(), 0);
  for (const InpCondition& condition : model.conditions) {
    for (const InpConditionLine& line : condition.lines) {
      if (line.set >= 0) span_of(has_values)[line.set] = 1;
    }
  }
  std::vector<Index> nodes;
  for (std::size_t s = 0; s < has_values.size(); ++s) {
    const std::vector<Index>& members = model.sets[s].members;
    if (has_values[s] != 0) nodes.insert(nodes.end(), members.begin(), members.end());
  }
  sort_unique(nodes);
  return nodes;
}

/// The mesh of the deck. After a motion its nodes are where they are now.
TetMesh mesh_of_deck(const InpModel& model, const TetMesh& mesh, const InpMatch& match, bool has_moved) {
  TetMesh deck;
  deck.points = model.points;
  deck.tets = model.tets;
  deck.tet_tags = model.tet_tags;
  if (!has_moved) return deck;
  for (Index node = 0; node < std::ssize(deck.points); ++node) {
    const Index v = span_of(match.node2vertex)[node];
    if (v >= 0) span_of(deck.points)[node] = span_of(mesh.points)[v];
  }
  return deck;
}

/// The places of vertices after a motion: not in tetrahedra without two nodes that have values, or with a node that is
/// gone.
std::vector<MeshPlace> places_after_motion(const TetMesh& deck, const TetMesh& mesh, const InpMatch& match,
                                           const std::vector<Index>& with_values, const std::vector<Index>& vertices) {
  TetMesh searched = deck;
  std::erase_if(searched.tets, [&](const std::array<Index, 4>& tet) {
    const auto is_gone = [&](Index node) { return span_of(match.node2vertex)[node] < 0; };
    const auto has_value = [&](Index node) { return is_listed(with_values, node); };
    return std::any_of(tet.begin(), tet.end(), is_gone) || std::count_if(tet.begin(), tet.end(), has_value) < 2;
  });
  searched.tet_tags.assign(searched.tets.size(), 0);
  return find_places(searched, mesh, vertices);
}

/// Sets the ends of the edges of mid-side nodes.
void find_ends(const TetMesh& mesh, const InpMatch& match, const Middles& middles, const SurfaceEdges& surface,
               std::vector<InpInserted>& inserted) {
  std::vector<Index> vertex2inserted(mesh.points.size(), -1);
  for (std::size_t i = 0; i < inserted.size(); ++i) span_of(vertex2inserted)[match.inserted[i]] = to_index(i);
  for (const auto& tet : mesh.tets) {
    for (const auto& [i, j] : kTetEdges) {
      const std::array<Index, 2> ends{tet[to_size_t(i)], tet[to_size_t(j)]};
      const Index n = span_of(vertex2inserted)[middles.of(ends[0], ends[1])];
      if (n < 0 || span_of(inserted)[n].is_middle()) continue;
      InpInserted& node = span_of(inserted)[n];
      node.ends = ends;
      node.has_inserted_end =
          std::any_of(ends.begin(), ends.end(), [&](Index v) { return span_of(vertex2inserted)[v] >= 0; });
      node.is_across = surface.is_across(ends[0], ends[1]);
    }
  }
}

}  // namespace

std::vector<InpInserted> find_inp_inserted(const InpModel& model, const TetMesh& mesh, const InpMatch& match,
                                           const Middles* middles) {
  if (match.inserted.empty()) return {};
  const std::vector<Index> fixed = fixed_nodes(model);
  std::vector<Index> with_values = nodes_with_values_by_sets(model);
  with_values.insert(with_values.end(), fixed.begin(), fixed.end());
  sort_unique(with_values);
  if (with_values.empty()) return {};
  std::vector<InpInserted> inserted(match.inserted.size());
  const SurfaceEdges surface(mesh);
  if (middles != nullptr) find_ends(mesh, match, *middles, surface, inserted);
  std::vector<Index> vertices;
  for (const Index v : match.inserted) {
    if (middles == nullptr || !middles->is_middle(v)) vertices.push_back(v);
  }
  const auto has_left = [&](Index node) {
    const Index v = span_of(match.node2vertex)[node];
    return v >= 0 && span_of(mesh.points)[v] != span_of(model.points)[node];
  };
  // Other nodes with values by sets move in an optimization too, but not all of them.
  const bool has_moved = fixed.empty() ? std::all_of(with_values.begin(), with_values.end(), has_left)
                                       : std::any_of(fixed.begin(), fixed.end(), has_left);
  const TetMesh deck = mesh_of_deck(model, mesh, match, has_moved);
  std::vector<MeshPlace> places;
  if (has_moved) places = places_after_motion(deck, mesh, match, with_values, vertices);
  const std::vector<InsertedVertex> found = find_inserted(deck, mesh, surface.on_surface(), vertices, places);
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

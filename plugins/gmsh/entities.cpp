// SPDX-License-Identifier: GPL-2.0-or-later
// Elements by kind, and the entities of Gmsh that they belong to.
#include "entities.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

#include "io/tag_numbers.hpp"
#include "mesh/listed_faces.hpp"

namespace tetune::plugin {
namespace {

template <std::size_t N>
Kind kind_of(int dimension, int type, const std::vector<std::array<Index, N>>& elements, const std::vector<int>& tags,
             const std::vector<DataArray>& data, std::vector<Pair> middles) {
  Kind kind{dimension, type, N, {}, &tags, &data, std::move(middles), {}};
  for (const auto& e : elements) kind.element2vertex.insert(kind.element2vertex.end(), e.begin(), e.end());
  return kind;
}

}  // namespace

std::vector<Kind> kinds_of(const TetMesh& mesh) {
  const auto pairs = [&mesh](const auto& edges) {
    return mesh.second_order ? std::vector<Pair>(edges.begin(), edges.end()) : std::vector<Pair>();
  };
  const bool second = mesh.second_order;
  std::vector<Kind> kinds;
  kinds.push_back(kind_of(3, second ? kTet10 : kTet, mesh.tets, mesh.tet_tags, mesh.tet_data, pairs(kGmshTetEdges)));
  kinds.push_back(kind_of(2, second ? kTriangle6 : kTriangle, mesh.triangles, mesh.triangle_tags, mesh.triangle_data,
                          pairs(kTriangleEdges)));
  kinds.push_back(kind_of(1, second ? kEdge3 : kEdge, mesh.edges, mesh.edge_tags, mesh.edge_data, pairs(kEdgeEdges)));
  for (const ElementBlock& block : mesh.others) {
    const std::size_t list = list_of(mesh, block);
    if (list == kOtherLists) throw FileError("Gmsh has no elements of kind " + block.kind);
    const std::span<const Pair> edges = middle_edges(mesh, block, MiddleOrder::gmsh);
    kinds.push_back({kind_of_list(list).dimension,
                     kOtherTypes[list],
                     std::size_t(block.vertices_per_element),
                     block.element2vertex,
                     &block.tags,
                     &block.data,
                     {edges.begin(), edges.end()},
                     {}});
  }
  return kinds;
}

std::map<int, int> find_entities(std::vector<Kind>& kinds, int dimension, const std::vector<Group>& groups) {
  std::set<int> tags;
  for (const Kind& kind : kinds) {
    if (kind.dimension == dimension) tags.insert(kind.tags->begin(), kind.tags->end());
  }
  // add_groups() makes groups of such numbers.
  std::set<int> taken;
  for (const Group& group : groups) taken.insert(group.number);
  const std::map<int, int> tag2entity = numbers_of_tags(tags, std::move(taken), std::numeric_limits<int>::max());
  std::map<int, int> entity2tag;
  for (const auto& [tag, entity] : tag2entity) entity2tag[entity] = tag;
  for (Kind& kind : kinds) {
    if (kind.dimension != dimension) continue;
    for (const int tag : *kind.tags) kind.entities.push_back(tag2entity.at(tag));
  }
  return entity2tag;
}

Boundaries::Boundaries(const std::vector<Kind>& kinds, int dimension, std::size_t vertices) {
  if (dimension == 0) return;
  using Side = std::array<Index, 3>;
  std::vector<std::pair<Side, Index>> listed;  // sides with their entities
  // Simplices only: a side has all vertices but one.
  const auto is_simplex = [](const Kind& kind) { return kind.corners == std::size_t(kind.dimension) + 1; };
  for (const Kind& kind : kinds) {
    if (kind.dimension != dimension - 1 || !is_simplex(kind)) continue;
    for (std::size_t e = 0; e < kind.size(); ++e) {
      const auto corners = entry_of(kind.element2vertex, std::int64_t(e), kind.corners);
      Side side{-1, -1, -1};
      std::copy(corners.begin(), corners.end(), side.begin());
      listed.emplace_back(side, kind.entities[e]);
    }
  }
  const ListedFaces<3> sides(std::move(listed), vertices);
  for (const Kind& kind : kinds) {
    if (kind.dimension != dimension || !is_simplex(kind)) continue;
    for (std::size_t e = 0; e < kind.size(); ++e) {
      for (std::size_t left_out = 0; left_out < kind.corners; ++left_out) {
        Side side{-1, -1, -1};
        for (std::size_t k = 0, at = 0; k < kind.corners; ++k) {
          if (k != left_out) side[at++] = kind.element2vertex[e * kind.corners + k];
        }
        sides.find(side, [&](Index entity) { entity2sides_[kind.entities[e]].insert(entity); });
      }
    }
  }
}

std::vector<int> Boundaries::of(int entity) const {
  const auto at = entity2sides_.find(entity);
  return at == entity2sides_.end() ? std::vector<int>() : std::vector<int>(at->second.begin(), at->second.end());
}

}  // namespace tetune::plugin

// SPDX-License-Identifier: Apache-2.0
#include "curved/curved_splits.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "backend/span.hpp"
#include "curved/jacobian.hpp"
#include "mesh/id_maps.hpp"
#include "mesh/tet.hpp"
#include "tetune/data.hpp"

namespace tetune {
namespace {

using Edge = std::array<Index, 2>;

/// The longest edge of a tetrahedron that is not held; {-1, -1} if there is none.
Edge edge_to_split(const TetMesh& mesh, const HeldNodes& held, const std::array<Index, 4>& tet) {
  Edge longest{-1, -1};
  double length = 0;
  for (const auto& [i, j] : kCurvedTetEdges) {
    if (held.has_edge(tet[i], tet[j])) continue;
    const double l = norm(vec(span_of(mesh.points)[tet[j]]) - vec(span_of(mesh.points)[tet[i]]));
    if (l > length) {
      length = l;
      longest = ascending(tet[i], tet[j]);
    }
  }
  return longest;
}

/// The tetrahedra around each edge of a set.
std::map<Edge, std::vector<Index>> find_stars(const TetMesh& mesh, const std::set<Edge>& edges) {
  std::map<Edge, std::vector<Index>> stars;
  for (Index t = 0; t < std::ssize(mesh.tets); ++t) {
    const auto& tet = span_of(mesh.tets)[t];
    for (const auto& [i, j] : kCurvedTetEdges) {
      const Edge edge = ascending(tet[i], tet[j]);
      if (edges.contains(edge)) stars[edge].push_back(t);
    }
  }
  return stars;
}

void split(TetMesh& mesh, const Edge& edge, const std::vector<Index>& star, std::vector<Index>& new2old,
           Origins& origins) {
  const Index x = to_index(mesh.points.size());
  mesh.points.push_back(midpoint(span_of(mesh.points)[edge[0]], span_of(mesh.points)[edge[1]]));
  mesh.point_tags.push_back(0);
  if (!mesh.deck_nodes.empty()) mesh.deck_nodes.push_back(0);
  origins.vertices.push_back(-1);
  for (const Index t : star) {
    std::array<Index, 4> other = span_of(mesh.tets)[t];
    std::replace(span_of(mesh.tets)[t].begin(), span_of(mesh.tets)[t].end(), edge[0], x);
    std::replace(other.begin(), other.end(), edge[1], x);
    mesh.tets.push_back(other);
    mesh.tet_tags.push_back(span_of(mesh.tet_tags)[t]);
    origins.tets.push_back(span_of(origins.tets)[t]);
    new2old.push_back(t);
  }
}

}  // namespace

Origins own_origins(const TetMesh& mesh) { return {identity_map(mesh.tets.size()), identity_map(mesh.points.size())}; }

std::vector<Index> split_edges(TetMesh& mesh, const HeldNodes& held, const std::vector<Index>& tets, double max_tets,
                               Origins& origins) {
  std::set<Edge> chosen;
  std::vector<Edge> order;
  for (const Index t : tets) {
    const Edge edge = edge_to_split(mesh, held, span_of(mesh.tets)[t]);
    if (edge[0] >= 0 && chosen.insert(edge).second) order.push_back(edge);
  }
  const std::map<Edge, std::vector<Index>> stars = find_stars(mesh, chosen);
  std::vector<std::uint8_t> is_split(mesh.tets.size(), 0);
  std::vector<Index> new2old = identity_map(mesh.tets.size());
  std::set<Edge> gone;
  for (const Edge& edge : order) {
    const std::vector<Index>& star = stars.at(edge);
    if (std::any_of(star.begin(), star.end(), [&](Index t) { return span_of(is_split)[t] != 0; })) continue;
    if (double(mesh.tets.size() + star.size()) > max_tets) continue;
    for (const Index t : star) span_of(is_split)[t] = 1;
    split(mesh, edge, star, new2old, origins);
    gone.insert(edge);
  }
  if (gone.empty()) return {};
  std::erase_if(mesh.curved_edges, [&gone](const CurvedEdge& e) { return gone.contains(e.vertices); });
  mesh.tet_data = take_entries(mesh.tet_data, new2old);
  std::vector<Index> around;
  for (Index t = 0; t < std::ssize(mesh.tets); ++t) {
    if (t >= std::ssize(is_split) || span_of(is_split)[t] != 0) around.push_back(t);
  }
  return around;
}

}  // namespace tetune

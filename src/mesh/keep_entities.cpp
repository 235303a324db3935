// SPDX-License-Identifier: Apache-2.0
#include "mesh/keep_entities.hpp"

#include <algorithm>

#include "backend/span.hpp"

namespace tetune {
namespace {

/// Removes the entries without a new position from lists of the same length; returns their number.
template <class... Lists>
std::int64_t move_kept(const std::vector<Index>& old2new, Lists&... lists) {
  const Size size = std::ssize(old2new);
  Size kept = 0;
  for (Size i = 0; i < size; ++i) {
    if (span_of(old2new)[i] < 0) continue;
    ((span_of(lists)[kept] = span_of(lists)[i]), ...);
    ++kept;
  }
  (lists.erase(lists.begin() + kept, lists.end()), ...);
  return size - kept;
}

template <class Ids>
void renumber(Ids& ids, const std::vector<Index>& old2new) {
  for (Index& id : ids) id = span_of(old2new)[id];
}

}  // namespace

std::vector<Index> positions_of_kept(const std::vector<std::uint8_t>& keep) {
  std::vector<Index> old2new(keep.size(), -1);
  Index kept = 0;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (keep[i] != 0) old2new[i] = kept++;
  }
  return old2new;
}

std::int64_t keep_triangles(TetMesh& mesh, const std::vector<Index>& old2new) noexcept {
  renumber(mesh.required_triangles, old2new);
  return move_kept(old2new, mesh.triangles, mesh.triangle_tags);
}

std::int64_t keep_edges(TetMesh& mesh, const std::vector<Index>& old2new) noexcept {
  renumber(mesh.ridges, old2new);
  renumber(mesh.required_edges, old2new);
  return move_kept(old2new, mesh.edges, mesh.edge_tags);
}

void keep_vertices(TetMesh& mesh, const std::vector<Index>& old2new) noexcept {
  if (mesh.deck_nodes.empty()) {
    move_kept(old2new, mesh.points, mesh.point_tags);
  } else {
    move_kept(old2new, mesh.points, mesh.point_tags, mesh.deck_nodes);
  }
  for (auto& tet : mesh.tets) renumber(tet, old2new);
  for (auto& triangle : mesh.triangles) renumber(triangle, old2new);
  for (auto& edge : mesh.edges) renumber(edge, old2new);
  for (ElementBlock& block : mesh.others) renumber(block.element2vertex, old2new);
  renumber(mesh.required_vertices, old2new);
  for (PeriodicLink& link : mesh.periodic) {
    for (auto& pair : link.pairs) renumber(pair, old2new);
  }
  for (CurvedEdge& edge : mesh.curved_edges) renumber(edge.vertices, old2new);
  renumber(mesh.corners, old2new);
  mesh.corners.erase(std::remove(mesh.corners.begin(), mesh.corners.end(), -1), mesh.corners.end());
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "driver/carry_vertex_sets.hpp"

#include <algorithm>

#include "backend/span.hpp"
#include "mesh/node_sets.hpp"
#include "mesh/tet_orientation.hpp"
#include "mesh/transfer/inserted_vertices.hpp"

namespace tetune {
namespace {

/// Whether the mesh has tags of vertices or sets of nodes.
bool has_vertex_sets(const TetMesh& mesh) {
  return std::any_of(mesh.point_tags.begin(), mesh.point_tags.end(), [](int tag) { return tag != 0; }) ||
         std::any_of(mesh.point_data.begin(), mesh.point_data.end(), is_node_set);
}

/// Sets the sets of nodes of the result, in the order of those before.
void carry_node_sets(const std::vector<DataArray>& before, const std::vector<Index>& new2original,
                     const std::vector<InsertedVertex>& inserted, std::vector<DataArray>& after) {
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (!is_node_set(before[i])) continue;
    const auto from = span_of(std::get<std::vector<std::uint8_t>>(before[i].values));
    const auto to = span_of(std::get<std::vector<std::uint8_t>>(after[i].values));
    for (Size v = 0; v < to.size(); ++v) {
      const Size original = new2original.empty() ? v : Size{span_of(new2original)[v]};
      if (original >= 0) to[v] = from[original];
    }
    for (const InsertedVertex& v : inserted) {
      to[v.id] = std::uint8_t(v.common_value([&](Index original) { return int{from[original]}; }));
    }
  }
}

}  // namespace

std::vector<int> carry_vertex_sets(const TetMesh& mesh, const std::vector<Index>& new2original,
                                   const std::vector<MeshPlace>& places, const std::function<TetMesh()>& result,
                                   std::vector<DataArray>& point_data) {
  std::vector<Index> ids;
  for (Index v = 0; v < std::ssize(new2original); ++v) {
    if (span_of(new2original)[v] < 0) ids.push_back(v);
  }
  std::vector<int> tags(ids.size(), 0);
  if (!has_vertex_sets(mesh)) return tags;
  std::vector<InsertedVertex> inserted;
  if (result && !ids.empty()) {
    const TetMesh shape = result();
    inserted = find_inserted(mesh, shape, mark_vertices(find_surface_faces(shape), shape.points.size()), ids, places);
  }
  carry_node_sets(mesh.point_data, new2original, inserted, point_data);
  std::transform(inserted.begin(), inserted.end(), tags.begin(), [&mesh](const InsertedVertex& v) {
    return v.common_value([&mesh](Index original) { return span_of(mesh.point_tags)[original]; });
  });
  return tags;
}

}  // namespace tetune

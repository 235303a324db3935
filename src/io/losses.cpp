// SPDX-License-Identifier: Apache-2.0
#include "io/losses.hpp"

#include <algorithm>
#include <set>
#include <string>

namespace tetune {

bool has_tag(const std::vector<int>& tags) {
  return std::any_of(tags.begin(), tags.end(), [](int tag) { return tag != 0; });
}

void warn_of_lists(const TetMesh& mesh, const IoContext& context) {
  bool is_listed = std::any_of(mesh.others.begin(), mesh.others.end(),
                               [](const ElementBlock& block) { return !block.required.empty(); });
  for (const auto* list : {&mesh.corners, &mesh.required_vertices, &mesh.ridges, &mesh.required_edges,
                           &mesh.required_triangles, &mesh.required_tets}) {
    is_listed = is_listed || !list->empty();
  }
  if (is_listed) context.warn("the format cannot hold lists of corners, ridges and required entities");
}

void warn_of_point_tags(const TetMesh& mesh, const IoContext& context) {
  if (has_tag(mesh.point_tags)) context.warn("the format cannot hold tags of vertices");
}

void warn_of_data(const TetMesh& mesh, const IoContext& context, const char* kept) {
  std::set<std::string> names;
  const auto add = [&names](const std::vector<DataArray>& data) {
    for (const DataArray& array : data) names.insert(array.name);
  };
  for (const auto* data : {&mesh.point_data, &mesh.tet_data, &mesh.triangle_data, &mesh.edge_data}) add(*data);
  for (const ElementBlock& block : mesh.others) add(block.data);
  if (kept != nullptr) names.erase(kept);
  for (const std::string& name : names) context.warn("the format cannot hold the data \"" + name + "\"");
}

void warn_of_names(const TetMesh& mesh, const IoContext& context) {
  if (std::any_of(mesh.groups.begin(), mesh.groups.end(), [](const Group& group) { return !group.name.empty(); })) {
    context.warn("the format cannot hold the names of groups");
  }
}

}  // namespace tetune

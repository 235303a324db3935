// SPDX-License-Identifier: Apache-2.0
#include "driver/curved/curved_sheets.hpp"

#include <algorithm>
#include <map>

#include "backend/span.hpp"
#include "boundary/classify.hpp"
#include "mesh/tet.hpp"
#include "mesh/tet_orientation.hpp"

namespace tetune {

std::vector<SheetTriangle> find_sheets(const TetMesh& mesh) {
  std::map<std::array<Index, 3>, int> tags;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.triangle_tags[i] != 0) tags[ascending(mesh.triangles[i])] = mesh.triangle_tags[i];
  }
  std::vector<SheetTriangle> sheets;
  for_each_face(sorted_half_faces(mesh), [&](auto begin, auto end) {
    const int first = span_of(mesh.tet_tags)[begin->tet];
    const int last = span_of(mesh.tet_tags)[(end - 1)->tet];
    const auto tag = tags.find(begin->vertices);
    const bool is_boundary = end - begin == 1;
    if (!is_boundary && first == last && tag == tags.end()) return;
    // The second region is -1 on the boundary, which is then in other sheets than interfaces.
    const std::array<int, 3> sides{tag == tags.end() ? 0 : tag->second, std::min(first, last),
                                   is_boundary ? -1 : std::max(first, last)};
    sheets.push_back({begin->vertices, sides});
  });
  return sheets;
}

std::vector<std::array<Index, 2>> find_lines(const TetMesh& mesh) {
  std::map<Index, int> degrees;
  std::vector<std::array<Index, 2>> tagged;
  for (std::size_t i = 0; i < mesh.edges.size(); ++i) {
    if (mesh.edge_tags[i] == 0) continue;
    tagged.push_back(ascending(mesh.edges[i][0], mesh.edges[i][1]));
    for (const Index v : mesh.edges[i]) ++degrees[v];
  }
  const auto junctions = std::count_if(degrees.begin(), degrees.end(), [](const auto& d) { return d.second > 2; });
  std::vector<std::array<Index, 2>> lines;
  if (can_be_features(junctions, std::ssize(degrees))) lines = tagged;
  const auto add = [&](Index i) { lines.push_back(ascending(span_of(mesh.edges)[i][0], span_of(mesh.edges)[i][1])); };
  std::for_each(mesh.ridges.begin(), mesh.ridges.end(), add);
  std::for_each(mesh.required_edges.begin(), mesh.required_edges.end(), add);
  std::sort(lines.begin(), lines.end());
  return lines;
}

}  // namespace tetune

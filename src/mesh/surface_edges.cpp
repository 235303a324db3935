// SPDX-License-Identifier: Apache-2.0
// Without the library's threads: plugins are built with this file alone.
#include "mesh/surface_edges.hpp"

#include <algorithm>
#include <utility>

namespace tetune {

SurfaceEdges::SurfaceEdges(const TetMesh& mesh) : on_surface_(mesh.points.size(), 0) {
  std::vector<std::pair<std::array<Index, 3>, int>> faces;  // and their regions
  faces.reserve(4 * mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t k = 0; k < 4; ++k) faces.emplace_back(ascending_face(mesh.tets[t], k), mesh.tet_tags[t]);
  }
  std::sort(faces.begin(), faces.end());
  for (auto face = faces.begin(); face != faces.end();) {
    const auto& v = face->first;
    const auto next = std::find_if(face, faces.end(), [&v](const auto& other) { return other.first != v; });
    const bool is_inside = next - face == 2 && face->second == (face + 1)->second;
    for (std::size_t k = 0; k < 3 && !is_inside; ++k) {
      span_of(on_surface_)[v[k]] = 1;
      edges_.push_back(ascending(v[k], v[(k + 1) % 3]));
    }
    face = next;
  }
  sort_unique(edges_);
}

}  // namespace tetune

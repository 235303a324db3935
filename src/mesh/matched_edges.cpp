// SPDX-License-Identifier: Apache-2.0
#include "mesh/matched_edges.hpp"

#include <algorithm>

#include "mesh/sorted.hpp"
#include "mesh/tet.hpp"

namespace tetune {
namespace {

using Edge = std::array<Index, 2>;

/// An edge of the mesh with a number: of an edge of the model, or of the face of a triangle that has the edge.
struct NumberedEdge {
  Edge vertices;
  std::int32_t number;
  bool operator==(const NumberedEdge&) const = default;
  bool operator<(const NumberedEdge& other) const {
    return vertices != other.vertices ? vertices < other.vertices : number < other.number;
  }
};

std::vector<NumberedEdge> edges_on_model(const GeometryMatch& match) {
  std::vector<NumberedEdge> edges;
  for (std::size_t i = 0; i < match.edges.size(); ++i) {
    edges.push_back({ascending(match.edges[i]), match.edge_numbers[i]});
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

std::vector<NumberedEdge> sides_of(const GeometryMatch& match) {
  std::vector<NumberedEdge> sides;
  sides.reserve(3 * match.triangles.size());
  for (std::size_t t = 0; t < match.triangles.size(); ++t) {
    const auto& triangle = match.triangles[t];
    for (std::size_t k = 0; k < 3; ++k) {
      sides.push_back({ascending(triangle[k], triangle[(k + 1) % 3]), match.faces[t]});
    }
  }
  sort_unique(sides);
  return sides;
}

}  // namespace

std::vector<MatchedEdge> edges_of(const GeometryMatch& match) {
  const std::vector<NumberedEdge> on_model = edges_on_model(match);
  const std::vector<NumberedEdge> sides = sides_of(match);
  std::vector<MatchedEdge> edges;
  auto known = on_model.begin();
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    const Edge& vertices = sides[begin].vertices;
    while (end < sides.size() && sides[end].vertices == vertices) ++end;
    MatchedEdge edge{vertices, {kNoEntity, 0}, {sides[begin].number, end - begin > 1 ? sides[begin + 1].number : 0}};
    while (known != on_model.end() && known->vertices < vertices) ++known;
    if (known != on_model.end() && known->vertices == vertices) {
      edge.entity = {1, known->number};
    } else if (end - begin == 1 && edge.faces[0] > 0) {
      edge.entity = {2, edge.faces[0]};
    }
    edges.push_back(edge);
  }
  return edges;
}

}  // namespace tetune

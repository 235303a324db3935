// SPDX-License-Identifier: Apache-2.0
#include "io/element_collector.hpp"

#include "backend/span.hpp"
#include "io/element_blocks.hpp"

namespace tetune {

void ElementCollector::add_simplex(std::span<const Index> nodes, std::size_t vertices, int tag) {
  std::span<const Pair> edges;
  if (vertices == 4) {
    mesh_.tets.push_back({nodes[0], nodes[1], nodes[2], nodes[3]});
    mesh_.tet_tags.push_back(tag);
    edges = kTetEdges;
  } else if (vertices == 3) {
    mesh_.triangles.push_back({nodes[0], nodes[1], nodes[2]});
    mesh_.triangle_tags.push_back(tag);
    edges = kTriangleEdges;
  } else {
    mesh_.edges.push_back({nodes[0], nodes[1]});
    mesh_.edge_tags.push_back(tag);
    edges = kEdgeEdges;
  }
  if (nodes.size() > vertices) add_middles(nodes, edges, middles_);
}

void ElementCollector::add_other(std::string_view kind, std::span<const Index> nodes, int tag) {
  const ElementKind& known = *find_element_kind(kind);
  const bool is_second_order = nodes.size() > to_size_t(known.vertices);
  ElementBlock& block = element_block(mesh_, kind, known.vertices, is_second_order);
  block.element2vertex.insert(block.element2vertex.end(), nodes.begin(), nodes.begin() + known.vertices);
  block.tags.push_back(tag);
  if (is_second_order) add_middles(nodes, edges_of_kind(kind, order_), middles_);
}

}  // namespace tetune

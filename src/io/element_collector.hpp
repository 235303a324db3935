// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "io/second_order.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// Adds the elements that a reader finds, with their tags, to a mesh, and lists their mid-side nodes.
class ElementCollector {
 public:
  /// `order`: that of the mid-side nodes of other kinds than simplices; those of simplices are in the order of
  /// kTetEdges and kTriangleEdges.
  ElementCollector(TetMesh& mesh, MiddleOrder order) : mesh_(mesh), order_(order) {}

  /// Adds an edge, triangle or tetrahedron, or an element of a kind of ElementBlock. `nodes`: its vertices, then in an
  /// element of second order a node per edge, or -1 where an edge of a simplex has none.
  void add_simplex(std::span<const Index> nodes, std::size_t vertices, int tag);
  void add_other(std::string_view kind, std::span<const Index> nodes, int tag);

  /// The mid-side nodes of all elements so far.
  MiddleList& middles() { return middles_; }
  const MiddleList& middles() const { return middles_; }

 private:
  TetMesh& mesh_;
  MiddleOrder order_;
  MiddleList middles_;
};

}  // namespace tetune

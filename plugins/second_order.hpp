// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune::plugin {

/// The edges of a tetrahedron, triangle and edge as both VTK's second-order elements number their middles (Gmsh's
/// tetrahedron: the last two the other way round).
using Pair = std::array<int, 2>;
inline constexpr std::array<Pair, 6> kTetEdges{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
inline constexpr std::array<Pair, 3> kTriangleEdges{{{0, 1}, {1, 2}, {2, 0}}};
inline constexpr std::array<Pair, 1> kEdgeEdges{{{0, 1}}};

/// A node in the middle of an edge.
struct Middle {
  Index node;
  std::array<Index, 2> ends;
};

/// Leaves out the nodes in the middles of edges, and their data. Throws FileError where one is not in the middle: the
/// element is curved; or where one is a vertex of another element.
void leave_out(const std::vector<Middle>& middles, TetMesh& mesh);

/// Puts a node into the middle of each edge of the tetrahedra, listed triangles and edges, after all others. Data there
/// are means; integers those of the first end.
class Middles {
 public:
  explicit Middles(TetMesh& mesh);
  Index of(Index a, Index b) const;

 private:
  std::vector<std::array<Index, 2>> edges_;
  Index first_ = 0;
};

}  // namespace tetune::plugin

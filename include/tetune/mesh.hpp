// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace tetune {

/// Zero-based index of a vertex or an element.
using Index = std::int32_t;

/// Most tetrahedra a mesh may hold (flips may add some on the way, so a caller should stay a tenth below).
inline constexpr Index kMaxTets = 400'000'000;

using Point3 = std::array<double, 3>;

/// Elements other than tetrahedra, triangles and edges: kept as they are, their vertices frozen.
struct ElementBlock {
  /// MEDIT section, for example "Hexahedra".
  std::string kind;
  /// Vertices of one element.
  int vertices_per_element = 0;
  /// `vertices_per_element` zero-based vertices an element.
  std::vector<Index> element2vertex;
  /// One tag an element.
  std::vector<int> tags;
  /// Positions of those that the file lists as required.
  std::vector<Index> required;
};

/// A tetrahedral mesh as a structure of arrays, owned by the caller.
///
/// A tag vector is as long as the array it belongs to. A tag of 0 means "no tag". The order of vertices is the
/// caller's and is kept by every function of the library; only optimize() with Effort::best adds and drops some.
struct TetMesh {
  /// Vertex positions.
  std::vector<Point3> points;
  std::vector<int> point_tags;

  /// Tetrahedra (v0, v1, v2, v3) with det(v1-v0, v2-v0, v3-v0) > 0.
  std::vector<std::array<Index, 4>> tets;
  /// Region (material) of each tetrahedron.
  std::vector<int> tet_tags;

  /// Listed triangles: boundary patches, interfaces and other constraints.
  std::vector<std::array<Index, 3>> triangles;
  std::vector<int> triangle_tags;

  /// Listed edges: feature lines and other constraints.
  std::vector<std::array<Index, 2>> edges;
  std::vector<int> edge_tags;

  /// Vertices that are corners of the shape.
  std::vector<Index> corners;
  /// Vertices that must not move.
  std::vector<Index> required_vertices;
  /// Positions in `edges` of ridges: sharp feature lines.
  std::vector<Index> ridges;
  /// Positions in `edges`, `triangles` and `tets` of entities that must stay as they are.
  std::vector<Index> required_edges;
  std::vector<Index> required_triangles;
  std::vector<Index> required_tets;

  /// Elements of other kinds.
  std::vector<ElementBlock> others;

  /// True when the file listed its tetrahedra with det < 0; readers turn them, writers turn them back.
  bool listed_inside_out = false;
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace tetune {

/// Zero-based index of a vertex or an element.
using Index = std::int32_t;

/// Most tetrahedra a mesh may hold (flips may add some on the way, so a caller should stay a tenth below).
inline constexpr Index kMaxTets = 400'000'000;

using Point3 = std::array<double, 3>;

/// Values of a data array in the type that they came in.
using DataValues =
    std::variant<std::vector<double>, std::vector<float>, std::vector<std::int8_t>, std::vector<std::uint8_t>,
                 std::vector<std::int16_t>, std::vector<std::uint16_t>, std::vector<std::int32_t>,
                 std::vector<std::uint32_t>, std::vector<std::int64_t>, std::vector<std::uint64_t>>;

/// A named array on vertices or elements, as files carry it: optimize() hands it on (data.hpp), writers write it back.
struct DataArray {
  std::string name;
  /// Values of one entry: 1 for a scalar, 3 for a vector.
  int components = 1;
  /// Entry after entry.
  DataValues values;
};

/// A named set of elements of one dimension: all those with one of the tags. Gmsh's physical groups.
struct Group {
  /// 0 to 3: points, edges, triangles and quadrilaterals, tetrahedra and other solids.
  int dimension = 3;
  /// What the file calls it by: unique in its dimension, positive.
  int number = 0;
  /// May be empty.
  std::string name;
  std::vector<int> tags;
};

inline constexpr const char* kPoints = "Points";

/// Elements other than tetrahedra, triangles and edges: kept as they are, their vertices frozen.
struct ElementBlock {
  /// MEDIT section, for example "Hexahedra"; kPoints for elements of one vertex. One block a kind.
  std::string kind;
  /// Vertices of one element.
  int vertices_per_element = 0;
  /// `vertices_per_element` zero-based vertices an element.
  std::vector<Index> element2vertex;
  /// One tag an element.
  std::vector<int> tags;
  /// Positions of those that the file lists as required.
  std::vector<Index> required;
  /// One entry an element.
  std::vector<DataArray> data{};
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

  /// Named data, one entry a vertex, tetrahedron, triangle, edge. Names differ within each list.
  std::vector<DataArray> point_data, tet_data, triangle_data, edge_data;

  /// Names of tags, and sets of them.
  std::vector<Group> groups;

  /// The names under which the tags came as data, for example "medit:ref", and go out again; empty: the format's own.
  std::string point_tags_name, cell_tags_name;
  /// Version and encoding of the file it came from, where its format has several ("msh 2.2 text"): writers of that
  /// format keep to it.
  std::string dialect;
  /// True when the elements of the file had nodes in the middles of their straight edges; readers leave these nodes
  /// out, writers put new ones in, after all others.
  bool second_order = false;

  /// True when the file listed its tetrahedra with det < 0; readers turn them, writers turn them back.
  bool listed_inside_out = false;
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "tetune/types.hpp"

namespace tetune {

using DataVariant =
    std::variant<std::vector<double>, std::vector<float>, std::vector<std::int8_t>, std::vector<std::uint8_t>,
                 std::vector<std::int16_t>, std::vector<std::uint16_t>, std::vector<std::int32_t>,
                 std::vector<std::uint32_t>, std::vector<std::int64_t>, std::vector<std::uint64_t>>;

/// Values of a data array, in the type of the file or of the caller. A copy that runs out of memory throws
/// std::bad_alloc; in libstdc++ 12 that of the variant itself ends the program.
struct DataValues : DataVariant {
  using DataVariant::DataVariant;
  using DataVariant::operator=;
  DataValues() = default;
  DataValues(const DataValues& other) : DataVariant(copy_of(other)) {}
  DataValues(DataValues&&) = default;
  DataValues& operator=(const DataValues& other) { return *this = DataValues(other); }
  DataValues& operator=(DataValues&&) = default;
  ~DataValues() = default;

 private:
  static DataVariant copy_of(const DataVariant& other) {
    return std::visit(
        [](const auto& values) {
          auto copy = values;
          return DataVariant(std::move(copy));
        },
        other);
  }
};

/// A named array on vertices or elements, as in files. optimize() transfers it to the result (data.hpp).
struct DataArray {
  std::string name;
  /// Number of values per entry: 1 for a scalar, 3 for a vector.
  int components = 1;
  /// Entry after entry: components * entries values.
  DataValues values;
};

/// A named set of elements of one dimension: all those with one of the tags (Gmsh: physical group).
struct Group {
  /// 0 to 3: points, edges, triangles and quadrilaterals, tetrahedra and other solids.
  int dimension = 3;
  /// Its number in the file: positive, unique in its dimension.
  int number = 0;
  /// May be empty.
  std::string name;
  std::vector<int> tags;
};

/// ElementBlock::kind of elements with one vertex.
inline constexpr const char* kPoints = "Points";

/// Elements other than tetrahedra, triangles and edges. They do not change, and their vertices and mid-side nodes do
/// not move.
struct ElementBlock {
  /// Name of the MEDIT section, for example "Hexahedra"; or kPoints. A mesh has one block per kind and order.
  std::string kind;
  /// Number of vertices per element, without mid-side nodes.
  int vertices_per_element = 0;
  /// Zero-based vertices, `vertices_per_element` per element.
  std::vector<Index> element2vertex;
  /// One tag per element.
  std::vector<int> tags;
  /// Positions of the elements that the file lists as required.
  std::vector<Index> required;
  /// One entry per element.
  std::vector<DataArray> data{};
  /// True if the elements have mid-side nodes, which are those of TetMesh::second_order; without that it has no effect.
  bool second_order = false;
};

/// Vertices on a part of the boundary that are images of vertices on another part (Gmsh: a link of $Periodic), as
/// link_box_faces() finds them. optimize() moves a vertex and its images together where they differ by a translation,
/// within planes and along straight lines, and flips their triangles together; with a rotation vertices and triangles
/// stay.
struct PeriodicLink {
  /// Of the part: 0 to 2.
  int dimension = 2;
  /// Numbers of both entities in the file.
  int entity = 0, master = 0;
  /// The map from the master, a matrix of 4 x 4 row by row; empty if unknown.
  std::vector<double> affine;
  /// Vertex, and the vertex of the master that it is the image of.
  std::vector<std::array<Index, 2>> pairs;
};

/// An edge of second-order elements whose mid-side node is not the midpoint, so that the edge is a parabola.
struct CurvedEdge {
  std::array<Index, 2> vertices{};  ///< in ascending order
  Point3 middle{};                  ///< position of the mid-side node
  friend bool operator==(const CurvedEdge&, const CurvedEdge&) = default;
};

/// The text of an Abaqus or CalculiX deck around its mesh.
class AbaqusDeck;

/// A tetrahedral mesh as a structure of arrays, owned by the caller.
///
/// A tag vector is as long as the array that it belongs to; the tag 0 means "no tag". Every function of the library
/// keeps the order of the vertices; optimize() inserts and removes some unless Options::keep_vertices is set.
struct TetMesh {
  /// Vertex positions.
  std::vector<Point3> points;
  /// A vertex that optimize() inserts has the tag that all vertices of the edge, triangle or tetrahedron of the input
  /// have on which it lies.
  std::vector<int> point_tags;

  /// Tetrahedra (v0, v1, v2, v3) with det(v1-v0, v2-v0, v3-v0) > 0.
  std::vector<std::array<Index, 4>> tets;
  /// Region (material) of each tetrahedron.
  std::vector<int> tet_tags;

  /// Listed triangles: boundary patches, interfaces between regions and other constraints.
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

  /// Elements of other kinds, one block per kind.
  std::vector<ElementBlock> others;

  /// Named data, one entry per vertex, tetrahedron, triangle, edge. Names are unique within each list.
  std::vector<DataArray> point_data, tet_data, triangle_data, edge_data;

  /// Named sets of tags.
  std::vector<Group> groups;

  /// Periodic parts of the boundary.
  std::vector<PeriodicLink> periodic;

  /// Names of the data from which the tags were read, for example "medit:ref", and to which they are written; empty:
  /// the format's own.
  std::string point_tags_name, cell_tags_name;
  /// Version and encoding of the file that was read, where its format has several ("msh 2.2 text"), or the units of a
  /// universal file: writers of that format use the same.
  std::string dialect;
  /// True if the elements of the file had mid-side nodes. Readers take these nodes out of `points`, and writers add
  /// them after all others: at the positions of `curved_edges`, on all other edges at the midpoint. Those of other
  /// kinds have them where ElementBlock::second_order is true.
  bool second_order = false;
  /// The curved edges of elements with mid-side nodes, by their vertices in ascending order, each once. Where one is
  /// listed, readers list every edge whose node is not the midpoint in all bits. Empty unless `second_order`.
  std::vector<CurvedEdge> curved_edges;

  /// The .inp file that the mesh was read from; write_mesh() writes it back, with this mesh, to files of that format.
  std::shared_ptr<const AbaqusDeck> deck;
  /// The number of each vertex in the deck, Nastran or universal file that the mesh was read from, and 0 for one that
  /// was inserted; empty for other meshes. Writers of these formats give the vertices the same numbers.
  std::vector<std::int64_t> deck_nodes;

  /// True if the file listed its tetrahedra with det < 0; readers reverse them, and writers reverse them back.
  bool listed_inside_out = false;
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "ids.hpp"
#include "tetune/mesh.hpp"

namespace tetune::mpi {

inline constexpr int kRequired = 1;
inline constexpr int kCorner = 2;        ///< of a vertex
inline constexpr int kRidge = 2;         ///< of an edge
inline constexpr int kPending = 4;       ///< of a vertex: frozen in all rounds so far, because several parts shared it
inline constexpr int kHeld = 8;          ///< of a vertex: of an element of another kind
inline constexpr int kFirstCut = 16;     ///< of a vertex: on an interface of parts in the first round
inline constexpr int kShared = 32;       ///< of a vertex: in several parts, or possibly so since tetrahedra moved
inline constexpr int kNearPending = 64;  ///< of a vertex: near a pending vertex
inline constexpr int kOfPart = kPending | kHeld | kFirstCut | kShared | kNearPending;

/// Entities as they are sent between ranks.
struct Vertex {
  Id id;
  Point3 x;
  int tag;
  int flags;
};
template <std::size_t N>
struct Element {
  Id id;  ///< position in the input's list of its kind; of a tetrahedron, that of its origin
  std::array<Id, N> v;
  int tag;
  int flags;
};
using Cell = Element<4>;
using Side = Element<3>;
using Line = Element<2>;

struct Pieces {
  std::vector<Vertex> vertices;
  std::vector<Cell> cells;
  std::vector<Side> sides;
  std::vector<Line> lines;
};

/// The part of the mesh on a rank. A vertex, listed triangle or listed edge on an interface is in each of its parts.
struct Part {
  TetMesh mesh;
  std::vector<Id> vertex_id;  ///< increasing, except for inserted vertices
  Marks vertex_flags;         ///< the flags of kOfPart
  std::vector<Id> tet_id, triangle_id, edge_id;
};

/// Adds listed triangles and edges to a part that has none.
void add_lists(Part& part, const IdMap& local, std::vector<Side> sides, std::vector<Line> lines);

/// Makes a part of entities; of copies from several ranks one is kept.
Part assemble(Pieces pieces);

/// A copy of the marked tetrahedra, with the vertices and listed entities that they have.
Part copied(const Part& part, const Marks& marked);

/// Moves the marked tetrahedra out of a part. Entities that they share with the rest are in both.
Part extract(Part& part, const Marks& marked);

/// Adds another part; entities that both have are kept once.
void merge(Part& part, const Part& other);

/// Flags: 1 for each vertex on the surface of the mesh or between two regions.
Marks on_surface(const TetMesh& mesh);

/// Flags: 1 for the vertices of on_surface(), of lists and of frozen regions: all that may be constrained.
Marks held_vertices(const TetMesh& mesh, const std::vector<int>& frozen_regions);

/// The entities of a part and the rank that each is sent to when tetrahedron t goes to rank `tet_to[t]`: vertices,
/// listed triangles and edges go with each of their tetrahedra, and to `self` if they have none.
struct Addressed {
  Pieces pieces;
  std::vector<int> vertex_to, cell_to, side_to, line_to;
};
Addressed address(const Part& part, const std::vector<int>& tet_to, int self);

/// Flags: 1 for each triangle, or edge, that one of the tetrahedra has. `vertices`: the number of vertices.
Marks are_in(const std::vector<std::array<Index, 3>>& triangles, const std::vector<std::array<Index, 4>>& tets,
             std::size_t vertices);
Marks are_in(const std::vector<std::array<Index, 2>>& edges, const std::vector<std::array<Index, 4>>& tets,
             std::size_t vertices);

}  // namespace tetune::mpi

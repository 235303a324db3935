// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune::mpi {

/// Number of a vertex or an element in the whole mesh.
using Id = std::int64_t;

inline constexpr int kRequired = 1;
inline constexpr int kCorner = 2;     ///< of a vertex
inline constexpr int kRidge = 2;      ///< of an edge
inline constexpr int kPending = 4;    ///< of a vertex: frozen in all rounds so far, as several parts shared it
inline constexpr int kHeld = 8;       ///< of a vertex: of an element of another kind
inline constexpr int kFirstCut = 16;  ///< of a vertex: on a cut in the first round
inline constexpr int kShared = 32;    ///< of a vertex: several parts have it, or may since tetrahedra moved
inline constexpr int kNear = 64;      ///< of a vertex: near what is pending
inline constexpr int kOfPart = kPending | kHeld | kFirstCut | kShared | kNear;

/// Entities as they travel between ranks.
struct Vertex {
  Id id;
  Point3 x;
  int tag;
  int flags;
};
template <std::size_t N>
struct Element {
  Id id;  ///< in the input's list of its kind: identifies it; of a tetrahedron, the one it descends from
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

/// What a rank has of the mesh. A vertex, listed triangle or listed edge that is between parts is in each of them.
struct Part {
  TetMesh mesh;
  std::vector<Id> vertex_id;               ///< increasing, but for vertices that were inserted
  std::vector<std::uint8_t> vertex_flags;  ///< those of kOfPart
  std::vector<Id> tet_id, triangle_id, edge_id;
};

/// From global to local numbers.
class IdMap {
 public:
  IdMap() : slots_(16) {}
  explicit IdMap(const std::vector<Id>& ids);
  /// -1 where it is not there.
  Index operator[](Id id) const { return slots_[place(id)].index; }
  /// Gives the next number to an id that has none yet; whether it had none.
  bool add(Id id);

 private:
  struct Slot {
    Id id = -1;
    Index index = -1;
  };
  /// Where it is, or would be.
  std::size_t place(Id id) const {
    const std::size_t mask = slots_.size() - 1;
    auto at = static_cast<std::size_t>((static_cast<std::uint64_t>(id) * 0x9E3779B97F4A7C15U) >> 20U) & mask;
    while (slots_[at].index >= 0 && slots_[at].id != id) at = (at + 1) & mask;
    return at;
  }
  std::vector<Slot> slots_;  ///< a power of two
  std::size_t count_ = 0;
};

/// Adds listed triangles and edges to a part that has none.
void add_lists(Part& part, const IdMap& local, std::vector<Side> sides, std::vector<Line> lines);

/// Puts pieces together; those that several sent become one.
Part assemble(Pieces pieces);

/// The tetrahedra with a mark, and what they have.
Part copied(const Part& part, const std::vector<std::uint8_t>& marked);

/// Takes the tetrahedra with a mark out of a part. What they share with the rest is in both.
Part extract(Part& part, const std::vector<std::uint8_t>& marked);

/// Adds another part; what both have becomes one.
void absorb(Part& part, const Part& other);

/// 1 for each vertex on the surface of the mesh or between two regions.
std::vector<std::uint8_t> on_surface(const TetMesh& mesh);

/// 1 for these, and for the vertices of all else that may hold vertices: lists, and regions that are frozen.
std::vector<std::uint8_t> held_vertices(const TetMesh& mesh, const std::vector<int>& frozen_regions);

/// 1 for each tetrahedron with a marked vertex.
std::vector<std::uint8_t> tets_around(const TetMesh& mesh, const std::vector<std::uint8_t>& vertices);

/// The pieces of a part, and where each goes when tetrahedron t goes to `tet_to[t]`: vertices, listed triangles and
/// edges go along with each of theirs, and to `self` if they are in none.
struct Addressed {
  Pieces pieces;
  std::vector<int> vertex_to, cell_to, side_to, line_to;
};
Addressed address(const Part& part, const std::vector<int>& tet_to, int self);

/// Whether each triangle, or edge, is one of some tetrahedra.
std::vector<std::uint8_t> are_in(const std::vector<std::array<Index, 3>>& triangles,
                                 const std::vector<std::array<Index, 4>>& tets, std::size_t vertices);
std::vector<std::uint8_t> are_in(const std::vector<std::array<Index, 2>>& edges,
                                 const std::vector<std::array<Index, 4>>& tets, std::size_t vertices);

}  // namespace tetune::mpi

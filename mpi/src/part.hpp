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
inline constexpr int kOfPart = kPending | kHeld | kFirstCut;

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
  explicit IdMap(const std::vector<Id>& ids);
  /// -1 where it is not there.
  Index operator[](Id id) const {
    for (std::size_t at = hash(id);; at = (at + 1) & mask_) {
      if (slots_[at].id == id) return slots_[at].index;
      if (slots_[at].index < 0) return -1;
    }
  }

 private:
  struct Slot {
    Id id = -1;
    Index index = -1;
  };
  std::size_t hash(Id id) const {
    return static_cast<std::size_t>((static_cast<std::uint64_t>(id) * 0x9E3779B97F4A7C15U) >> 20U) & mask_;
  }
  std::vector<Slot> slots_;
  std::size_t mask_;
};

/// Adds listed triangles and edges to a part that has none.
void add_lists(Part& part, const IdMap& local, std::vector<Side> sides, std::vector<Line> lines);

/// Puts pieces together; those that several sent become one.
Part assemble(Pieces pieces);

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

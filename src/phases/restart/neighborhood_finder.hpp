// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "phases/restart/host_work.hpp"

namespace tetune {

/// Tetrahedra within some rings of vertices around one of them.
struct FoundTets {
  /// In place of the ring of a vertex that is in none.
  static constexpr std::uint8_t kNoRing = 255;

  struct Vertex {
    Index vertex;
    /// kNoRing also where some of the tetrahedra at the vertex were not found: where parts of the mesh touch at a
    /// vertex alone, faces do not connect all of them.
    std::uint8_t ring;
  };

  std::vector<Index> slots;
  std::vector<Vertex> vertices;
};

/// Finds neighborhoods in breadth-first order.
class NeighborhoodFinder {
 public:
  explicit NeighborhoodFinder(const HostWork& whole);
  /// Adds `sign` to the number of tetrahedra at each vertex of the listed slots: to be called with -1 before these
  /// change, and with 1 afterwards.
  void count_tets(const std::vector<Index>& slots, int sign);

  /// Finds the tetrahedra that have a vertex in one of `rings` rings around the one in a slot.
  void find(Index slot, int rings);
  const std::vector<Index>& tets() const { return tets_; }
  /// Whether one of the tetrahedra that find() has found, or of the neighbors across their faces, is flagged.
  bool touches(const std::vector<std::uint8_t>& flags) const;
  /// Whether a vertex of the tetrahedra that find() has found is flagged.
  bool has_vertex_of(const std::vector<std::uint8_t>& flags) const;
  /// Flags these vertices.
  void flag_vertices(std::vector<std::uint8_t>& flags) const;
  /// The tetrahedra that find() has found, and their vertices; the ring of those of the first tetrahedron is 0.
  FoundTets found() const;

 private:
  /// Makes room for slots and vertices that were added.
  void grow();
  void count_tet(Index slot, int sign);
  void clear();
  void add(Index slot);
  bool reaches(Index slot, int ring) const;

  const HostWork& whole_;
  std::vector<Index> tets_, vertices_;
  std::vector<std::uint8_t> is_found_;  ///< per slot
  std::vector<std::uint8_t> ring_;      ///< per vertex
  std::vector<Index> tets_at_, found_;  ///< the numbers of tetrahedra at each vertex: all, and those that were found
};

}  // namespace tetune

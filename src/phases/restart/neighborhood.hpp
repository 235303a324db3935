// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "backend/cpu.hpp"
#include "mesh/csr.hpp"
#include "phases/restart/host_work.hpp"
#include "phases/restart/neighborhood_finder.hpp"

namespace tetune {

/// The corners 3 * triangle + k of the boundary triangles at each vertex of a mesh.
using CornersByVertex = Csr<backend::Cpu>;
CornersByVertex list_corners(const backend::Cpu& backend, const HostWork& whole);

/// Some tetrahedra of a mesh as a working set of their own, to be changed on the host. Vertices that other tetrahedra
/// have as well are fixed, and the faces between these and the neighborhood are locked. Periodic vertices do not move.
///
/// As in the whole, a vertex has one number in the mesh and in the reference surface: the vertices are those of the
/// tetrahedra and of the reference surface near them, in increasing order. Where the reference surface is cut, vertices
/// cannot slide on.
class Neighborhood {
  backend::Cpu backend_{1};

 public:
  Neighborhood(const HostWork& whole, FoundTets found, const CornersByVertex& corners);

  WorkingSet<backend::Cpu> work;

  /// A flag per vertex: 1 within some rings.
  std::vector<std::uint8_t> flags(int rings) const;
  /// The slots that the tetrahedra have in the whole mesh.
  const std::vector<Index>& slots() const { return slot2whole_; }
  /// Whether the surface has a new edge or triangle that the mesh has elsewhere, where operators do not find it.
  /// Requires that put_back() was not called, and `corners` of the mesh as it was taken.
  bool doubles_surface(const HostWork& whole, const CornersByVertex& corners) const;
  /// Writes tetrahedra, vertices and triangles back to the mesh that they were taken from. Requires that the
  /// tetrahedra around them have not changed. New tetrahedra are at the end of slots() afterwards, where -1 stands for
  /// a free slot. Triangles that no longer exist have kRemoved as first vertex.
  void put_back(HostWork& whole);

 private:
  struct CutFace {
    std::array<Index, 3> v;  ///< in increasing order
    HalfFace across;
  };

  void find_vertices(const HostWork& whole, const CornersByVertex& corners);
  /// The triangles of the boundary all of whose vertices are in the neighborhood, in increasing order.
  std::vector<Index> triangles_inside(const HostWork& whole, const CornersByVertex& corners) const;
  void take_tets(const HostWork& whole);
  void take_vertices(const HostWork& whole, const std::vector<FoundTets::Vertex>& found);
  void take_triangles(const HostWork& whole, const CornersByVertex& corners);
  void take_edges(const HostWork& whole);
  void take_reference(const HostWork& whole);
  void put_vertices(HostWork& whole);
  void put_slots(HostWork& whole);
  void put_tets(HostWork& whole);
  void put_triangles(HostWork& whole) const;

  bool moves(Size v) const { return v >= std::ssize(ring_) || span_of(ring_)[v] != FoundTets::kNoRing; }
  Index vertex_of(Index of_whole) const;
  /// Kind none where it was not taken.
  SurfacePoint to_part(const SurfacePoint& on) const;
  SurfacePoint to_whole(const SurfacePoint& on) const;
  /// An entry of a vertex array of the whole as that of vertex v of the neighborhood, and back.
  template <class T>
  T vertex_to_part(const T& entry, Size v) const {
    if constexpr (std::is_same_v<T, SurfacePoint>) return to_part(entry);
    if constexpr (std::is_same_v<T, VertexDof>) return moves(v) ? entry : VertexDof::fixed;
    return entry;
  }
  template <class T>
  T vertex_to_whole(const T& entry) const {
    if constexpr (std::is_same_v<T, SurfacePoint>) return to_whole(entry);
    return entry;
  }

  std::vector<Index> vertex2whole_, slot2whole_;
  std::vector<std::uint8_t> ring_;      ///< per vertex, as taken; kNoRing where it is fixed
  std::vector<Index> triangle2whole_;   ///< the triangles of the boundary, as taken
  std::vector<Index> reference2whole_;  ///< the triangles of the reference surface
  std::vector<CutFace> cut_;            ///< in increasing order
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mesh/work_mesh.hpp"

/// The tetrahedra around an edge.
namespace tetune {

/// The maximum number of tetrahedra around an edge that a flip removes or makes.
inline constexpr int kMaxRing = 7;

/// Four local vertices in eight bits.
TETUNE_HD constexpr int pack_corners(int i, int j, int k, int l) { return i | j << 2 | k << 4 | l << 6; }

/// The two ends of local edge 0..5 and, opposite it, the two other vertices in the order that makes (i, k, l, j) even.
struct EdgeCorners {
  int i, j, k, l;  ///< the ends i, j; the others k, l
};
TETUNE_HD TETUNE_INLINE EdgeCorners edge_corners(int edge) {
  constexpr PackedTable<8> kCorners({pack_corners(0, 1, 2, 3), pack_corners(0, 2, 3, 1), pack_corners(0, 3, 1, 2),
                                     pack_corners(1, 2, 0, 3), pack_corners(1, 3, 2, 0), pack_corners(2, 3, 0, 1)});
  const int corners = kCorners[edge];
  return {corners & 3, corners >> 2 & 3, corners >> 4 & 3, corners >> 6};
}
/// The two faces at an edge, those opposite k and l, as bits.
TETUNE_HD TETUNE_INLINE unsigned edge_faces(int edge) {
  constexpr PackedTable<4> kFaces({0b1100, 0b1010, 0b0110, 0b1001, 0b0101, 0b0011});
  return static_cast<unsigned>(kFaces[edge]);
}

/// The local edge between two local vertices, in any order.
TETUNE_HD TETUNE_INLINE int edge_of(int i, int j) { return i == 0 || j == 0 ? i + j - 1 : i + j; }

/// A walk around an edge, from tetrahedron to tetrahedron.
struct EdgeWalk {
  Index next_vertex;  ///< the vertex of the face just crossed that is not on the edge
  HalfFace entry;     ///< the tetrahedron entered, and the face of it that was crossed

  TETUNE_HD TETUNE_INLINE Index tet() const { return tet_of(entry); }
  /// Crosses the next face. Returns false, without a step, where it is locked.
  TETUNE_HD TETUNE_INLINE bool step(Span<const Tet> tet2vertex, Span<const FaceAdjacency> tet2tet) {
    const Tet here = tet2vertex[tet()];
    const HalfFace across = tet2tet[tet()][local_index(here, next_vertex)];
    if (is_locked(across)) return false;
    next_vertex = here[face_of(entry)];
    entry = across;
    return true;
  }
  TETUNE_HD TETUNE_INLINE bool step(const MeshView& mesh) { return step(mesh.tet2vertex, mesh.tet2tet); }
};

/// The tetrahedra around an edge (a, b), in the order of the walk.
struct EdgeStar {
  int size = 0;  ///< 0: not a star
  Index a, b;
  Index ring[kMaxRing];  ///< tets[m] holds ring[m] and the next
  Index tets[kMaxRing];
};

/// The star of local edge `edge` of t, whose two faces at it must not be locked. Empty where more than `max_ring`
/// tetrahedra lie around the edge, another face between them is locked, or `stop` holds for a tetrahedron that does not
/// share a face with t.
template <class Stop>
TETUNE_HD TETUNE_INLINE EdgeStar edge_star(const MeshView& mesh, int max_ring, Index t, int edge, const Stop& stop) {
  EdgeStar s;
  EdgeCorners e = edge_corners(edge);
  const FaceAdjacency across = mesh.tet2tet[t];
  const Tet tet = mesh.tet2vertex[t];
  if (tet[e.j] < tet[e.i]) e = {e.j, e.i, e.l, e.k};
  // Walks around the edge, from (a, k, l, b) across the face opposite k, until the tetrahedron opposite l.
  s.ring[0] = tet[e.k];
  s.tets[0] = t;
  const Index last = tet_of(across[e.l]);
  int n = 1;
  for (EdgeWalk walk{tet[e.l], across[e.k]};;) {
    if (n == max_ring) return s;
    s.ring[n] = walk.next_vertex;
    s.tets[n] = walk.tet();
    ++n;
    if (walk.tet() == last) break;
    if (!walk.step(mesh) || stop(walk.tet())) return s;
  }
  if (n < 3) return s;
  s.a = tet[e.i];
  s.b = tet[e.j];
  s.size = n;
  return s;
}

}  // namespace tetune

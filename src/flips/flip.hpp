// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/constrained_edges.hpp"
#include "core/work_mesh.hpp"

/// The connectivity of the flips (Fig. 1 and beyond). An edge (a, b) and the vertices r_0, r_1, ... around it, with
/// (a, r_m, r_m+1, b) positive:
///   edge removal:  (a,r_m,r_m+1,b) for all m, for an edge in the boundary for all but the last  ->  (a,r_i,r_j,r_k),
///                  (b,r_i,r_k,r_j) for each triangle i < j < k of a triangulation of the ring. With three tetrahedra
///                  it is the 3-2 flip.
///   face removal:  the inverse. With one face it is the 2-3 flip, with two the 4-4 flip.
namespace tetune {

/// Most tetrahedra around an edge that is removed or made.
inline constexpr int kMaxRing = 7;
/// Most faces that are removed at once.
inline constexpr int kMaxFaces = kMaxRing - 2;
/// Slots that the removal of an edge takes beyond those of its cavity, at most: of one in the boundary.
inline constexpr int kMaxExtra = kMaxRing - 3;

enum class FlipKind : std::uint8_t { none, face_removal, edge_removal, boundary_removal };

/// Where the vertices and the tetrahedra of a flip are. In an order that depends on the vertices alone, so that a flip
/// is worth the same, to the last bit, whoever finds it: a < b, and r_0 is the lowest of the ring.
struct Cavity {
  FlipKind kind = FlipKind::none;
  std::uint8_t ring_size = 3;
  Index a, b;
  Index ring[kMaxRing];
  /// Edge removal: m holds r_m and r_m+1; face removal: 2 s and 2 s + 1 are those on triangle s.
  Index tets[2 * kMaxFaces];

  /// Tetrahedra before.
  TETUNE_HD int size() const { return kind == FlipKind::face_removal ? 2 * (ring_size - 2) : sides(); }
  /// Sides of the ring that have outer faces: in the boundary the last one has none.
  TETUNE_HD int sides() const { return kind == FlipKind::boundary_removal ? ring_size - 1 : ring_size; }
  /// Tetrahedra after.
  TETUNE_HD int made() const { return kind == FlipKind::face_removal ? ring_size : 2 * (ring_size - 2); }
  /// Next place in the ring.
  TETUNE_HD int after(int m) const { return m + 1 < ring_size ? m + 1 : 0; }
};

/// A triangulation of a ring: n - 2 triangles, each three places in the ring in increasing order.
struct Triangulation {
  std::uint8_t corner[kMaxRing - 2][3];
};

/// The face flip across face `face` of tetrahedron t, which must not be locked.
TETUNE_HD inline Cavity face_cavity(const MeshView& mesh, Index t, int face) {
  Cavity c;
  const Link link = mesh.tet2tet[t][face];
  const Index other = link_tet(link);
  const Tet tet = mesh.tet2vertex[t];
  c.kind = FlipKind::face_removal;
  c.a = tet[face];
  c.b = mesh.tet2vertex[other][link_face(link)];
  const bool turned = c.b < c.a;
  if (turned) {
    c.a = c.b;
    c.b = tet[face];
  }
  c.tets[turned ? 1 : 0] = t;
  c.tets[turned ? 0 : 1] = other;
  // Seen from the other side, the face turns the other way round.
  const Index face_ring[3] = {tet[face_vertex(face, 0)], tet[face_vertex(face, turned ? 2 : 1)],
                              tet[face_vertex(face, turned ? 1 : 2)]};
  int lowest = face_ring[1] < face_ring[0] ? 1 : 0;
  if (face_ring[2] < face_ring[lowest]) lowest = 2;
  for (int m = 0; m < 3; ++m) c.ring[m] = face_ring[lowest + m < 3 ? lowest + m : lowest + m - 3];
  return c;
}

/// The two ends of local edge 0..5 and, opposite it, the two other vertices in the order that makes (i, k, l, j) even.
struct EdgeCorners {
  int i, j, k, l;  ///< the ends i, j; the others k, l
};
TETUNE_HD TETUNE_INLINE EdgeCorners edge_corners(int edge) {
  // One byte an edge: 01 23, 02 31, 03 12, 12 03, 13 20, 23 01.
  const auto corners = static_cast<int>(0x4e2dc99c78e4ULL >> (8 * edge) & 0xff);
  return {corners & 3, corners >> 2 & 3, corners >> 4 & 3, corners >> 6};
}
/// The two faces at an edge, those opposite k and l, as bits.
TETUNE_HD TETUNE_INLINE unsigned edge_faces(int edge) { return 0x3596acU >> (4 * edge) & 0xf; }

/// The local edge between two local vertices.
TETUNE_HD TETUNE_INLINE int edge_of(int i, int j) { return i == 0 || j == 0 ? i + j - 1 : i + j; }

/// local_index() without a branch, which nothing could predict on the way around an edge.
TETUNE_HD TETUNE_INLINE int place_of(const Tet& tet, Index vertex) {
  return static_cast<int>(tet[1] == vertex) + 2 * static_cast<int>(tet[2] == vertex) +
         3 * static_cast<int>(tet[3] == vertex);
}

/// The tetrahedra around an edge (a, b), in the order in which they were met.
struct EdgeStar {
  int size = 0;  ///< 0: not a star
  Index a, b;
  Index ring[kMaxRing];  ///< tets[m] holds ring[m] and the next
  Index tets[kMaxRing];
};

/// The star of local edge `edge` of t, whose two faces at it must not be locked. None where more than `max_ring`
/// tetrahedra lie around the edge, another face between them is locked, or `stop` holds for a tetrahedron that does not
/// share a face with t.
template <class Stop>
TETUNE_HD TETUNE_INLINE EdgeStar edge_star(const MeshView& mesh, int max_ring, Index t, int edge, const Stop& stop) {
  EdgeStar s;
  EdgeCorners e = edge_corners(edge);
  const Links links = mesh.tet2tet[t];
  const Tet tet = mesh.tet2vertex[t];
  if (tet[e.j] < tet[e.i]) e = {e.j, e.i, e.l, e.k};
  // Turn around the edge, from (a, k, l, b) across the face opposite k, until the tetrahedron opposite l.
  s.ring[0] = tet[e.k];
  s.tets[0] = t;
  const Index last = link_tet(links[e.l]);
  Index behind = tet[e.l];  // the ring vertex of the face just crossed
  Link link = links[e.k];
  int n = 1;
  for (Index next = link_tet(link);; next = link_tet(link)) {
    if (n == max_ring) return s;
    s.ring[n] = behind;
    s.tets[n] = next;
    ++n;
    if (next == last) break;
    const Tet there = mesh.tet2vertex[next];
    const int entry = link_face(link);
    link = mesh.tet2tet[next][place_of(there, behind)];
    if (is_locked(link) || stop(link_tet(link))) return s;
    behind = there[entry];
  }
  if (n < 3) return s;
  s.a = tet[e.i];
  s.b = tet[e.j];
  s.size = n;
  return s;
}

/// The removal of the edge of a star; kind none where there is no star or the edge is constrained.
TETUNE_HD inline Cavity edge_cavity(const EdgeStar& star, const ConstrainedEdges& constrained) {
  Cavity c;
  if (star.size == 0 || constrained.contains(star.a, star.b)) return c;
  c.kind = FlipKind::edge_removal;
  c.a = star.a;
  c.b = star.b;
  c.ring_size = static_cast<std::uint8_t>(star.size);
  int lowest = 0;
  for (int m = 1; m < star.size; ++m) lowest = star.ring[m] < star.ring[lowest] ? m : lowest;
  for (int m = 0; m < star.size; ++m) {
    const int from = lowest + m < star.size ? lowest + m : lowest + m - star.size;
    c.ring[m] = star.ring[from];
    c.tets[m] = star.tets[from];
  }
  return c;
}

/// Which of the new tetrahedra this is: those on triangle s are 2 s and 2 s + 1, that at ring edge
/// (r_m, r_m+1) of a face removal is m.
TETUNE_HD inline Tet new_tet(const Cavity& c, const Triangulation& triangulation, int x) {
  if (c.kind == FlipKind::face_removal) return {{c.a, c.ring[x], c.ring[c.after(x)], c.b}};
  const std::uint8_t* corner = triangulation.corner[x / 2];
  const Index i = c.ring[corner[0]];
  const Index j = c.ring[corner[1]];
  const Index k = c.ring[corner[2]];
  return x % 2 == 0 ? Tet{{c.a, i, j, k}} : Tet{{c.b, i, k, j}};
}

/// Of the tetrahedra on a triangle, the face at the side opposite one of its corners.
TETUNE_HD inline int face_at(int corner, int side) { return side == 0 || corner == 0 ? corner + 1 : 4 - corner; }

/// A side of a triangle of the triangulation: opposite which corner of which triangle.
struct TriangleSide {
  int triangle, corner;
};

/// The side (from, to), from < to, of a triangle other than `not_this`.
TETUNE_HD inline TriangleSide find_side(const Cavity& c, const Triangulation& triangulation, int from, int to,
                                        int not_this) {
  for (int s = 0; s < c.ring_size - 2; ++s) {
    const std::uint8_t* corner = triangulation.corner[s];
    if (s == not_this) continue;
    if (corner[0] == from && corner[1] == to) return {s, 2};
    if (corner[0] == from && corner[2] == to) return {s, 1};
    if (corner[1] == from && corner[2] == to) return {s, 0};
  }
  return {-1, -1};
}
/// Ring edge (r_m, r_m+1).
TETUNE_HD inline TriangleSide find_ring_edge(const Cavity& c, const Triangulation& triangulation, int m) {
  const bool closing = m + 1 == c.ring_size;
  return find_side(c, triangulation, closing ? 0 : m, closing ? m : m + 1, -1);
}

/// The outer faces before: 2 m and 2 m + 1 are those at ring edge (r_m, r_m+1), on the side of a and of b.
TETUNE_HD inline Link old_face(const MeshView& mesh, const Cavity& c, const Triangulation& triangulation, int k) {
  const int m = k / 2;
  const int side = k % 2;
  Index t = c.tets[m];
  Index opposite = side == 0 ? c.b : c.a;
  if (c.kind == FlipKind::face_removal) {
    const TriangleSide in = find_ring_edge(c, triangulation, m);
    t = c.tets[2 * in.triangle + side];
    opposite = c.ring[triangulation.corner[in.triangle][in.corner]];
  }
  return make_link(t, local_index(mesh.tet2vertex[t], opposite));
}

}  // namespace tetune

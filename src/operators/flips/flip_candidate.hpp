// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mesh/constrained_edges.hpp"
#include "mesh/edge_star.hpp"
#include "operators/engine/bid.hpp"
#include "operators/engine/candidate.hpp"

/// The candidate of all flips (Fig. 1 and beyond): an edge (a, b) and the vertices r_0, r_1, ... around it, with
/// (a, r_m, r_m+1, b) positive.
///   edge removal:  (a,r_m,r_m+1,b) for all m, for an edge in the boundary for all but the last  ->  (a,r_i,r_j,r_k),
///                  (b,r_i,r_k,r_j) for each triangle i < j < k of a triangulation of the ring. With three tetrahedra
///                  it is the 3-2 flip.
///   face removal:  the inverse. With one face it is the 2-3 flip, with two the 4-4 flip.
namespace tetune {

/// The maximum number of faces that are removed at once.
inline constexpr int kMaxRemovedFaces = kMaxRing - 2;

enum class FlipKind : std::uint8_t { none, face_removal, edge_removal, boundary_removal };

/// A triangulation of a ring: n - 2 triangles, each three places in the ring in increasing order.
struct Triangulation {
  /// A side of a triangle: opposite which corner of which triangle.
  struct Side {
    int triangle, corner;
  };
  std::uint8_t corner[kMaxRing - 2][3];

  /// The side (from, to), from < to, of one of the first `count` triangles other than `except`.
  TETUNE_HD Side find_side(int count, int from, int to, int except) const {
    for (int s = 0; s < count; ++s) {
      if (s == except) continue;
      if (corner[s][0] == from && corner[s][1] == to) return {s, 2};
      if (corner[s][0] == from && corner[s][2] == to) return {s, 1};
      if (corner[s][1] == from && corner[s][2] == to) return {s, 0};
    }
    return {-1, -1};
  }
};

/// A flip. In those that one tetrahedron can evaluate as well as another (face_cavity(), edge_cavity()) the order of
/// vertices and tetrahedra depends on the vertices alone, a < b and r_0 the lowest of the ring, so that the gain is the
/// same to the last bit. A cluster of faces may bid from several of them, with gains that differ by rounding.
struct FlipCandidate {
  static constexpr int kMaxExtraTets = kMaxRing - 3;
  static constexpr int kMaxCavityFaces = 2 * kMaxRing;
  using Patch = FlipCandidate;

  FlipKind kind = FlipKind::none;
  std::uint8_t ring_size = 3;
  std::uint8_t edges = 0;                       ///< the number of edges that it bids on
  Triangulation triangulation = {{{0, 1, 2}}};  ///< that of a ring of three, until another is found
  Index a, b;
  Index ring[kMaxRing];
  /// Edge removal: m holds r_m and r_m+1; face removal: 2 s and 2 s + 1 are those on triangle s. Then the slot that
  /// stands for an edge.
  Index tets[2 * kMaxRemovedFaces];
  /// Of a patch: which face of its tetrahedron each boundary face is.
  std::uint32_t local_faces = 0;
  static constexpr unsigned kLocalFaceBits = 2;
  static_assert(kMaxCavityFaces * kLocalFaceBits <= 32);

  TETUNE_HD FlipCandidate expand(const MeshView& mesh) const {
    FlipCandidate patch = *this;
    for (int k = 0; k < face_count(); ++k) {
      const TetAtFace at = tet_at_face(k);
      const auto local = unsigned(local_index(mesh.tet2vertex[at.tet], at.opposite));
      patch.local_faces |= local << kLocalFaceBits * unsigned(k);
    }
    return patch;
  }

  TETUNE_HD int triangles() const { return ring_size - 2; }
  /// The sides of the ring that have outer faces: in the boundary the last one has none.
  TETUNE_HD int sides() const { return kind == FlipKind::boundary_removal ? ring_size - 1 : ring_size; }
  /// The next place in the ring.
  TETUNE_HD int after(int m) const { return m + 1 < ring_size ? m + 1 : 0; }

  TETUNE_HD int old_count() const { return kind == FlipKind::face_removal ? 2 * triangles() : sides(); }
  TETUNE_HD int edge_count() const { return edges; }
  /// Makes an edge removal in the boundary bid on the edge that it makes.
  TETUNE_HD void bid_on_edge(Size edge_slots) {
    tets[old_count()] = slot_of_edge(ring[0], ring[ring_size - 1], edge_slots);
    edges = 1;
  }
  TETUNE_HD int new_count() const { return kind == FlipKind::face_removal ? ring_size : 2 * triangles(); }
  TETUNE_HD int vertex_count() const { return 2 + ring_size; }
  TETUNE_HD Index vertex(int i) const { return i == 0 ? a : i == 1 ? b : ring[i - 2]; }

  /// Faces 2 m and 2 m + 1 are those at ring edge (r_m, r_m+1), on the side of a and of b.
  TETUNE_HD int face_count() const { return 2 * sides(); }
  TETUNE_HD int new_surface_faces() const { return kind == FlipKind::boundary_removal ? 2 : 0; }
  TETUNE_HD HalfFace old_face(int k) const {
    return make_half_face(tet_at_face(k).tet, int(local_faces >> kLocalFaceBits * unsigned(k) & 3U));
  }
  TETUNE_HD NewFace new_face(int k) const {
    const int m = k / 2;
    const int side = k % 2;
    if (kind == FlipKind::face_removal) return {m, side == 0 ? 3 : 0};
    const Triangulation::Side in = ring_edge(m);
    return {2 * in.triangle + side, face_at(in.corner, side)};
  }

  /// New tetrahedra 2 s and 2 s + 1 are those on triangle s; for a face removal m is the one at ring edge (r_m, r_m+1).
  TETUNE_HD Tet new_tet(int x) const {
    if (kind == FlipKind::face_removal) return {{a, ring[x], ring[after(x)], b}};
    const std::uint8_t* corner = triangulation.corner[x / 2];
    const Index i = ring[corner[0]];
    const Index j = ring[corner[1]];
    const Index k = ring[corner[2]];
    return x % 2 == 0 ? Tet{{a, i, j, k}} : Tet{{b, i, k, j}};
  }
  TETUNE_HD NewNeighbor new_neighbor(int x, int face) const {
    return kind == FlipKind::face_removal ? neighbor_at_edge(x, face) : neighbor_on_triangle(x / 2, x % 2, face);
  }

  /// Whether another part is the fan on the other side of the same edge, and not that of its periodic image.
  TETUNE_HD bool meets(const FlipCandidate& other) const { return a == other.a && b == other.b; }

  TETUNE_HD void count(FlipCounts& counts) const {
    const bool is_large = ring_size > 3;
    ++(kind == FlipKind::boundary_removal ? counts.boundary_flips
       : kind == FlipKind::face_removal   ? (is_large ? counts.face_removals : counts.flips23)
                                          : (is_large ? counts.edge_removals : counts.flips32));
  }
  TETUNE_HD void count(ChangeCounts& counts) const { counts.add_tets(old_count(), new_count()); }

 private:
  /// The old tetrahedron at a boundary face, and its vertex opposite the face.
  struct TetAtFace {
    Index tet, opposite;
  };
  TETUNE_HD TetAtFace tet_at_face(int k) const {
    const int m = k / 2;
    const int side = k % 2;
    if (kind != FlipKind::face_removal) return {tets[m], side == 0 ? b : a};
    const Triangulation::Side in = ring_edge(m);
    return {tets[2 * in.triangle + side], ring[triangulation.corner[in.triangle][in.corner]]};
  }
  TETUNE_HD Triangulation::Side ring_edge(int m) const {
    const bool closes = m + 1 == ring_size;
    return triangulation.find_side(triangles(), closes ? 0 : m, closes ? m : m + 1, -1);
  }
  /// The face opposite a corner of the triangle, for the tetrahedron on the side of a (0) or b (1); and its inverse.
  TETUNE_HD static int face_at(int corner, int side) { return side == 0 || corner == 0 ? corner + 1 : 4 - corner; }
  TETUNE_HD static int corner_at(int face, int side) { return side == 0 || face == 1 ? face - 1 : 4 - face; }

  TETUNE_HD NewNeighbor neighbor_at_edge(int m, int face) const {
    if (face == 0) return {-1, 2 * m + 1};
    if (face == 3) return {-1, 2 * m};
    return face == 1 ? NewNeighbor{after(m), 2} : NewNeighbor{m > 0 ? m - 1 : ring_size - 1, 1};
  }
  TETUNE_HD NewNeighbor neighbor_on_triangle(int s, int side, int face) const {
    if (face == 0) return {2 * s + 1 - side, 0};
    const std::uint8_t* corner = triangulation.corner[s];
    const int opposite = corner_at(face, side);
    const int from = corner[opposite == 0 ? 1 : 0];
    const int to = corner[opposite == 2 ? 1 : 2];
    if (to == from + 1) return {-1, 2 * from + side};
    if (to == from + ring_size - 1) return {-1, 2 * to + side};
    const Triangulation::Side in = triangulation.find_side(triangles(), from, to, s);
    return {2 * in.triangle + side, face_at(in.corner, side)};
  }
};

/// The 2-3 flip across face `face` of tetrahedron t, which must not be locked.
TETUNE_HD inline FlipCandidate face_cavity(const MeshView& mesh, Index t, int face) {
  FlipCandidate c;
  const HalfFace across = mesh.tet2tet[t][face];
  const Index other = tet_of(across);
  const Tet tet = mesh.tet2vertex[t];
  c.kind = FlipKind::face_removal;
  c.a = tet[face];
  c.b = mesh.opposite_vertex(across);
  const bool turned = c.b < c.a;
  if (turned) {
    c.a = c.b;
    c.b = tet[face];
  }
  c.tets[turned ? 1 : 0] = t;
  c.tets[turned ? 0 : 1] = other;
  // From the other side, the orientation of the face is reversed.
  const Index face_ring[3] = {tet[face_vertex(face, 0)], tet[face_vertex(face, turned ? 2 : 1)],
                              tet[face_vertex(face, turned ? 1 : 2)]};
  int lowest = face_ring[1] < face_ring[0] ? 1 : 0;
  if (face_ring[2] < face_ring[lowest]) lowest = 2;
  for (int m = 0; m < 3; ++m) c.ring[m] = face_ring[lowest + m < 3 ? lowest + m : lowest + m - 3];
  return c;
}

/// The removal of the edge of a star; kind none where the star is empty or the edge is constrained.
TETUNE_HD inline FlipCandidate edge_cavity(const EdgeStar& star, const ConstrainedEdges& constrained) {
  FlipCandidate c;
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

}  // namespace tetune

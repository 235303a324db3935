// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/constrained_edges.hpp"
#include "core/work_mesh.hpp"
#include "energy/harmonic.hpp"

/// The geometry of the bistellar flips (Fig. 1). Vertices a, b are the ends of the edge, p, q, r the triangle around
/// it, with (a, p, q, r) positive:
///   2-3:  (a,p,q,r), (b,p,r,q)            ->  (a,p,q,b), (a,q,r,b), (a,r,p,b)
///   3-2:  the other way round.
namespace tetune {

enum class FlipKind : std::uint8_t { none, face23, edge32 };

/// Where the five vertices and the tetrahedra of a flip are.
struct Cavity {
  FlipKind kind = FlipKind::none;
  Index a, b;
  Index ring[3];  ///< p, q, r
  Index tets[3];  ///< 2-3: (a,p,q,r), (b,p,r,q), -; 3-2: (a,p,q,b), (a,q,r,b), (a,r,p,b)
};

/// The face flip across face `face` of tetrahedron t; kind none where the face is locked.
TETUNE_HD inline Cavity face_cavity(const MeshView& mesh, Index t, int face) {
  Cavity c;
  const Link link = mesh.tet2tet[t][face];
  if (is_locked(link)) return c;
  const Tet tet = mesh.tet2vertex[t];
  c.kind = FlipKind::face23;
  c.a = tet[face];
  for (int k = 0; k < 3; ++k) c.ring[k] = tet[face_vertex(face, k)];
  c.tets[0] = t;
  c.tets[1] = link_tet(link);
  c.tets[2] = -1;
  c.b = mesh.tet2vertex[c.tets[1]][link_face(link)];
  return c;
}

/// The two ends of local edge 0..5 and, opposite it, the two other vertices in the order that makes (i, k, l, j) even.
struct EdgeCorners {
  int i, j, k, l;  ///< the ends i, j; the others k, l
};
TETUNE_HD TETUNE_INLINE EdgeCorners edge_corners(int edge) {
  constexpr EdgeCorners kTable[6] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2},
                                     {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}};
  return kTable[edge];
}

/// The edge flip at local edge `edge` of t; kind none unless exactly three tetrahedra, within unlocked faces, lie
/// around it.
TETUNE_HD inline Cavity edge_cavity(const MeshView& mesh, const ConstrainedEdges& constrained, Index t, int edge) {
  Cavity c;
  const EdgeCorners e = edge_corners(edge);
  const Link across_k = mesh.tet2tet[t][e.k];
  const Link across_l = mesh.tet2tet[t][e.l];
  if (is_locked(across_k) || is_locked(across_l)) return c;
  const Index tet_k = link_tet(across_k);  // holds i, j, l and the third ring vertex
  const Index tet_l = link_tet(across_l);
  const Index r = mesh.tet2vertex[tet_k][link_face(across_k)];
  if (r != mesh.tet2vertex[tet_l][link_face(across_l)]) return c;
  const Tet tet = mesh.tet2vertex[t];
  // The face (i, j, r) between the other two must be free as well.
  if (is_locked(mesh.tet2tet[tet_k][local_index(mesh.tet2vertex[tet_k], tet[e.l])])) return c;
  c.a = tet[e.i];
  c.b = tet[e.j];
  if (constrained.contains(c.a, c.b)) return c;
  c.kind = FlipKind::edge32;
  c.ring[0] = tet[e.k];
  c.ring[1] = tet[e.l];
  c.ring[2] = r;
  c.tets[0] = t;
  c.tets[1] = tet_k;  // (a, q, r, b), q = l
  c.tets[2] = tet_l;  // (a, r, p, b), p = k
  return c;
}

/// Sum of eta of the tetrahedra a flip would make; negative where one of them is not certified positive.
/// Gives up once the sum passes `limit`.
TETUNE_HD inline double energy_after(const MeshView& mesh, const Cavity& c, double limit) {
  const Vec3 a = vec(mesh.points[c.a]);
  const Vec3 b = vec(mesh.points[c.b]);
  const Vec3 p = vec(mesh.points[c.ring[0]]);
  const Vec3 q = vec(mesh.points[c.ring[1]]);
  const Vec3 r = vec(mesh.points[c.ring[2]]);
  if (c.kind == FlipKind::face23) {
    // All three wrap the new edge: reject on the cheap volumes first.
    const Vec3 ab = b - a;
    const Vec3 ap = p - a;
    const Vec3 aq = q - a;
    const Vec3 ar = r - a;
    if (!(dot(cross(ap, aq), ab) > 0) || !(dot(cross(aq, ar), ab) > 0) || !(dot(cross(ar, ap), ab) > 0)) return -1;
    const TetEnergy e0 = tet_energy(mesh.law, a, p, q, b);
    if (!e0.certified || !(e0.eta < limit)) return -1;
    const TetEnergy e1 = tet_energy(mesh.law, a, q, r, b);
    if (!e1.certified || !(e0.eta + e1.eta < limit)) return -1;
    const TetEnergy e2 = tet_energy(mesh.law, a, r, p, b);
    return e2.certified ? e0.eta + e1.eta + e2.eta : -1;
  }
  const TetEnergy e0 = tet_energy(mesh.law, a, p, q, r);
  if (!e0.certified || !(e0.eta < limit)) return -1;
  const TetEnergy e1 = tet_energy(mesh.law, b, p, r, q);
  return e1.certified ? e0.eta + e1.eta : -1;
}

}  // namespace tetune

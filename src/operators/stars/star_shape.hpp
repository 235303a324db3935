// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/criterion.hpp"
#include "mesh/constrained_edges.hpp"
#include "mesh/edge_star.hpp"
#include "mesh/small_set.hpp"
#include "operators/stars/star_candidate.hpp"

namespace tetune {

/// The tetrahedra and faces of a cavity: in the memory of a thread, or in that which a team shares. There one thread
/// changes them.
struct StarArrays {
  SmallSet<kMaxStarTets> tets;
  LinkFace faces[kMaxStarFaces];
  HalfFace sides[kMaxStarFaces];      ///< the faces as those of the tetrahedra
  LinkFace bases[kMaxStarTriangles];  ///< the surface triangles that are replaced
  SurfaceSimplex simplex;
  int face_count, base_count;

  TETUNE_HD void clear() {
    tets.clear();
    simplex = {};
    face_count = base_count = 0;
  }
};

/// How a cavity gets its tetrahedra and faces. One thread calls the functions that change it.
class StarShape {
 protected:
  TETUNE_HD StarShape(const RatedMesh& mesh, const ConstrainedEdges& constrained, StarArrays& arrays)
      : mesh_(mesh), constrained_(constrained), arrays_(arrays) {}

  /// Adds all tetrahedra around an edge of t. Like the next two, returns false if the cavity may not have them.
  TETUNE_HD TETUNE_OUTLINE bool add_edge(Index t, int edge) {
    const EdgeCorners e = edge_corners(edge);
    const Tet tet = mesh_.tet2vertex[t];
    const FaceAdjacency links = mesh_.tet2tet[t];
    if (is_locked(links[e.k]) || is_locked(links[e.l])) return false;
    if (constrained_.contains(tet[e.i], tet[e.j])) return false;
    const Index last = tet_of(links[e.l]);
    arrays_.tets.add(t);
    for (EdgeWalk walk{tet[e.l], links[e.k]};;) {
      if (2 * arrays_.tets.size() == kMaxStarFaces) return false;
      arrays_.tets.add(walk.tet());
      if (walk.tet() == last) break;
      if (!walk.step(mesh_)) return false;
    }
    return true;
  }
  /// Adds all tetrahedra around a simplex of the surface of which t is one, on all sides of interfaces too, if
  /// they are at most `max_tets`. The next function likewise.
  TETUNE_HD TETUNE_OUTLINE bool add_surface(Index t, const SurfaceSimplex& simplex, int max_tets) {
    arrays_.simplex = simplex;
    arrays_.tets.add(t);
    for (int i = 0; i < arrays_.tets.size(); ++i) {
      const Tet tet = mesh_.tet2vertex[arrays_.tets[i]];
      for (int f = 0; f < 4; ++f) {
        if (!simplex.is_on_face(tet, f)) continue;
        const HalfFace across = mesh_.tet2tet[arrays_.tets[i]][f];
        if (across != kNoHalfFace && !arrays_.tets.contains(tet_of(across))) {
          if (arrays_.tets.size() == max_tets) return false;
          arrays_.tets.add(tet_of(across));
        }
        if (!lists_locked_face(arrays_.tets[i], across)) continue;
        if (arrays_.base_count == kMaxStarTriangles) return false;
        arrays_.bases[arrays_.base_count++] = link_face(tet, f);
      }
    }
    return arrays_.base_count > 0;
  }
  /// Adds all tetrahedra around a vertex of the cavity.
  TETUNE_HD TETUNE_OUTLINE bool add_all_around(Index v, int max_tets = kMaxStarTets) {
    for (int i = 0; i < arrays_.tets.size(); ++i) {
      const Tet tet = mesh_.tet2vertex[arrays_.tets[i]];
      if (tet[local_index(tet, v)] != v) continue;
      const FaceAdjacency links = mesh_.tet2tet[arrays_.tets[i]];
      for (int f = 0; f < 4; ++f) {
        if (tet[f] == v) continue;
        if (is_locked(links[f])) return false;
        if (arrays_.tets.contains(tet_of(links[f]))) continue;
        if (arrays_.tets.size() == max_tets) return false;
        arrays_.tets.add(tet_of(links[f]));
      }
    }
    return true;
  }
  /// Finds the faces of the tetrahedra. Returns false where a locked face lies between two, or there are too many.
  /// `inside`: a vertex all tetrahedra around which add_all_around() has added; kNoVertex: none.
  TETUNE_HD TETUNE_OUTLINE bool find_faces(Index inside = kNoVertex) {
    arrays_.face_count = 0;
    for (int i = 0; i < arrays_.tets.size(); ++i) {
      const Tet tet = mesh_.tet2vertex[arrays_.tets[i]];
      const FaceAdjacency links = mesh_.tet2tet[arrays_.tets[i]];
      const int opposite = local_index(tet, inside);
      const bool has_inside = tet[opposite] == inside;
      for (int f = has_inside ? opposite : 0; f < (has_inside ? opposite + 1 : 4); ++f) {
        const bool is_base = is_locked(links[f]) && arrays_.simplex.is_on_face(tet, f);
        if (links[f] != kNoHalfFace && arrays_.tets.contains(tet_of(links[f]))) {
          if (is_locked(links[f]) && !is_base) return false;
          continue;
        }
        if (is_base) continue;
        if (arrays_.face_count == kMaxStarFaces) return false;
        arrays_.faces[arrays_.face_count] = link_face(tet, f);
        arrays_.sides[arrays_.face_count++] = make_half_face(arrays_.tets[i], f);
      }
    }
    return true;
  }

  /// Whether the edge is one of a replaced triangle, opposite a vertex of the simplex.
  TETUNE_HD bool is_base_edge(Index a, Index b) const {
    for (int i = 0; i < arrays_.base_count; ++i) {
      if (!has_vertex(arrays_.bases[i], a) || !has_vertex(arrays_.bases[i], b)) continue;
      for (const Index v : arrays_.bases[i].v) {
        if (v != a && v != b && arrays_.simplex.has(v)) return true;
      }
    }
    return false;
  }

  /// The tetrahedron across a face, with its faces towards the cavity: one or two of them.
  struct Growth {
    Tet tet{};
    Index t = -1;  ///< -1: it cannot be taken
    int first = 0, second = -1;
    /// The positions of its other faces among those of the cavity: of the faces that vanish, and new ones.
    int positions[3] = {};

    TETUNE_HD int new_faces() const { return second >= 0 ? 2 : 3; }
  };
  /// Where the tetrahedron across face i may be taken. Its faces towards the cavity vanish, one or two of them: with
  /// three, a vertex would vanish as well.
  TETUNE_HD TETUNE_OUTLINE Growth growth_across(int i) const {
    Growth g;
    const HalfFace across = mesh_.across(arrays_.sides[i]);
    if (is_locked(across)) return {};
    const Index t = tet_of(across);
    g.first = face_of(across);
    g.tet = mesh_.tet2vertex[t];
    const FaceAdjacency links = mesh_.tet2tet[t];
    for (int f = 0; f < 4; ++f) {
      if (f == g.first || links[f] == kNoHalfFace || !arrays_.tets.contains(tet_of(links[f]))) continue;
      if (g.second >= 0 || is_locked(links[f])) return {};
      g.second = f;
    }
    if (g.second >= 0) {
      // The edge between the two vanishes.
      const EdgeCorners e = edge_corners(edge_of(g.first, g.second));
      if (constrained_.contains(g.tet[e.k], g.tet[e.l]) || is_base_edge(g.tet[e.k], g.tet[e.l])) return {};
    }
    g.positions[0] = i;
    g.positions[1] = g.second >= 0 ? position_of_side(links[g.second]) : arrays_.face_count;
    g.positions[2] = arrays_.face_count + 1;
    g.t = t;
    return g;
  }
  TETUNE_HD TETUNE_OUTLINE void take(const Growth& g) {
    arrays_.tets.add(g.t);
    if (g.second < 0) arrays_.face_count += 2;
    int n = 0;
    for (int f = 0; f < 4; ++f) {
      if (f == g.first || f == g.second) continue;
      arrays_.faces[g.positions[n]] = link_face(g.tet, f);
      arrays_.sides[g.positions[n++]] = make_half_face(g.t, f);
    }
  }
  TETUNE_HD bool has_room() const { return !arrays_.tets.is_full() && arrays_.face_count + 2 <= kMaxStarFaces; }

  RatedMesh mesh_;
  ConstrainedEdges constrained_;
  StarArrays& arrays_;

 private:
  TETUNE_HD int position_of_side(HalfFace side) const {
    int i = 0;
    while (arrays_.sides[i] != side) ++i;
    return i;
  }
};

}  // namespace tetune

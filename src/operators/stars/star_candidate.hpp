// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/ring.hpp"
#include "operators/engine/candidate.hpp"
#include "operators/engine/vertex_arrays.hpp"

/// The candidate of all operators that retriangulate a cavity from one point.
namespace tetune {

/// The maximum number of tetrahedra of a cavity, of its faces, and of the surface triangles that it replaces.
inline constexpr int kMaxStarTets = 48;
inline constexpr int kMaxStarFaces = 64;
inline constexpr int kMaxStarTriangles = 24;
/// The apex of a cavity that is a vertex yet to be inserted.
inline constexpr Index kNewVertex = -1;
/// In place of the removed vertex of a candidate that removes none.
inline constexpr Index kNoVertex = -1;

TETUNE_HD inline LinkFace link_face(const Tet& tet, int f) {
  return {{tet[face_vertex(f, 0)], tet[face_vertex(f, 1)], tet[face_vertex(f, 2)]}};
}
TETUNE_HD inline bool has_vertex(const LinkFace& f, Index vertex) {
  return f.v[0] == vertex || f.v[1] == vertex || f.v[2] == vertex;
}
/// Whether two vertices, which may be the same, are on one of the faces.
TETUNE_HD inline bool share_face(const LinkFace* faces, int count, Index v, Index w) {
  for (int i = 0; i < count; ++i) {
    if (has_vertex(faces[i], v) && has_vertex(faces[i], w)) return true;
  }
  return false;
}

/// A simplex of the surface, all of whose surface triangles a cavity replaces: a vertex, an edge or a triangle.
struct SurfaceSimplex {
  Index v[3];
  int size = 0;  ///< the number of vertices; 0: the surface stays

  TETUNE_HD bool has(Index vertex) const {
    for (int i = 0; i < size; ++i) {
      if (v[i] == vertex) return true;
    }
    return false;
  }
  /// Whether face f of a tetrahedron contains the simplex, all of whose vertices are the tetrahedron's.
  TETUNE_HD bool is_on_face(const Tet& tet, int f) const { return size > 0 && !has(tet[f]); }
};

/// Triangles of the surface that an operation replaces, by their position in the list.
struct ReplacedTriangles {
  int count = 0;
  double deviation = 0;  ///< of the new triangles (BoundaryTriangle::deviation)
  Index triangle[kMaxStarTriangles];
};

/// A cavity retriangulated from its apex, with the faces of both. Each surface triangle that it replaces becomes the
/// triangles of the apex and of its edges opposite the vertices of the simplex.
struct StarPatch {
  static constexpr int kMaxExtraTets = kMaxStarFaces;
  static constexpr int kMaxCavityFaces = kMaxStarFaces;

  Vec3 apex_position;
  Index apex;
  Index removed;
  bool is_inserted, is_moved;
  NewVertexDof dof;
  SurfaceSimplex simplex;
  int tet_count, edges;
  int made = 0;
  int faces_count = 0;
  int base_edges_count = 0;
  ReplacedTriangles replaced;  ///< the surface triangles that vanish
  Index tets[kMaxStarTets];
  LinkFace faces[kMaxStarFaces];
  HalfFace sides[kMaxStarFaces];        ///< the faces as those of the old tetrahedra
  std::int8_t face2tet[kMaxStarFaces];  ///< the new tetrahedron on a face; negative where the apex is on it
  std::int8_t tet2face[kMaxStarFaces];

  /// An edge of a replaced surface triangle that forms a new one with the apex.
  struct BaseEdge {
    Index a, b;
    bool is_outer;  ///< on the outer boundary; otherwise the triangle has tetrahedra on both sides
  };
  BaseEdge base_edges[2 * kMaxStarTriangles];

  TETUNE_HD int old_count() const { return tet_count; }
  TETUNE_HD int edge_count() const { return edges; }
  TETUNE_HD int new_count() const { return made; }
  TETUNE_HD int face_count() const { return faces_count; }
  TETUNE_HD int new_surface_faces() const { return base_edges_count > 0 ? 1 : 0; }
  TETUNE_HD HalfFace old_face(int k) const { return sides[k]; }
  TETUNE_HD int vertex_count() const { return 3 * faces_count + 1; }
  TETUNE_HD Index vertex(int i) const { return i < 3 * faces_count ? faces[i / 3].v[i % 3] : apex; }
  /// The old tetrahedron that new tetrahedron x descends from: that at its face.
  TETUNE_HD Index parent(int x) const { return tet_of(sides[tet2face[x]]); }

  TETUNE_HD void add_face(const Tet& tet, HalfFace side) {
    const LinkFace face = link_face(tet, face_of(side));
    faces[faces_count] = face;
    sides[faces_count] = side;
    face2tet[faces_count] = static_cast<std::int8_t>(has_vertex(face, apex) ? -1 : made);
    if (!has_vertex(face, apex)) tet2face[made++] = static_cast<std::int8_t>(faces_count);
    ++faces_count;
  }
  /// Adds the edges of a replaced surface triangle that is face f of a tetrahedron.
  TETUNE_HD void add_base(const Tet& tet, int f, bool is_outer) {
    for (int k = 0; k < 3; ++k) {
      if (!simplex.has(tet[face_vertex(f, k)])) continue;
      const Index a = tet[face_vertex(f, (k + 1) % 3)];
      const Index b = tet[face_vertex(f, (k + 2) % 3)];
      if (a != apex && b != apex) base_edges[base_edges_count++] = {a, b, is_outer};
    }
  }

  /// Opposite the apex of the tetrahedron on it; where the apex is on it, in the tetrahedron beyond the side opposite
  /// the apex.
  TETUNE_HD NewFace new_face(int k) const {
    if (face2tet[k] >= 0) return {face2tet[k], 0};
    int corner = 0;
    while (faces[k].v[corner] != apex) ++corner;
    const Side next = beyond(k, corner);
    return {face2tet[next.face], next.corner + 1};
  }
  TETUNE_HD Tet new_tet(int x) const {
    const LinkFace& f = faces[tet2face[x]];
    return {{apex, f.v[0], f.v[1], f.v[2]}};
  }
  TETUNE_HD NewNeighbor new_neighbor(int x, int face) const {
    const int f = tet2face[x];
    if (face == 0) return {-1, f};
    const int base = base_edge(faces[f].v[face % 3], faces[f].v[(face + 1) % 3]);
    if (base >= 0 && base_edges[base].is_outer) return {-1, faces_count};
    const Side next = beyond(f, face - 1);
    const int tet = face2tet[next.face];
    if (tet < 0) return {-1, next.face};
    return {tet, next.corner + 1, base >= 0 ? kLocked : HalfFace{0}};
  }
  /// The base edge between two vertices, or -1.
  TETUNE_HD int base_edge(Index a, Index b) const {
    for (int i = 0; i < base_edges_count; ++i) {
      const BaseEdge& e = base_edges[i];
      if ((e.a == a && e.b == b) || (e.a == b && e.b == a)) return i;
    }
    return -1;
  }

  TETUNE_HD void assign_vertex(Index v) {
    if (is_inserted) apex = v;
  }
  TETUNE_HD void write_vertex(const MeshView& mesh, const VertexArrays& vertices) const {
    if (removed >= 0) vertices.vertex2original[removed] = kRemoved;
    if (is_inserted || is_moved) mesh.points[apex] = point(apex_position);
    if (is_inserted) vertices.insert(apex, apex_position, dof);
  }

  TETUNE_HD void count(FlipCounts&) const {}
  TETUNE_HD void count(ChangeCounts& counts) const {
    counts.add_tets(tet_count, made);
    counts.inserted = is_inserted ? 1 : 0;
    counts.removed = removed >= 0 ? 1 : 0;
    counts.triangles = is_inserted ? static_cast<std::uint32_t>(replaced.count * (simplex.size - 1)) : 0;
  }

 private:
  struct Side {
    int face, corner;
  };
  /// The side opposite corner k of a face: which face lies beyond it, and which of its corners is opposite.
  TETUNE_HD Side beyond(int face, int k) const {
    const Index a = faces[face].v[k == 2 ? 0 : k + 1];
    const Index b = faces[face].v[k == 0 ? 2 : k - 1];
    for (int i = 0; i < faces_count; ++i) {
      for (int c = 0; c < 3; ++c) {
        if (faces[i].v[c == 2 ? 0 : c + 1] == b && faces[i].v[c == 0 ? 2 : c - 1] == a) return {i, c};
      }
    }
    return {-1, -1};
  }
};

/// A cavity and its apex.
struct StarCandidate {
  using Patch = StarPatch;

  Vec3 apex_position;
  Index apex;     ///< vertex, or kNewVertex
  Index removed;  ///< vertex, or kNoVertex
  bool is_moved;  ///< the apex is a vertex that moves; all tetrahedra around it are in the cavity
  NewVertexDof dof;
  SurfaceSimplex simplex;
  ReplacedTriangles replaced;
  int tet_count;
  int edges = 0;                           ///< the number of edges of the surface that a contraction makes
  Index tets[kMaxStarTets];                ///< then the slots that stand for these edges
  std::uint8_t outer_faces[kMaxStarTets];  ///< of each tetrahedron, as bits

  TETUNE_HD int old_count() const { return tet_count; }
  TETUNE_HD int edge_count() const { return edges; }
  TETUNE_HD StarPatch expand(const MeshView& mesh) const {
    StarPatch p;
    p.apex_position = apex_position;
    p.apex = apex;
    p.removed = removed;
    p.is_inserted = apex == kNewVertex;
    p.is_moved = is_moved;
    // Neither padding nor the rest of an array is copied: they are uninitialized.
    p.dof.dof = dof.dof;
    p.dof.axis = dof.axis;
    p.dof.radius = dof.radius;
    p.dof.surface_point = dof.surface_point;
    p.simplex = simplex;
    p.tet_count = tet_count;
    p.edges = edges;
    p.replaced.count = replaced.count;
    p.replaced.deviation = replaced.deviation;
    for (int i = 0; i < replaced.count; ++i) p.replaced.triangle[i] = replaced.triangle[i];
    for (int i = 0; i < tet_count + edges; ++i) p.tets[i] = tets[i];
    for (int i = 0; i < tet_count; ++i) {
      const Tet tet = mesh.tet2vertex[tets[i]];
      for (int f = 0; f < 4; ++f) {
        if ((outer_faces[i] & 1 << f) != 0) p.add_face(tet, make_half_face(tets[i], f));
      }
      if (simplex.size > 0 && has_simplex(tet)) add_bases(mesh, tets[i], tet, p);
    }
    return p;
  }

 private:
  TETUNE_HD bool has_simplex(const Tet& tet) const {
    int found = 0;
    for (int k = 0; k < 4; ++k) found += simplex.has(tet[k]) ? 1 : 0;
    return found == simplex.size;
  }
  /// Adds the replaced surface triangles of a tetrahedron; one between two tetrahedra is added for the lower slot.
  TETUNE_HD void add_bases(const MeshView& mesh, Index t, const Tet& tet, StarPatch& p) const {
    for (int f = 0; f < 4; ++f) {
      const HalfFace across = mesh.tet2tet[t][f];
      if (lists_locked_face(t, across) && simplex.is_on_face(tet, f)) p.add_base(tet, f, across == kNoHalfFace);
    }
  }
};

/// Stores a candidate. nvcc does not infer that memory of this type is aligned, and would copy byte by byte.
TETUNE_HD inline void store(const StarCandidate& candidate, StarCandidate& to) {
  *static_cast<StarCandidate*>(__builtin_assume_aligned(&to, alignof(StarCandidate))) = candidate;
}

}  // namespace tetune

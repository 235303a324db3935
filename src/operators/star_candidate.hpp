// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/ring.hpp"
#include "operators/candidate.hpp"
#include "operators/vertex_arrays.hpp"

/// The candidate of all operators that retriangulate a cavity from one point.
namespace tetune {

/// The maximum number of tetrahedra of a cavity, and of its faces.
inline constexpr int kMaxStarTets = 48;
inline constexpr int kMaxStarFaces = 64;
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

/// A cavity retriangulated from its apex, with the faces of both.
struct StarPatch {
  static constexpr int kMaxExtraTets = kMaxStarFaces;
  static constexpr int kMaxCavityFaces = kMaxStarFaces;
  /// All new tetrahedra descend from the first old one.
  static constexpr bool kOneOriginal = true;

  Vec3 apex_position;
  Index apex;
  Index removed;
  bool is_inserted;
  int tet_count;
  int made = 0;
  int faces_count = 0;
  Index tets[kMaxStarTets];
  LinkFace faces[kMaxStarFaces];
  HalfFace sides[kMaxStarFaces];        ///< the faces as those of the old tetrahedra
  std::int8_t face2tet[kMaxStarFaces];  ///< the new tetrahedron on a face; negative where the apex is on it
  std::int8_t tet2face[kMaxStarFaces];

  TETUNE_HD int old_count() const { return tet_count; }
  TETUNE_HD int new_count() const { return made; }
  TETUNE_HD int face_count() const { return faces_count; }
  TETUNE_HD int new_surface_faces() const { return 0; }
  TETUNE_HD HalfFace old_face(const MeshView&, int k) const { return sides[k]; }
  TETUNE_HD int vertex_count() const { return 3 * faces_count + 1; }
  TETUNE_HD Index vertex(int i) const { return i < 3 * faces_count ? faces[i / 3].v[i % 3] : apex; }

  TETUNE_HD void add_face(const Tet& tet, HalfFace side) {
    const LinkFace face = link_face(tet, face_of(side));
    faces[faces_count] = face;
    sides[faces_count] = side;
    face2tet[faces_count] = static_cast<std::int8_t>(has_vertex(face, apex) ? -1 : made);
    if (!has_vertex(face, apex)) tet2face[made++] = static_cast<std::int8_t>(faces_count);
    ++faces_count;
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
    if (face == 0) return {-1, tet2face[x]};
    const Side next = beyond(tet2face[x], face - 1);
    const int tet = face2tet[next.face];
    return tet < 0 ? NewNeighbor{-1, next.face} : NewNeighbor{tet, next.corner + 1};
  }

  TETUNE_HD void assign_vertex(Index v) {
    if (is_inserted) apex = v;
  }
  TETUNE_HD void write_vertex(const MeshView& mesh, const VertexArrays& vertices) const {
    if (removed >= 0) {
      vertices.vertex2original[removed] = kRemoved;
    } else {
      mesh.points[apex] = point(apex_position);
    }
    if (is_inserted) vertices.insert(apex);
  }

  TETUNE_HD void count(FlipCounts&) const {}
  TETUNE_HD void count(ChangeCounts& counts) const {
    counts.add_tets(tet_count, made);
    counts.inserted = is_inserted ? 1 : 0;
    counts.removed = removed >= 0 ? 1 : 0;
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
  int tet_count;
  Index tets[kMaxStarTets];
  std::uint8_t outer_faces[kMaxStarTets];  ///< of each tetrahedron, as bits

  TETUNE_HD int old_count() const { return tet_count; }
  TETUNE_HD StarPatch expand(const MeshView& mesh) const {
    StarPatch p;
    p.apex_position = apex_position;
    p.apex = apex;
    p.removed = removed;
    p.is_inserted = apex == kNewVertex;
    p.tet_count = tet_count;
    for (int i = 0; i < tet_count; ++i) {
      p.tets[i] = tets[i];
      const Tet tet = mesh.tet2vertex[tets[i]];
      for (int f = 0; f < 4; ++f) {
        if ((outer_faces[i] & 1 << f) != 0) p.add_face(tet, make_half_face(tets[i], f));
      }
    }
    return p;
  }
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <type_traits>

#include "mesh/work_mesh.hpp"
#include "operators/engine/slots.hpp"
#include "tetune/flip_counts.hpp"

/// The requirements of the cavity engine on an operator's candidates: a cavity, that is a set of tetrahedra with its
/// boundary faces, and the new tetrahedra that fill it.
namespace tetune {

/// Face `face` of new tetrahedron `tet`.
struct NewFace {
  int tet, face;
};
/// The face across a face of a new tetrahedron: that of new tetrahedron `tet`, or with tet < 0 that which lies across
/// boundary face `face` of the cavity. `lock` is kLocked where a locked face lies between two new tetrahedra.
struct NewNeighbor {
  int tet, face;
  HalfFace lock = 0;
};

/// A cavity with all that its application needs.
/// - Boundary faces are numbered: first the face_count() existing ones, then the new_surface_faces() ones that are made
///   in a surface.
/// - New tetrahedron x takes the slot of the old one x, while there is one, and descends from it; the others descend
///   from the first old one. Where the patch has parent(x), new tetrahedron x descends from that one, and there are at
///   most kMaxExtraTets new ones.
/// - Where the patch and the candidate have edge_count(), as many slots that stand for edges of the surface which the
///   candidate makes (slot_of_edge()) follow the tetrahedra, from tets[old_count()] on.
/// - Two parts of a candidate make the same faces in a surface; where the patch has meets(other), only if that is true.
template <class P>
concept CavityPatch = std::is_trivially_copyable_v<P> &&
    requires(const P& p, int i, FlipCounts& flips, ChangeCounts& changes) {
  { P::kMaxExtraTets } -> std::convertible_to<int>;
  { P::kMaxCavityFaces } -> std::convertible_to<int>;
  { p.old_count() } -> std::same_as<int>;
  { p.tets[i] } -> std::convertible_to<Index>;
  { p.face_count() } -> std::same_as<int>;
  { p.new_surface_faces() } -> std::same_as<int>;
  { p.old_face(i) } -> std::same_as<HalfFace>;
  { p.new_count() } -> std::same_as<int>;
  { p.new_tet(i) } -> std::same_as<Tet>;
  { p.new_face(i) } -> std::same_as<NewFace>;
  { p.new_neighbor(i, i) } -> std::same_as<NewNeighbor>;
  { p.vertex_count() } -> std::same_as<int>;
  { p.vertex(i) } -> std::same_as<Index>;
  p.count(flips);
  p.count(changes);
};

/// A candidate as an operator's proposals store it: small, with the tetrahedra of its cavity; expand() makes the patch.
template <class C>
concept Candidate = std::is_trivially_copyable_v<C> && CavityPatch<typename C::Patch> &&
    requires(const C& c, const MeshView& mesh, int i) {
  { c.old_count() } -> std::same_as<int>;
  { c.tets[i] } -> std::convertible_to<Index>;
  { c.expand(mesh) } -> std::convertible_to<typename C::Patch>;
};

/// Stores a candidate; a type may have an overload.
template <class C>
TETUNE_HD void store(const C& candidate, C& to) {
  to = candidate;
}

template <class Cavity>
TETUNE_HD double energy_before(const Cavity& cavity, Span<const double> energies) {
  double sum = 0;
  for (int k = 0; k < cavity.old_count(); ++k) sum += energies[cavity.tets[k]];
  return sum;
}

}  // namespace tetune

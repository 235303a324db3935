// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <type_traits>

#include "backend/prefetch.hpp"
#include "mesh/work_mesh.hpp"
#include "operators/slots.hpp"
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

/// A cavity with all that its application needs. Boundary faces are numbered; face_count() of them are there before,
/// new_surface_faces() more, numbered after these, are made in a surface. The first new_count() slots of new tetrahedra
/// are those of the old ones, in order. The others descend from the first old one; where a patch has parent(x), each
/// new tetrahedron descends from that one. Two parts of a candidate make the same faces in a surface; where a patch has
/// meets(other), only if that holds.
template <class P>
concept CavityPatch = std::is_trivially_copyable_v<P> &&
    requires(const P& p, const MeshView& mesh, int i, FlipCounts& flips, ChangeCounts& changes) {
  { P::kMaxExtraTets } -> std::convertible_to<int>;
  { P::kMaxCavityFaces } -> std::convertible_to<int>;
  { p.old_count() } -> std::same_as<int>;
  { p.tets[i] } -> std::convertible_to<Index>;
  { p.face_count() } -> std::same_as<int>;
  { p.new_surface_faces() } -> std::same_as<int>;
  { p.old_face(mesh, i) } -> std::same_as<HalfFace>;
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

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/application.hpp"
#include "operators/face_cluster.hpp"
#include "operators/face_removal.hpp"
#include "operators/flip_proposals.hpp"

namespace tetune {
namespace face_removal_detail {

/// Each face is evaluated by the worse of its two tetrahedra.
struct FaceRemovalProposals {
  using Candidate = FlipCandidate;
  static constexpr int kParts = 1;
  static constexpr Size kGrain = 32;
  static constexpr Size kBatch = Size{1} << 16;
  RatedMesh mesh;
  ConstrainedEdges constrained;
  Span<const double> energies;
  int max_faces;
  Span<const Index> active;

  TETUNE_INLINE void prefetch(Size i) const { PrefetchAhead{mesh, energies, active}(i); }

  TETUNE_HD Size operator()(Size i, const Proposals<FlipCandidate>& proposals) const {
    const Index t = active[i];
    const Tet tet = mesh.tet2vertex[t];
    const FaceAdjacency links = mesh.tet2tet[t];
    const IsWorse is_worse{energies, t, energies[t]};
    Index apex[4];  // the vertex across each face; -1: locked
    for (int face = 0; face < 4; ++face) apex[face] = is_locked(links[face]) ? -1 : apex_of(links[face]);
    Size evaluated = 0;
    for (int face = 0; face < 4; ++face) {
      if (apex[face] < 0 || is_worse(tet_of(links[face])) || !has_two_beside(tet, apex, face, tet_of(links[face])))
        continue;
      ++evaluated;
      evaluate(i, t, face, proposals);
    }
    return evaluated;
  }

 private:
  TETUNE_HD TETUNE_INLINE Index apex_of(HalfFace face) const { return mesh.tet2vertex[tet_of(face)][face_of(face)]; }
  /// Whether two faces beside this one may lie between the same two vertices: the cheapest test, which few faces pass.
  TETUNE_HD TETUNE_INLINE bool has_two_beside(const Tet& tet, const Index apex[4], int face, Index other) const {
    const Tet other_tet = mesh.tet2vertex[other];
    const FaceAdjacency other_links = mesh.tet2tet[other];
    int count = 0;
    for (int side = 0; side < 4; ++side) {
      if (side == face || apex[side] < 0) continue;
      const HalfFace below = other_links[local_index(other_tet, tet[side])];
      count += !is_locked(below) && apex_of(below) == apex[side] ? 1 : 0;
    }
    return count >= 2;
  }

  /// Adds the best cluster around a face where its removal gains.
  TETUNE_HD void evaluate(Size i, Index t, int face, const Proposals<FlipCandidate>& proposals) const {
    FaceCluster cluster(mesh, constrained);
    if (!cluster.grow(t, face, max_faces) || !(cluster.best_subtree(energies) < 0)) return;
    const FlipCandidate c = cluster.candidate();
    const double before = energy_before(c, energies);
    const double gain = before - energy_after(mesh, c, before);
    if (gain > 0 && gain > kMinRelativeGain * before) proposals.add(i, c, gain, flip_id(t, face));
  }
};

}  // namespace face_removal_detail

template <class Backend>
PassResult face_removal_pass(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                             FlipState<Backend>& state, Span<std::uint8_t> changed) {
  using namespace face_removal_detail;
  const FaceRemovalProposals proposals{rated(mesh, criterion), state.constrained(), state.energies.span(),
                                       state.max_ring - 2, state.active.span()};
  if (proposals.max_faces < 3) {
    PassResult result;
    result.active = state.active.size();
    return result;
  }
  return flip_active(backend, mesh, criterion, state, proposals, changed);
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/engine/application.hpp"
#include "operators/engine/group_evaluation.hpp"
#include "operators/flips/face_cluster.hpp"
#include "operators/flips/face_removal.hpp"
#include "operators/flips/flip_proposals.hpp"

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
    PerTet own;
    start(t, own);
    Size evaluated = 0;
    for (int face = 0; face < 4; ++face) {
      if (test(t, face, own) == kFails) continue;
      FlipCandidate c;
      const double gain = evaluate(t, face, own, c, evaluated);
      if (gain > 0) proposals.add(i, c, gain, candidate_id(t, face));
    }
    return evaluated;
  }

  /// See group_evaluation.hpp.
  static constexpr Kinds kKinds = {4, 0};
  static constexpr int kLists = 1;
  struct PerTet {
    Index apex[4];  ///< the vertex across each face; -1: locked
  };
  TETUNE_HD Index tet(Size i) const { return active[i]; }
  TETUNE_HD TETUNE_INLINE void start(Index t, PerTet& own) const {
    const FaceAdjacency links = mesh.tet2tet[t];
    for (int face = 0; face < 4; ++face)
      own.apex[face] = is_locked(links[face]) ? -1 : mesh.opposite_vertex(links[face]);
  }
  TETUNE_HD TETUNE_INLINE int test(Index t, int face, const PerTet& own) const {
    if (own.apex[face] < 0) return kFails;
    const Index other = tet_of(mesh.tet2tet[t][face]);
    const IsWorse is_worse{energies, t, energies[t]};
    return is_worse(other) || !has_two_beside(mesh.tet2vertex[t], own.apex, face, other) ? kFails : 0;
  }
  /// Finds the best cluster around a face; its removal may gain.
  TETUNE_HD double evaluate(Index t, int face, const PerTet&, FlipCandidate& c, Size& evaluated) const {
    ++evaluated;
    FaceCluster cluster(mesh, constrained);
    if (!cluster.grow(t, face, max_faces) || !(cluster.best_subtree(energies) < 0)) return 0;
    c = cluster.candidate();
    const double before = energy_before(c, energies);
    const double gain = before - energy_after(mesh, c, before);
    return gain > kMinRelativeGain * before ? gain : 0;
  }
  TETUNE_HD void finish(Index, const PerTet&) const {}

 private:
  /// Whether two faces beside this one may lie between the same two vertices: the cheapest test, which few faces pass.
  TETUNE_HD TETUNE_INLINE bool has_two_beside(const Tet& tet, const Index (&apex)[4], int face, Index other) const {
    const Tet other_tet = mesh.tet2vertex[other];
    const FaceAdjacency other_links = mesh.tet2tet[other];
    int count = 0;
    for (int side = 0; side < 4; ++side) {
      if (side == face || apex[side] < 0) continue;
      const HalfFace below = other_links[local_index(other_tet, tet[side])];
      count += !is_locked(below) && mesh.opposite_vertex(below) == apex[side] ? 1 : 0;
    }
    return count >= 2;
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

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/selection.hpp"
#include "operators/star_cavity.hpp"

/// Proposals to retriangulate a cavity from one point, so that its smallest dihedral angle opens.
namespace tetune {

/// The cotangent of the smallest angle must fall by this part.
inline constexpr double kMinCotGain = 0.02;
/// A place for an apex is improved further when the cotangent there is at most this many times what it was.
inline constexpr double kAcceptRatio = 1.5;
/// The bound before the cavity is enlarged.
inline constexpr double kScreenRatio = 2;

/// What an operator needs to evaluate one of its choices, and where it adds the candidate.
struct StarProposal {
  RatedMesh mesh;
  ConstrainedEdges constrained;
  Span<const VertexDof> kind;
  int max_ring;       ///< of the removal of an edge
  double vertex_cot;  ///< vertices are inserted and removed where an angle has a larger cotangent
  Proposals<StarCandidate> proposals;
  Size id;

  TETUNE_HD bool is_movable(Index v) const { return kind[v] == VertexDof::free && !constrained.has_end(v); }
  TETUNE_HD bool may_change_vertices(Index t) const { return max_dihedral_cot(mesh, t) > vertex_cot; }

  /// Adds the retriangulation from x where it opens the smallest angle, whose cotangent is `before`.
  TETUNE_HD void add(const StarCavity& star, double before, Index apex, Index removed, const Vec3& x) const {
    const double limit = (1 - kMinCotGain) * before;
    const double after = star.cot_after(apex, x, limit);
    if (!(after < limit) || !(before - after > 0)) return;
    proposals.add(id, star.candidate(apex, removed, x), before - after, static_cast<std::uint32_t>(id));
  }
};

/// Operators, each with a number of choices per tetrahedron; propose() is that of the operator that has a choice.
template <class... Operators>
struct StarOperators;
template <>
struct StarOperators<> {
  static constexpr int kChoices = 0;
  TETUNE_HD static void propose(const StarProposal&, Index, int) {}
};
template <class First, class... Others>
struct StarOperators<First, Others...> {
  static constexpr int kChoices = First::kChoices + StarOperators<Others...>::kChoices;
  TETUNE_HD static void propose(const StarProposal& proposal, Index t, int choice) {
    if (choice < First::kChoices) {
      First::propose(proposal, t, choice);
    } else {
      StarOperators<Others...>::propose(proposal, t, choice - First::kChoices);
    }
  }
};

/// The choices of some tetrahedra, the first `choices` of each.
template <class Operators>
struct StarProposals {
  using Candidate = StarCandidate;
  static constexpr int kParts = 1;
  static constexpr Size kGrain = 4;
  static constexpr Size kBatch = Size{1} << 12;
  RatedMesh mesh;
  ConstrainedEdges constrained;
  Span<const VertexDof> kind;
  Span<const Index> tets;
  int choices;
  int max_ring;
  double vertex_cot;

  TETUNE_HD Size operator()(Size id, const Proposals<StarCandidate>& proposals) const {
    const StarProposal proposal{mesh, constrained, kind, max_ring, vertex_cot, proposals, id};
    Operators::propose(proposal, tets[id / choices], static_cast<int>(id % choices));
    return 1;
  }
};

}  // namespace tetune

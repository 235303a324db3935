// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/active_set.hpp"
#include "operators/flip_energy.hpp"
#include "operators/prefetch_tets.hpp"
#include "operators/selection.hpp"

/// Which flips there are: those of the faces and edges of each active tetrahedron.
namespace tetune {

/// Candidates 0 to 3 of a tetrahedron are its faces, 4 to 9 its edges.
TETUNE_HD inline std::uint32_t flip_id(Index t, int candidate) {
  return static_cast<std::uint32_t>(t) * kCandidates + static_cast<std::uint32_t>(candidate);
}

/// The order that decides which tetrahedron of a cavity owns its candidate: the worst, the lowest of equals.
struct IsWorse {
  Span<const double> energies;
  Index t;
  double energy_t;
  TETUNE_HD bool operator()(Index other) const {
    const double energy = energies[other];
    return (energy > energy_t) | ((energy == energy_t) & (other < t));
  }
};

/// What the evaluation of a tetrahedron's candidates found.
struct FlipEvaluation {
  double min_ratio;  ///< of the energy after to that before, over all candidates
  Size evaluated = 0;

  TETUNE_HD void add(double ratio) { min_ratio = ratio < min_ratio ? ratio : min_ratio; }
  /// Whether a cavity of this energy may gain, when the energy afterwards is not less than `bound`.
  TETUNE_HD bool may_gain(double bound, double before) {
    if (!(bound > (1 + kBoundMargin) * before)) return true;
    add(bound / before);
    return false;
  }
};

/// 2-3 flips, 3-2 flips and edge removals. Each candidate is evaluated once, by the worst tetrahedron of its cavity:
/// its owner. The slack of the tetrahedron is computed, and it stays active while it owns a flip that gains.
template <class Pack>
struct FlipProposals {
  using Candidate = FlipCandidate;
  static constexpr int kParts = 1;
  static constexpr Size kGrain = 32;
  static constexpr Size kBatch = Size{1} << 16;
  RatedMesh mesh;
  ConstrainedEdges constrained;
  int max_ring;
  Span<const Index> active;
  Span<const double> energies;
  Span<float> slack;
  Span<std::uint8_t> marks;

  TETUNE_INLINE void prefetch(Size i) const { PrefetchAhead{mesh, energies, active}(i); }

  TETUNE_HD Size operator()(Size i, const Proposals<FlipCandidate>& proposals) const {
    const Index t = active[i];
    const FaceAdjacency links = mesh.tet2tet[t];
    const IsWorse is_worse{energies, t, energies[t]};
    const FlipEnergyLowerBound bound(mesh.objective);
    const RingBound ring_bound = bound.ring_bound(is_worse.energy_t, max_ring);
    FlipEvaluation found{1 + kMaxSlack < ring_bound.min_ratio ? 1 + kMaxSlack : ring_bound.min_ratio};
    const unsigned closed = closed_faces(t, links, is_worse);
    for (int face = 0; face < 4; ++face) {
      if ((closed & 1U << face) != 0) continue;
      const double before = is_worse.energy_t + energies[tet_of(links[face])];
      if (!found.may_gain(bound.face_flip(), before)) continue;
      FlipCandidate c = face_cavity(mesh, t, face);
      evaluate(i, c, before, flip_id(t, face), proposals, found);
    }
    for (int edge = 0; edge < 6; ++edge) {
      if ((closed & edge_faces(edge)) != 0) continue;
      const EdgeStar star = edge_star(mesh, ring_bound.max_ring, t, edge, is_worse);
      if (star.size == 0) continue;
      double before = 0;
      for (int m = 0; m < star.size; ++m) before += energies[star.tets[m]];
      if (!found.may_gain(bound.edge_removal(star.size), before)) continue;
      FlipCandidate c = edge_cavity(star, constrained);
      if (c.kind == FlipKind::none) continue;
      evaluate(i, c, energy_before(c, energies), flip_id(t, 4 + edge), proposals, found);
    }
    slack[t] = static_cast<float>(found.min_ratio - 1);
    marks[t] = slack[t] < 0 ? kActive : 0;
    return found.evaluated;
  }

 private:
  /// The faces that are locked, or beyond which an owner lies, as bits.
  TETUNE_HD TETUNE_INLINE static unsigned closed_faces(Index t, const FaceAdjacency& links, const IsWorse& is_worse) {
    unsigned closed = 0;
    for (int f = 0; f < 4; ++f) {
      const bool locked = is_locked(links[f]);
      const bool owner_beyond = is_worse(locked ? t : tet_of(links[f]));
      closed |= ((locked ? 1U : 0U) | (owner_beyond ? 1U : 0U)) << f;
    }
    return closed;
  }

  TETUNE_HD TETUNE_INLINE void evaluate(Size i, FlipCandidate& c, double before, std::uint32_t id,
                                        const Proposals<FlipCandidate>& proposals, FlipEvaluation& found) const {
    ++found.evaluated;
    const double after = best_energy<Pack>(mesh, c, before, (1 + kMaxSlack) * before);
    const bool gains = before - after > kMinRelativeGain * before;
    found.add(gains || after > before ? after / before : 1);
    if (gains) proposals.add(i, c, before - after, id);
  }
};

}  // namespace tetune

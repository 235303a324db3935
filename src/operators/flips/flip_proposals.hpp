// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>

#include "operators/engine/active_set.hpp"
#include "operators/engine/group_evaluation.hpp"
#include "operators/engine/prefetch_tets.hpp"
#include "operators/flips/flip_energy.hpp"
#include "operators/flips/flip_evaluation.hpp"

/// Which flips there are: those of the faces and edges of each active tetrahedron.
namespace tetune {

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
    const IsWorse is_worse = worse_than(t);
    const FlipEnergyLowerBound bound(mesh.objective);
    const RingBound ring_bound = bound.ring_bound(is_worse.energy_t, max_ring);
    FlipEvaluation found{initial_ratio(ring_bound)};
    const unsigned closed = closed_faces(is_worse, links);
    for (int face = 0; face < 4; ++face) {
      if ((closed & 1U << face) != 0) continue;
      const double before = is_worse.energy_t + energies[tet_of(links[face])];
      if (!found.may_gain(bound.face_flip(), before)) continue;
      FlipCandidate c = face_cavity(mesh, t, face);
      add_gain(i, c, before, candidate_id(t, face), proposals, found);
    }
    for (int edge = 0; edge < 6; ++edge) {
      if ((closed & edge_faces(edge)) != 0) continue;
      const EdgeStar star = edge_star(mesh, ring_bound.max_ring, t, edge, is_worse);
      if (star.size == 0 || !star_may_gain(bound, star, found)) continue;
      FlipCandidate c = edge_cavity(star, constrained);
      if (c.kind == FlipKind::none) continue;
      add_gain(i, c, energy_before(c, energies), candidate_id(t, 4 + edge), proposals, found);
    }
    set_slack(t, found.min_ratio);
    return found.evaluated;
  }

  /// See group_evaluation.hpp.
  static constexpr Kinds kKinds = {4, 6};  ///< faces, edges
  static constexpr int kLists = 2;         ///< rings of three, and larger ones
  struct PerTet {
    std::uint64_t min_ratio;  ///< the bits of a double, which are in the order of positive values
    std::uint8_t closed_faces, max_ring;
  };
  TETUNE_HD Index tet(Size i) const { return active[i]; }
  TETUNE_HD void start(Index t, PerTet& own) const {
    const IsWorse is_worse = worse_than(t);
    const RingBound bound = FlipEnergyLowerBound(mesh.objective).ring_bound(is_worse.energy_t, max_ring);
    own = {bits(initial_ratio(bound)), std::uint8_t(closed_faces(is_worse, mesh.tet2tet[t])),
           std::uint8_t(bound.max_ring)};
  }
  TETUNE_HD int test(Index t, int candidate, PerTet& own) const {
    const IsWorse is_worse = worse_than(t);
    const FlipEnergyLowerBound bound(mesh.objective);
    FlipEvaluation found{kInfeasible};
    int list = kFails;
    if (candidate < 4) {
      if ((own.closed_faces & 1U << candidate) != 0) return kFails;
      const double before = is_worse.energy_t + energies[tet_of(mesh.tet2tet[t][candidate])];
      if (found.may_gain(bound.face_flip(), before)) list = 0;
    } else if ((own.closed_faces & edge_faces(candidate - 4)) == 0) {
      const EdgeStar star = edge_star(mesh, own.max_ring, t, candidate - 4, is_worse);
      if (star.size > 0 && star_may_gain(bound, star, found)) list = star.size == 3 ? 0 : 1;
    }
    lower_ratio(own, found.min_ratio);
    return list;
  }
  TETUNE_HD double evaluate(Index t, int candidate, PerTet& own, FlipCandidate& c, Size& evaluated) const {
    const auto never = [](Index) { return false; };
    c = candidate < 4 ? face_cavity(mesh, t, candidate)
                      : edge_cavity(edge_star(mesh, own.max_ring, t, candidate - 4, never), constrained);
    if (c.kind == FlipKind::none) return 0;
    FlipEvaluation found{kInfeasible};
    const double gain_of_c = gain(c, energy_before(c, energies), found);
    evaluated += found.evaluated;
    lower_ratio(own, found.min_ratio);
    return gain_of_c;
  }
  TETUNE_HD void finish(Index t, const PerTet& own) const {
    double min_ratio = 0;
    std::memcpy(&min_ratio, &own.min_ratio, sizeof min_ratio);
    set_slack(t, min_ratio);
  }

 private:
  TETUNE_HD TETUNE_INLINE IsWorse worse_than(Index t) const { return {energies, t, energies[t]}; }
  TETUNE_HD TETUNE_INLINE static double initial_ratio(const RingBound& bound) {
    return 1 + kMaxSlack < bound.min_ratio ? 1 + kMaxSlack : bound.min_ratio;
  }
  TETUNE_HD TETUNE_INLINE void set_slack(Index t, double min_ratio) const {
    slack[t] = static_cast<float>(min_ratio - 1);
    marks[t] = slack[t] < 0 ? kActive : 0;
  }

  /// The faces of a tetrahedron that are locked, or beyond which an owner lies, as bits.
  TETUNE_HD TETUNE_INLINE static unsigned closed_faces(const IsWorse& is_worse, const FaceAdjacency& links) {
    unsigned closed = 0;
    for (int f = 0; f < 4; ++f) {
      const bool locked = is_locked(links[f]);
      const bool owner_beyond = is_worse(locked ? is_worse.t : tet_of(links[f]));
      closed |= ((locked ? 1U : 0U) | (owner_beyond ? 1U : 0U)) << f;
    }
    return closed;
  }
  TETUNE_HD TETUNE_INLINE bool star_may_gain(const FlipEnergyLowerBound& bound, const EdgeStar& star,
                                             FlipEvaluation& found) const {
    double before = 0;
    for (int m = 0; m < star.size; ++m) before += energies[star.tets[m]];
    return found.may_gain(bound.edge_removal(star.size), before);
  }

  TETUNE_HD static std::uint64_t bits(double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    return bits;
  }
  TETUNE_HD static void lower_ratio(PerTet& own, double ratio) {
    TETUNE_ASSERT(!(ratio < 0));
    if (ratio < kInfeasible) backend::atomic_min(own.min_ratio, bits(ratio));
  }

  /// Finds the best triangulation of a candidate's ring, whose cavity has the energy `before`, and returns its gain; 0:
  /// none.
  TETUNE_HD TETUNE_INLINE double gain(FlipCandidate& c, double before, FlipEvaluation& found) const {
    ++found.evaluated;
    const double after = best_energy<Pack>(mesh, c, before, (1 + kMaxSlack) * before);
    const bool gains = before - after > kMinRelativeGain * before;
    found.add(gains || after > before ? after / before : 1);
    return gains ? before - after : 0;
  }

  TETUNE_HD TETUNE_INLINE void add_gain(Size i, FlipCandidate& c, double before, std::uint32_t id,
                                        const Proposals<FlipCandidate>& proposals, FlipEvaluation& found) const {
    const double gain_of_c = gain(c, before, found);
    if (gain_of_c > 0) proposals.add(i, c, gain_of_c, id);
  }
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "operators/stars/star_proposals.hpp"

namespace tetune {

/// Removes a movable vertex by contracting one of its edges in proposing tetrahedra. The first of these around the
/// vertex proposes on behalf of all.
struct VertexContraction {
  static constexpr int kChoices = 4;
  /// StarContext::is_selective: only vertices of at most this number of tetrahedra are removed. Those of more
  /// contribute less than 1 % of what removal gains (docs/benchmarks/cpu.md, "Proposals for the mean energy").
  static constexpr int kMaxTets = 18;

  template <class Proposal>
  TETUNE_HD static void propose(const Proposal& p, Index t, int corner) {
    if (!p.edits || !p.removes) return;
    const Index v = p.mesh.tet2vertex[t][corner];
    const int max_tets = p.is_selective ? kMaxTets : kMaxStarTets;
    StarCavity star = p.cavity(0);
    if (!p.is_movable(v) || !star.take_vertex(t, corner, max_tets, p.team)) return;
    const Proposers proposers = find_proposers(p, star, p.team);
    if (proposers.lowest < t) return;
    const double above_mean = p.lowers_mean() ? p.energy_above_mean(star) : 0;
    for (int i = 0; i < star.tet_count(); ++i) {
      if (!proposers.has(i)) continue;
      const Tet tet = p.mesh.tet2vertex[star.tet(i)];
      for (int k = 0; k < 4; ++k) {
        if (tet[k] != v && !is_in_earlier(p, star, proposers, i, tet[k])) contract(p, star, above_mean, v, tet[k]);
      }
    }
  }

 private:
  /// Proposing tetrahedra of a cavity, as bits by their positions, and the lowest of their slots.
  struct Proposers {
    std::uint64_t members = 0;
    Index lowest = kNoSlot;
    TETUNE_HD bool has(int i) const { return (members >> i & 1) != 0; }
    TETUNE_HD void merge(const Proposers& other) {
      members |= other.members;
      lowest = other.lowest < lowest ? other.lowest : lowest;
    }
  };
  static_assert(kMaxStarTets <= 64);
  static constexpr Index kNoSlot = 0x7fffffff;

  template <class Team>
  TETUNE_HD static Proposers find_proposers(const StarContext& p, const StarCavity& star, const Team& team) {
    Proposers own;
    for (int i = team.rank(); i < star.tet_count(); i += Team::kSize) {
      if (p.proposes_edits(star.tet(i))) own.merge({std::uint64_t{1} << i, star.tet(i)});
    }
    return team.merge(own);
  }
  /// Whether a proposing tetrahedron of the cavity before position i has the vertex w.
  TETUNE_HD static bool is_in_earlier(const StarContext& p, const StarCavity& star, const Proposers& proposers, int i,
                                      Index w) {
    for (int j = 0; j < i; ++j) {
      if (!proposers.has(j)) continue;
      const Tet tet = p.mesh.tet2vertex[star.tet(j)];
      if (tet[local_index(tet, w)] == w) return true;
    }
    return false;
  }
  template <class Proposal>
  TETUNE_HD static void contract(const Proposal& p, const StarCavity& star, double above_mean, Index v, Index apex) {
    const Vec3 x = vec(p.mesh.points[apex]);
    StarCandidate c = star.candidate(apex, v, x);
    if (p.lowers_mean()) {
      p.add_below_mean(star, above_mean, c);
      return;
    }
    StarCavity grown = p.cavity(1);
    grown.assign(star, p.team);
    if (p.grow(grown, apex, x)) p.add(grown, c);
  }
};

}  // namespace tetune

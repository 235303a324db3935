// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/stars/star_proposals.hpp"

namespace tetune {

/// The best removal of an edge of a tetrahedron with a vertex of its link moved at the same time: a composite operation
/// (Klingner and Shewchuk, "Aggressive tetrahedral mesh improvement", 2007). The moves are tried in turn, each against
/// the best one so far. A backend of many threads evaluates all moves beforehand, one per team (EvaluateMoves); then
/// only the one that the sequence would end with is tried.
struct CompositeRemoval {
  static constexpr int kChoices = 1;
  /// The maximum number of tetrahedra around the edge: with more it hardly ever helps.
  static constexpr int kMaxEdgeTets = 6;
  /// The moves of a tetrahedron: one per edge and vertex of its link.
  static constexpr int kMoves = 6 * kMaxEdgeTets;

  template <class Proposal>
  TETUNE_HD static void propose(const Proposal& p, Index t, int) {
    const int only = p.moves == nullptr ? -1 : chosen_move(p.moves);
    if (only == kMoves) return;
    Move best{p.cavity(2), -1, {}, 0, kAcceptRatio};
    for (int edge = 0; edge < 6; ++edge) {
      if (only >= 0 && only / kMaxEdgeTets != edge) continue;
      StarCavity ring = p.cavity(0);
      if (!take_ring(p, t, edge, ring, p.team)) continue;
      LinkWalk walk(p.mesh, t, edge);
      for (int i = 0; i < ring.tet_count(); ++i) {
        const Index v = walk.next(p.mesh.tet2vertex[ring.tet(i)]);
        if ((only >= 0 && only % kMaxEdgeTets != i) || !p.is_movable(v)) continue;
        try_move(p, ring, v, best);
      }
    }
    if (best.v < 0) return;
    StarCandidate c = best.star.candidate(best.v, kNoVertex, p.lower_cost(best.star, best.x));
    c.is_moved = true;
    p.add(best.star, best.before, c);
  }

  /// The costs of one move of a tetrahedron.
  template <class Team>
  TETUNE_HD static MoveCosts evaluate(const StarContext& p, Index t, int move, StarArrays& arrays, const Team& team) {
    const int edge = move / kMaxEdgeTets;
    StarCavity star(p.mesh, p.constrained, arrays, team);
    if (!take_ring(p, t, edge, star, team) || move % kMaxEdgeTets >= star.tet_count()) return {};
    LinkWalk walk(p.mesh, t, edge);
    Index v = kNoVertex;
    for (int i = 0; i <= move % kMaxEdgeTets; ++i) v = walk.next(p.mesh.tet2vertex[star.tet(i)]);
    if (!p.is_movable(v)) return {};
    Vec3 x;
    return evaluate(p, star, v, x, kAcceptRatio, team);
  }

 private:
  /// A vertex moved so that the cavity can be retriangulated from it.
  struct Move {
    StarCavity star;
    Index v;  ///< -1: none
    Vec3 x;
    double before;
    double ratio;  ///< of the costs after and before
  };
  /// The vertices of the link of an edge in turn.
  class LinkWalk {
   public:
    TETUNE_HD LinkWalk(const MeshView& mesh, Index t, int edge) {
      const EdgeCorners e = edge_corners(edge);
      const Tet tet = mesh.tet2vertex[t];
      from_ = tet[e.i];
      to_ = tet[e.j];
      vertex_ = tet[e.k];
    }
    /// Each tetrahedron has the vertices before and after the face to the next one.
    TETUNE_HD Index next(const Tet& tet) {
      Index v = vertex_;
      for (int k = 0; k < 4; ++k) v = tet[k] != from_ && tet[k] != to_ && tet[k] != vertex_ ? tet[k] : v;
      return vertex_ = v;
    }

   private:
    Index from_, to_, vertex_;
  };

  template <class Team>
  TETUNE_HD static bool take_ring(const StarContext& p, Index t, int edge, StarCavity& ring, const Team& team) {
    return ring.take_edge(t, edge, team) && ring.tet_count() <= kMaxEdgeTets && ring.tet_count() <= p.max_ring &&
           !p.is_proposed_earlier(ring, t);
  }
  /// The move that propose() ends with; kMoves: none.
  TETUNE_HD static int chosen_move(const MoveCosts* moves) {
    int chosen = kMoves;
    double ratio = kAcceptRatio;
    for (int m = 0; m < kMoves; ++m) {
      if (!moves[m].is_below(ratio)) continue;
      chosen = m;
      ratio = moves[m].after / moves[m].before;
    }
    return chosen;
  }
  template <class Proposal>
  TETUNE_HD static void try_move(const Proposal& p, const StarCavity& ring, Index v, Move& best) {
    StarCavity star = p.cavity(1);
    star.assign(ring, p.team);
    Vec3 x;
    const MoveCosts costs = evaluate(p, star, v, x, best.ratio, p.team);
    if (!costs.is_below(best.ratio)) return;
    best.star.assign(star, p.team);
    best.v = v;
    best.x = x;
    best.before = costs.before;
    best.ratio = costs.after / costs.before;
  }
  /// Moves v to x, and enlarges the cavity, as long as the costs are below `ratio`.
  template <class Team>
  TETUNE_HD static MoveCosts evaluate(const StarContext& p, StarCavity& star, Index v, Vec3& x, double ratio,
                                      const Team& team) {
    MoveCosts costs;
    if (!star.take_all_around(v, team)) return costs;
    x = vec(p.mesh.points[v]);
    if (!star.find_kernel_point(x, team)) return costs;
    x = star.relax(x, team);
    costs.first_before = star.cost_before(team);
    costs.first_after = star.cost_after(v, x, costs.screen(ratio), FloorRule::ignored, team);
    if (!(costs.first_after < costs.screen(ratio))) return costs;
    x = star.relax_and_grow(x, team);
    costs.before = star.cost_before(team);
    const double after = star.cost_after(v, x, ratio * costs.before, FloorRule::ignored, team);
    if (after < ratio * costs.before && star.preserves_constraints(v, team)) costs.after = after;
    return costs;
  }
};

/// Evaluates the moves of some tetrahedra.
struct EvaluateMoves {
  static constexpr Size kGrain = 4;
  StarContext context;
  Span<const Index> tets;
  Span<MoveCosts> moves;

  using Shared = StarArrays;

  TETUNE_HD void operator()(Size i) const {
    Shared arrays;
    (*this)(backend::SingleThread(), arrays, i);
  }
  template <class Team>
  TETUNE_HD void operator()(const Team& team, Shared& arrays, Size i) const {
    constexpr int kMoves = CompositeRemoval::kMoves;
    const MoveCosts costs = CompositeRemoval::evaluate(context, tets[i / kMoves], to_index(i % kMoves), arrays, team);
    if (team.rank() == 0) moves[i] = costs;
  }
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/selection.hpp"
#include "operators/star_cavity.hpp"
#include "operators/surface_triangles.hpp"

/// Proposals to retriangulate a cavity from one point, so that the largest cost of its dihedral angles
/// (DihedralCots::cost()) falls.
namespace tetune {

/// The largest cost must fall by this part.
inline constexpr double kMinCostGain = 0.02;
/// A place for an apex is improved further when the cost there is at most this many times what it was.
inline constexpr double kAcceptRatio = 1.5;
/// The bound before the cavity is enlarged.
inline constexpr double kScreenRatio = 2;

/// How often the cavity of a new vertex is enlarged and the vertex moved.
inline constexpr int kOpeningRounds = 3;

/// The data that operators share.
struct StarContext {
  RatedMesh mesh;
  ConstrainedEdges constrained;
  Span<const VertexDof> kind;
  Span<const Vec3> axis;
  SurfaceTriangles surface;
  int max_ring;        ///< of the removal of an edge
  double vertex_cost;  ///< vertices are inserted and removed where an angle has a larger cost
  bool inserts;        ///< vertices may be inserted

  TETUNE_HD bool is_movable(Index v) const { return kind[v] == VertexDof::free && !constrained.has_end(v); }
  TETUNE_HD bool may_change_vertices(Index t) const {
    return dihedral_cots(mesh, t).cost(mesh.obtuse_weight) > vertex_cost;
  }

  TETUNE_HD bool edits_surface() const { return surface.triangles.size() > 0; }
  TETUNE_HD SurfaceBend bend() const { return {mesh.points, surface.triangles}; }
};

/// One choice of an operator, and where it adds the candidate.
struct StarProposal : StarContext {
  Proposals<StarCandidate> proposals;
  Size id;

  /// Moves a new vertex to where the largest cost is lower than before, and enlarges the cavity where it is not.
  /// Returns false where there is no such place.
  TETUNE_HD bool open(StarCavity& star, Vec3& x) const {
    const double before = star.cost_before();
    const double limit = (1 - kMinCostGain) * before;
    const double screen = kAcceptRatio * before;
    if (star.cost_after(kNewVertex, x, screen) < screen) {
      x = star.lower_cost(x);
      if (star.cost_after(kNewVertex, x, limit) < limit) return true;
    }
    for (int round = 0; round < kOpeningRounds; ++round) {
      if (!star.grow_below(kNewVertex, x, limit)) return false;
      x = star.lower_cost(x);
    }
    return true;
  }

  /// Adds a retriangulation where it lowers the largest cost, which is `before`.
  TETUNE_HD void add(const StarCavity& star, double before, const StarCandidate& c) const {
    const double limit = (1 - kMinCostGain) * before;
    const double after = star.cost_after(c.apex, c.apex_position, limit, true);
    if (!(after < limit) || !(before - after > 0)) return;
    proposals.add(id, c, before - after, static_cast<std::uint32_t>(id));
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
struct StarProposals : StarContext {
  using Candidate = StarCandidate;
  static constexpr int kParts = 1;
  static constexpr Size kGrain = 4;
  static constexpr Size kBatch = Size{1} << 12;
  Span<const Index> tets;
  int choices;

  TETUNE_HD Size operator()(Size id, const Proposals<StarCandidate>& proposals) const {
    Operators::propose(StarProposal{*this, proposals, id}, tets[id / choices], static_cast<int>(id % choices));
    return 1;
  }
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "energy/mesh_energy.hpp"
#include "operators/stars/star_cavity.hpp"
#include "operators/stars/surface_bend.hpp"
#include "operators/stars/surface_triangles.hpp"

/// Proposals to retriangulate a cavity from one point, so that the largest cost of its dihedral angles
/// (DihedralCots::cost()) falls, or the mean energy of the mesh.
namespace tetune {

/// An apex position is improved further if its cost is at most this many times the cost before.
inline constexpr double kAcceptRatio = 1.5;
/// Before the cavity is enlarged, the cost may be this many times what it was.
inline constexpr double kScreenRatio = 1.4;

/// Where the cavity cannot be enlarged any further, as at the surface, a new vertex is moved nevertheless if the cost
/// is at most this many times what it was.
inline constexpr double kReachRatio = 4;

/// StarContext::is_selective: a vertex is inserted on edges alone that are longer than this times the distance of the
/// vertices around them from their midpoint (docs/benchmarks/cpu.md, "Proposals for the mean energy").
inline constexpr double kMinStretch = 1.4;

/// The largest costs in a cavity before and after its retriangulation from a vertex that moves.
struct MoveCosts {
  double first_before = 0, first_after = kInfeasible;  ///< before the cavity is enlarged
  double before = 0, after = kInfeasible;              ///< after that; kInfeasible also where a constraint is violated

  /// The bound on `first_after`, where the costs may be at most `ratio` times those before.
  TETUNE_HD double screen(double ratio) const { return kScreenRatio * ratio * first_before; }
  TETUNE_HD bool is_below(double ratio) const { return first_after < screen(ratio) && after < ratio * before; }
};

/// The data that operators share.
struct StarContext {
  RatedMesh mesh;
  ConstrainedEdges constrained;
  Span<const VertexDof> dof;
  Span<const Vec3> axis;
  SurfaceTriangles surface;
  int max_ring;     ///< of the removal of an edge
  double min_gain;  ///< the largest cost, or the energy of the cavity, must fall by this part
  bool inserts;     ///< vertices may be inserted
  bool removes;     ///< vertices may be removed
  /// The proposing tetrahedra in ascending order: an edge of several is removed by the first of them only. Empty: each
  /// proposes all its edges.
  Span<const Index> proposers = {};
  /// Whether each proposer may insert and remove vertices. Empty: all may.
  Span<const std::uint8_t> is_editor = {};
  /// Above 0: the mean energy of the mesh, which must fall, and not the largest cost.
  double mean_energy = 0;
  /// Leaves out proposals that hardly ever lower the mean energy.
  bool is_selective = false;

  TETUNE_HD bool lowers_mean() const { return mean_energy > 0; }
  TETUNE_HD bool is_movable(Index v) const { return dof[v] == VertexDof::free && !constrained.has_end(v); }

  /// Whether vertices may be inserted and removed at a tetrahedron of the cavity before t: that one proposes the same.
  TETUNE_HD bool is_shared_with_earlier(const StarCavity& star, Index t) const {
    return any_earlier(star, t, [&](Index s) { return proposes_edits(s); });
  }
  /// Whether a tetrahedron proposes to insert and remove vertices.
  TETUNE_HD bool proposes_edits(Index t) const {
    const Size i = lower_bound(proposers, t);
    return i < proposers.size() && proposers[i] == t && may_edit(i);
  }
  /// Whether the proposer at a position in the list may insert and remove vertices.
  TETUNE_HD bool may_edit(Size i) const { return is_editor.size() == 0 || is_editor[i] != 0; }
  /// Whether a proposer of the cavity before t contracts an edge to the vertex v too.
  TETUNE_HD bool is_contracted_earlier(const StarCavity& star, Index v, Index t) const {
    return any_earlier(star, t, [&](Index s) {
      const Tet tet = mesh.tet2vertex[s];
      return tet[local_index(tet, v)] == v && proposes_edits(s);
    });
  }

  /// Whether a tetrahedron of an edge's ring before t proposes to remove that edge.
  TETUNE_HD bool is_proposed_earlier(const StarCavity& ring, Index t) const {
    return any_earlier(ring, t, [&](Index s) { return is_proposer(s); });
  }
  TETUNE_HD bool is_proposer(Index t) const { return contains(proposers, t); }

  /// Whether an edge is so long that it may get a vertex (kMinStretch); `star`: all tetrahedra around it.
  TETUNE_HD bool is_long_enough(const StarCavity& star, Index a, Index b) const {
    if (!is_selective) return true;
    const Vec3 along = vec(mesh.points[b]) - vec(mesh.points[a]);
    const Vec3 middle = vec(mesh.points[a]) + 0.5 * along;
    double squares = 0;
    int count = 0;
    for (int i = 0; i < star.face_count(); ++i) {
      for (const Index v : star.face(i).v) {
        if (v == a || v == b) continue;
        const Vec3 d = vec(mesh.points[v]) - middle;
        squares += dot(d, d);
        ++count;
      }
    }
    return count * dot(along, along) > kMinStretch * kMinStretch * squares;
  }

  TETUNE_HD bool edits_surface() const { return surface.triangles.size() > 0; }
  /// The deviation of the surface after an operation: `deviation_of(bend)` for the surface with the present positions,
  /// and with those of the edited surface.
  template <class DeviationOf>
  TETUNE_HD double deviation_after(const DeviationOf& deviation_of) const {
    return surface.limit.largest(mesh.points, [&](Span<const Point> points) {
      return deviation_of(SurfaceBend(points, surface.triangles, surface.limit));
    });
  }

 private:
  /// Whether the predicate holds for a tetrahedron of the cavity before t.
  template <class Predicate>
  TETUNE_HD static bool any_earlier(const StarCavity& star, Index t, const Predicate& holds) {
    for (int i = 0; i < star.tet_count(); ++i) {
      if (star.tet(i) < t && holds(star.tet(i))) return true;
    }
    return false;
  }
};

/// The memory of a team that evaluates a choice of an operator.
struct StarMemory {
  static constexpr int kCavities = 3;
  MinimaxModel model;
  StarArrays arrays[kCavities];
};

/// One choice of an operator, and where it adds the candidate. A team evaluates it.
template <class Team>
struct StarProposal : StarContext {
  Proposals<StarCandidate> proposals;
  Size id;
  bool edits;              ///< the tetrahedron may insert and remove vertices
  const MoveCosts* moves;  ///< the costs of all moves of CompositeRemoval; null: not evaluated
  Team team;
  StarMemory& memory;

  /// An empty cavity, in one of the team's arrays.
  TETUNE_HD StarCavity cavity(int arrays = 0) const { return {mesh, constrained, memory.arrays[arrays], team}; }
  TETUNE_HD double cost_before(const StarCavity& star) const { return star.cost_before(team); }
  TETUNE_HD Vec3 lower_cost(StarCavity& star, const Vec3& x) const { return star.lower_cost(x, memory.model, team); }
  /// Enlarges the cavity until the largest cost is lower than before, where that must fall.
  TETUNE_HD bool grow(StarCavity& star, Index apex, const Vec3& x) const {
    if (lowers_mean()) return true;
    return star.grow_below(apex, x, (1 - min_gain) * cost_before(star), team);
  }

  /// Moves a new vertex to where the largest cost is lower than before. Where there is no such place, enlarges the
  /// cavity and moves the vertex once more. Returns false where that fails too. Where the mean energy must fall, the
  /// vertex is in its place already.
  TETUNE_HD TETUNE_OUTLINE bool place_new_vertex(StarCavity& star, Vec3& x) const {
    if (lowers_mean()) return true;
    const double before = cost_before(star);
    const double limit = (1 - min_gain) * before;
    const double screen = kAcceptRatio * before;
    const bool is_lowest = star.cost_after(kNewVertex, x, screen, FloorRule::ignored, team) < screen;
    if (is_lowest) {
      x = lower_cost(star, x);
      if (star.cost_after(kNewVertex, x, limit, FloorRule::ignored, team) < limit) return true;
    }
    const int tets = star.tet_count();
    const bool is_below = star.grow_below(kNewVertex, x, limit, team);
    // A cavity that has not grown has no lower place.
    if (is_lowest && star.tet_count() == tets) return false;
    if (!is_below && !is_in_reach(star, kReachRatio * before, x)) return false;
    x = lower_cost(star, x);
    return star.cost_after(kNewVertex, x, limit, FloorRule::ignored, team) < limit;
  }

  /// Completes and adds a retriangulation where it lowers the largest cost, or the mean energy, and no tetrahedron is
  /// worse than the floor.
  TETUNE_HD void add(const StarCavity& star, StarCandidate& c) const {
    if (lowers_mean()) {
      add_below_mean(star, energy_above_mean(star), c);
    } else {
      add(star, cost_before(star), c);
    }
  }
  /// Same, where the largest cost is known to be `before`.
  TETUNE_HD TETUNE_OUTLINE void add(const StarCavity& star, double before, StarCandidate& c) const {
    const double limit = (1 - min_gain) * before;
    const double after = star.cost_after(c.apex, c.apex_position, limit, FloorRule::kept, team);
    if (after < limit) add_gain(star, c, before - after);
  }
  /// Same, where the mean energy must fall, and energy_above_mean() is known to be `before`. Retriangulations with more
  /// or fewer tetrahedra compare by the energy beyond the mean of the mesh: where it falls, so does that mean.
  TETUNE_HD TETUNE_OUTLINE void add_below_mean(const StarCavity& star, double before, StarCandidate& c) const {
    const double limit = min_gain * mean_energy * star.tet_count();
    const double gain = energy_gain(star, before, c, limit);
    if (!(gain > limit)) return;
    if (star.cost_after(c.apex, c.apex_position, kInfeasible, FloorRule::kept, team) < kInfeasible)
      add_gain(star, c, gain);
  }
  /// The sum of the energies in the cavity less their mean in the mesh. Not divided among the threads of a team: the
  /// sum would depend on its size.
  TETUNE_HD double energy_above_mean(const StarCavity& star) const {
    double above = 0;
    for (int i = 0; i < star.tet_count(); ++i) {
      above += slot_energy(mesh, mesh.tet2vertex[star.tet(i)]).energy - mean_energy;
    }
    return above;
  }

 private:
  /// By how much energy_above_mean() falls from `before`; not above `limit` where that is not above it.
  TETUNE_HD double energy_gain(const StarCavity& star, double before, const StarCandidate& c, double limit) const {
    double gain = before;
    for (int i = 0; i < star.face_count(); ++i) {
      if (gain + (star.face_count() - i) * (mean_energy - kMinShapeEnergy) <= limit) return gain;
      if (!has_vertex(star.face(i), c.apex)) gain -= star.energy(star.face(i), c.apex_position) - mean_energy;
    }
    return gain;
  }
  TETUNE_HD void add_gain(const StarCavity& star, StarCandidate& c, double gain) const {
    if (!(gain > 0) || team.rank() != 0) return;
    star.list_tets(c);
    proposals.add(id, c, gain, static_cast<std::uint32_t>(id));
  }
  /// Whether the cost with a new vertex at x is below `reach`; otherwise one inside the mesh moves into the kernel.
  TETUNE_HD bool is_in_reach(const StarCavity& star, double reach, Vec3& x) const {
    return star.cost_after(kNewVertex, x, reach, FloorRule::ignored, team) < reach ||
           (star.has_free_apex() && star.find_kernel_point(x, team));
  }
};

/// Operators, each with a number of choices per tetrahedron; propose() is that of the operator that has a choice. Each
/// is a function of its own in the machine code of a GPU, where a thread has memory for one of them at a time.
template <class... Operators>
struct StarOperators;
template <>
struct StarOperators<> {
  static constexpr int kChoices = 0;
  template <class Proposal>
  TETUNE_HD static void propose(const Proposal&, Index, int) {}
};
template <class First, class... Others>
struct StarOperators<First, Others...> {
  static constexpr int kChoices = First::kChoices + StarOperators<Others...>::kChoices;
  template <class Proposal>
  TETUNE_HD static void propose(const Proposal& proposal, Index t, int choice) {
    if (choice < First::kChoices) {
      propose_first(proposal, t, choice);
    } else {
      StarOperators<Others...>::propose(proposal, t, choice - First::kChoices);
    }
  }

 private:
  template <class Proposal>
  TETUNE_HD __attribute__((noinline)) static void propose_first(const Proposal& proposal, Index t, int choice) {
    First::propose(proposal, t, choice);
  }
};

/// Some choices of some tetrahedra.
template <class Operators, class Pack>
struct StarProposals : StarContext {
  using Candidate = StarCandidate;
  static constexpr int kParts = 1;
  static constexpr Size kGrain = 4;
  static constexpr Size kBatch = Size{1} << 12;
  Span<const Index> tets;
  int first_choice, choices;
  Span<const MoveCosts> moves = {};  ///< of all tetrahedra; may be empty

  using Shared = StarMemory;

  /// Few edges per slot, as a contraction makes about four and most proposals are none, but no more than tetrahedra.
  Size edge_slots() const {
    return surface.triangles.size() > 0 ? std::min(16 * tets.size(), mesh.tet2vertex.size()) : 0;
  }

  TETUNE_HD Size operator()(Size id, const Proposals<StarCandidate>& proposals) const {
    StarMemory memory;
    return (*this)(backend::PackThread<Pack>(), memory, id, proposals);
  }
  template <class Team>
  TETUNE_HD Size operator()(const Team& team, StarMemory& memory, Size id,
                            const Proposals<StarCandidate>& proposals) const {
    const MoveCosts* costs = nullptr;
    if (moves.size() > 0) costs = &moves[id / choices * (moves.size() / tets.size())];
    const Size i = id / choices;
    const StarProposal<Team> proposal{*this, proposals, id, may_edit(i), costs, team, memory};
    Operators::propose(proposal, tets[i], first_choice + to_index(id % choices));
    return 1;
  }
};

}  // namespace tetune

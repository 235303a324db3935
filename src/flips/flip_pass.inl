// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "flips/flip_pass.hpp"
#include "flips/least_after.hpp"
#include "flips/offer.hpp"
#include "flips/triangulate.hpp"
#include "par/atomic.hpp"

namespace tetune {
namespace flip_detail {

inline constexpr std::uint32_t kAllCandidates = (1U << kCandidates) - 1;
/// Slack of a tetrahedron that was too good for a look so far: it is due when it no longer is.
inline constexpr float kNeverSeen = -1;
/// Proposal of a slot whose tetrahedron is being flipped away in this pass.
inline constexpr std::uint64_t kFlipped = ~std::uint64_t{0};

TETUNE_HD inline std::uint32_t flip_id(Index t, int candidate) {
  return static_cast<std::uint32_t>(t) * kCandidates + static_cast<std::uint32_t>(candidate);
}
TETUNE_HD inline Index id_tet(std::uint32_t id) { return static_cast<Index>(id / kCandidates); }

/// What flips are found in.
struct Candidates {
  MeshView mesh;
  ConstrainedEdges constrained;
  int max_ring;

  /// Candidates 0 to 3 of a tetrahedron are its faces, 4 to 9 its edges.
  TETUNE_HD Cavity cavity(Index t, int candidate) const {
    return candidate < 4 ? face_cavity(mesh, t, candidate)
                         : edge_cavity(edge_star(mesh, max_ring, t, candidate - 4, Never{}), constrained);
  }
  TETUNE_HD Cavity offered(std::uint64_t proposal) const {
    const std::uint32_t id = offer_id(proposal);
    return cavity(id_tet(id), static_cast<int>(id % kCandidates));
  }
  /// The faces of a tetrahedron that a candidate needs to be free, as bits.
  TETUNE_HD static unsigned faces(int candidate) { return candidate < 4 ? 1U << candidate : edge_faces(candidate - 4); }

  struct Never {
    TETUNE_HD bool operator()(Index) const { return false; }
  };
};

TETUNE_HD inline TetEnergy slot_energy(const MeshView& mesh, const Tet& t) {
  return tet_energy(mesh.law, vec(mesh.points[t[0]]), vec(mesh.points[t[1]]), vec(mesh.points[t[2]]),
                    vec(mesh.points[t[3]]));
}

struct EnergySum {
  double sum = 0;
  TETUNE_HD void merge(const EnergySum& other) { sum += other.sum; }
};

struct RefreshEta {
  MeshView mesh;
  Span<double> eta;
  TETUNE_HD EnergySum operator()(Size t) const {
    eta[t] = mesh.alive(t) ? slot_energy(mesh, mesh.tet2vertex[t]).eta : 0;
    return {eta[t]};
  }
};

struct RefreshEtaOf {
  RefreshEta refresh;
  Span<const Index> slots;
  TETUNE_HD void operator()(Size i) const { refresh(slots[i]); }
};

struct EtaOf {
  Span<const double> eta;
  TETUNE_HD EnergySum operator()(Size t) const { return {eta[t]}; }
};

struct IsWorthALook {
  MeshView mesh;
  LeastAfter bound;
  Span<const double> eta;
  double least;
  TETUNE_HD bool operator()(Size t) const { return mesh.alive(t) && bound.worth_a_look(eta[t]) && eta[t] > least; }
};

/// Computes eta anew, and takes from the slack of a tetrahedron what it has drifted. With q four times the sum of the
/// squared areas and w six times the volume, each height is at least w / sqrt(q), so that no height changes by a larger
/// part.
struct Drift {
  MeshView mesh;
  Span<const Point> seen;
  Span<double> eta;
  Span<float> slack;
  TETUNE_HD EnergySum operator()(Size t) const {
    if (!mesh.alive(t)) return {};
    const Tet tet = mesh.tet2vertex[t];
    const TetEnergy e = slot_energy(mesh, tet);
    eta[t] = e.eta;
    double move2 = 0;
    for (int k = 0; k < 4; ++k) {
      const Vec3 move = vec(mesh.points[tet[k]]) - vec(seen[tet[k]]);
      const double length2 = dot(move, move);
      move2 = length2 > move2 ? length2 : move2;
    }
    slack[t] -= static_cast<float>(drift_rate(mesh.law) * std::sqrt(move2 * e.q) / e.w);
    return {eta[t]};
  }
};

struct HasFlaggedEdge {
  MeshView mesh;
  Span<const std::uint8_t> flags;
  TETUNE_HD bool operator()(Size t) const {
    if (!mesh.alive(t)) return false;
    const Tet tet = mesh.tet2vertex[t];
    return flags[tet[0]] + flags[tet[1]] + flags[tet[2]] + flags[tet[3]] >= 2;
  }
};

struct HasDrifted {
  MeshView mesh;
  LeastAfter bound;
  Span<const double> eta;
  Span<const float> slack;
  TETUNE_HD bool operator()(Size t) const {
    // Slack is not a number where a volume is in doubt.
    return mesh.alive(t) && bound.worth_a_look(eta[t]) && !(slack[t] >= 0);
  }
};

struct WantAll {
  Span<const Index> slots;
  Span<std::uint32_t> wanted;
  TETUNE_HD void operator()(Size i) const { wanted[slots[i]] = kAllCandidates; }
};

struct IsWanted {
  Span<const std::uint32_t> wanted;
  TETUNE_HD bool operator()(Size t) const { return wanted[t] != 0; }
};

TETUNE_HD inline double energy_before(const Cavity& c, Span<const double> eta) {
  double sum = 0;
  for (int k = 0; k < c.size(); ++k) sum += eta[c.tets[k]];
  return sum;
}

struct EvaluatedSum {
  Size evaluated = 0;
  TETUNE_HD void merge(const EvaluatedSum& other) { evaluated += other.evaluated; }
};

/// The order that decides which tetrahedron of a cavity evaluates its flip: the worst, the lowest of equals.
struct Worse {
  Span<const double> eta;
  Index t;
  double eta_t;
  TETUNE_HD bool operator()(Index other) const {
    const double there = eta[other];
    return (there > eta_t) | ((there == eta_t) & (other < t));
  }
};

/// What the loop over the active tetrahedra needs soon: those, their neighbours, and the neighbours of these.
struct FetchAhead {
  MeshView mesh;
  Span<const double> eta;
  Span<const Index> active;

  TETUNE_INLINE void operator()(Size i) const {
    constexpr Size kTetsAhead = 24;
    constexpr Size kNeighboursAhead = 12;
    constexpr Size kFartherAhead = 5;
    if (i + kTetsAhead >= active.size()) return;
    fetch(active[i + kTetsAhead]);
    for_neighbours(active[i + kNeighboursAhead], [this](Index other) { fetch(other); });
    for_neighbours(active[i + kFartherAhead],
                   [this](Index other) { for_neighbours(other, [this](Index farther) { fetch(farther); }); });
  }

 private:
  TETUNE_INLINE void fetch(Index t) const {
    __builtin_prefetch(&mesh.tet2tet[t]);
    __builtin_prefetch(&mesh.tet2vertex[t]);
    __builtin_prefetch(&eta[t]);
  }
  template <class F>
  TETUNE_INLINE void for_neighbours(Index t, const F& f) const {
    const Links links = mesh.tet2tet[t];
    for (int face = 0; face < 4; ++face) f(is_locked(links[face]) ? t : link_tet(links[face]));
  }
};

/// Each candidate is evaluated once, by the worst tetrahedron of its cavity: its owner.
struct Propose {
  Candidates candidates;
  Span<const Index> active;
  Span<const std::uint32_t> wanted;
  Span<const double> eta;
  Span<std::uint64_t> proposal;
  Span<float> slack;

  TETUNE_INLINE void prefetch(Size i) const { FetchAhead{candidates.mesh, eta, active}(i); }

  TETUNE_HD EvaluatedSum operator()(Size i) const {
    const Index t = active[i];
    const MeshView& mesh = candidates.mesh;
    const Links links = mesh.tet2tet[t];
    const Worse worse{eta, t, eta[t]};
    const LeastAfter bound(mesh.law);
    const RingLimit limit = bound.ring_limit(worse.eta_t, candidates.max_ring);
    Look look{1 + kMaxSlack < limit.ratio ? 1 + kMaxSlack : limit.ratio, {}};
    unsigned closed = 0;  // faces that are locked, or beyond which an owner lies
    for (int f = 0; f < 4; ++f) {
      const bool locked = is_locked(links[f]);
      const bool owner_beyond = worse(locked ? t : link_tet(links[f]));
      const unsigned no = (locked ? 1U : 0U) | (owner_beyond ? 1U : 0U);
      closed |= no << f;
    }
    for (int candidate = 0; candidate < kCandidates; ++candidate) {
      if ((wanted[t] >> candidate & 1U) == 0 || (closed & Candidates::faces(candidate)) != 0) continue;
      if (candidate < 4) {
        const double before = worse.eta_t + eta[link_tet(links[candidate])];
        if (look.possible(bound.split(), before)) {
          evaluate(face_cavity(mesh, t, candidate), before, flip_id(t, candidate), look);
        }
      } else {
        const EdgeStar star = edge_star(mesh, limit.ring, t, candidate - 4, worse);
        if (star.size == 0) continue;
        double before = 0;
        for (int m = 0; m < star.size; ++m) before += eta[star.tets[m]];
        if (!look.possible(bound.removal(star.size), before)) continue;
        const Cavity c = edge_cavity(star, candidates.constrained);
        if (c.kind != FlipKind::none) evaluate(c, energy_before(c, eta), flip_id(t, candidate), look);
      }
    }
    const auto now = static_cast<float>(look.least - 1);
    slack[t] = wanted[t] == kAllCandidates || now < slack[t] ? now : slack[t];
    return look.sum;
  }

 private:
  struct Look {
    double least;  ///< of energy after over energy before
    EvaluatedSum sum;
    /// Whether a cavity with this energy may be worth it, when that afterwards is not less than `bound`.
    TETUNE_HD bool possible(double bound, double before) {
      if (!(bound > (1 + kBoundMargin) * before)) return true;
      const double ratio = bound / before;
      least = ratio < least ? ratio : least;
      return false;
    }
  };

  TETUNE_HD TETUNE_INLINE void evaluate(const Cavity& c, double before, std::uint32_t id, Look& look) const {
    ++look.sum.evaluated;
    Triangulation triangulation;
    const double after = best_energy(candidates.mesh, c, before, (1 + kMaxSlack) * before, triangulation);
    const bool better = before - after > kMinRelativeGain * before;
    const double ratio = better || after > before ? after / before : 1;
    look.least = ratio < look.least ? ratio : look.least;
    if (!better) return;
    const std::uint64_t offer = make_offer(before - after, id);
    for (int k = 0; k < c.size(); ++k) par::atomic_max(proposal[c.tets[k]], offer);
  }
};

/// A flip is agreed when all its tetrahedra hold it as their best (Alg. 5, lines 21 to 33). Its evaluator decides.
struct Agreed {
  Candidates candidates;
  Span<const Index> active;
  Span<const std::uint64_t> proposal;
  TETUNE_HD bool operator()(Size i) const {
    const Index t = active[i];
    const std::uint64_t best = proposal[t];
    if (best == 0 || id_tet(offer_id(best)) != t) return false;
    const Cavity c = candidates.offered(best);
    for (int k = 0; k < c.size(); ++k) {
      if (proposal[c.tets[k]] != best) return false;
    }
    return true;
  }
};

/// One agreed flip on its way through the phases.
struct FlipRecord {
  Cavity cavity;
  Triangulation triangulation;
  Index extra[kMaxExtra];     ///< slots it takes
  Link across[2 * kMaxRing];  ///< what lies across the outer faces
  Index twin = -1;            ///< the record of the fan on the other side of the boundary; -1: there is none

  TETUNE_HD int outer_faces() const { return 2 * cavity.sides(); }
  /// Of two twins, whether this is the one that stands for both; `i` is its own place.
  TETUNE_HD bool leads(Size i) const { return twin < 0 || i < twin; }
  /// Slot of new tetrahedron x: those of the old ones are used first.
  TETUNE_HD Index slot(int x) const { return x < cavity.size() ? cavity.tets[x] : extra[x - cavity.size()]; }
  /// Where outer face k is afterwards.
  TETUNE_HD Link new_face(int k) const {
    const int m = k / 2;
    const int side = k % 2;
    if (cavity.kind == FlipKind::face_removal) return make_link(slot(m), side == 0 ? 3 : 0);
    const TriangleSide in = find_ring_edge(cavity, triangulation, m);
    return make_link(slot(2 * in.triangle + side), face_at(in.corner, side));
  }
  /// Reads what lies around the cavity before any tetrahedron changes, and marks its tetrahedra.
  TETUNE_HD void gather(const MeshView& mesh, Span<std::uint64_t> proposal, SlotCounts& counts) {
    for (int k = 0; k < 2 * cavity.ring_size; ++k) across[k] = kNoLink;
    for (int k = 0; k < outer_faces(); ++k) {
      const Link face = old_face(mesh, cavity, triangulation, k);
      across[k] = mesh.tet2tet[link_tet(face)][link_face(face)];
    }
    for (int k = 0; k < cavity.size(); ++k) proposal[cavity.tets[k]] = kFlipped;
    counts = {cavity.size(), cavity.made()};
  }
};

/// Reads all that a flip needs before any tetrahedron changes, and marks its tetrahedra.
struct Gather {
  Candidates candidates;
  Span<const Index> active;
  Span<const Index> agreed;
  Span<const double> eta;
  Span<std::uint64_t> proposal;
  Span<FlipRecord> records;
  Span<SlotCounts> counts;

  TETUNE_HD void operator()(Size i) const {
    const MeshView& mesh = candidates.mesh;
    FlipRecord f{};
    f.cavity = candidates.offered(proposal[active[agreed[i]]]);
    const Cavity& c = f.cavity;
    const double energy = energy_before(c, eta);
    best_energy(mesh, c, energy, (1 + kMaxSlack) * energy, f.triangulation);
    f.gather(mesh, proposal, counts[i]);
    records[i] = f;
  }
};

/// Of the tetrahedra that were active, those stay so that own a flip worth making which was not made.
struct KeepRefused {
  Span<const Index> active;
  Span<const float> slack;
  Span<std::uint32_t> wanted;
  TETUNE_HD void operator()(Size i) const { wanted[active[i]] = slack[active[i]] < 0 ? kAllCandidates : 0; }
};

/// Hands out the slots and leaves, in each outer face of the old tetrahedra, the address of the new one.
struct Forward {
  MeshView mesh;
  Span<FlipRecord> records;
  Span<const SlotCounts> before;  ///< counts of the flips before this one
  Span<const Index> free_slots;
  SlotChange change;
  TETUNE_HD void operator()(Size i) const {
    FlipRecord& f = records[i];
    for (int x = 0; x < f.cavity.made() - f.cavity.size(); ++x) {
      f.extra[x] = change.taken(free_slots, static_cast<Size>(before[i].takes) + x);
    }
    for (int k = 0; k < f.outer_faces(); ++k) {
      const Link old = old_face(mesh, f.cavity, f.triangulation, k);
      mesh.tet2tet[link_tet(old)][link_face(old)] = f.new_face(k);
    }
  }
};

/// Finds what lies across the outer faces now: a neighbour that stayed is told, one that was flipped in this pass as
/// well left its new address.
struct Resolve {
  MeshView mesh;
  Span<FlipRecord> records;
  Span<const std::uint64_t> proposal;
  TETUNE_HD void operator()(Size i) const {
    FlipRecord& f = records[i];
    for (int k = 0; k < f.outer_faces(); ++k) {
      const Link old = f.across[k];
      if (old == kNoLink) continue;
      Link& there = mesh.tet2tet[link_tet(old)][link_face(old)];
      if (proposal[link_tet(old)] == kFlipped) {
        f.across[k] = there | (old & kLocked);
      } else {
        there = f.new_face(k) | (old & kLocked);
      }
    }
    if (f.twin < 0) return;
    const FlipRecord& twin = records[f.twin];
    for (int side = 0; side < 2; ++side) {
      f.across[f.outer_faces() + side] = twin.new_face(twin.outer_faces() + side) | kLocked;
    }
  }
};

struct FlipSum {
  double decrease = 0;
  Size flips23 = 0, flips32 = 0, edge_removals = 0, face_removals = 0, boundary_flips = 0;
  TETUNE_HD void merge(const FlipSum& other) {
    decrease += other.decrease;
    flips23 += other.flips23;
    flips32 += other.flips32;
    edge_removals += other.edge_removals;
    face_removals += other.face_removals;
    boundary_flips += other.boundary_flips;
  }
};

/// Puts the new tetrahedra in place.
struct Write {
  MeshView mesh;
  Span<const FlipRecord> records;
  Span<const SlotCounts> before;
  Span<Index> free_slots;
  Size free_kept;
  Span<double> eta;
  Span<float> slack;
  Span<std::uint32_t> wanted;
  Span<std::uint8_t> awake;

  TETUNE_HD FlipSum operator()(Size i) const {
    const FlipRecord& f = records[i];
    const Cavity& c = f.cavity;
    for (int k = 0; k < c.size(); ++k) wanted[c.tets[k]] = 0;
    const Index original = mesh.tet2original[c.tets[0]];
    const LeastAfter bound(mesh.law);
    double decrease = energy_before(c, eta);
    for (int x = 0; x < c.made(); ++x) {
      const Index s = f.slot(x);
      mesh.tet2vertex[s] = new_tet(c, f.triangulation, x);
      mesh.tet2tet[s] = c.kind == FlipKind::face_removal ? links_at_edge(f, x) : links_on_triangle(f, x);
      if (x >= c.size()) mesh.tet2original[s] = original;
      eta[s] = slot_energy(mesh, mesh.tet2vertex[s]).eta;
      decrease -= eta[s];
      slack[s] = bound.worth_a_look(eta[s]) ? static_cast<float>(kMaxSlack) : kNeverSeen;
    }
    for (int x = c.made(); x < c.size(); ++x) {
      mesh.tet2vertex[c.tets[x]][0] = kFreeSlot;
      eta[c.tets[x]] = 0;
      free_slots[free_kept + before[i].frees + x - c.made()] = c.tets[x];
    }
    if (awake.size() > 0) {
      par::store_shared(awake[c.a], 1);
      par::store_shared(awake[c.b], 1);
      for (int m = 0; m < c.ring_size; ++m) par::store_shared(awake[c.ring[m]], 1);
    }
    const auto is = [&c](FlipKind kind, bool more) { return c.kind == kind && (c.ring_size > 3) == more ? 1 : 0; };
    return {decrease,
            is(FlipKind::face_removal, false),
            is(FlipKind::edge_removal, false),
            is(FlipKind::edge_removal, true),
            is(FlipKind::face_removal, true),
            c.kind == FlipKind::boundary_removal && f.leads(i) ? 1 : 0};
  }

 private:
  TETUNE_HD static Links links_at_edge(const FlipRecord& f, int m) {
    const int before = m > 0 ? m - 1 : f.cavity.ring_size - 1;
    return {
        {f.across[2 * m + 1], make_link(f.slot(f.cavity.after(m)), 2), make_link(f.slot(before), 1), f.across[2 * m]}};
  }
  TETUNE_HD static Links links_on_triangle(const FlipRecord& f, int x) {
    const int s = x / 2;
    const int side = x % 2;
    const std::uint8_t* corner = f.triangulation.corner[s];
    Links links{};
    links[0] = make_link(f.slot(2 * s + 1 - side), 0);
    for (int opposite = 0; opposite < 3; ++opposite) {
      const int from = corner[opposite == 0 ? 1 : 0];
      const int to = corner[opposite == 2 ? 1 : 2];
      Link& link = links[face_at(opposite, side)];
      if (to == from + 1 || to == from + f.cavity.ring_size - 1) {
        link = f.across[2 * (to == from + 1 ? from : to) + side];
      } else {
        const TriangleSide in = find_side(f.cavity, f.triangulation, from, to, s);
        link = make_link(f.slot(2 * in.triangle + side), face_at(in.corner, side));
      }
    }
    return links;
  }
};

/// Makes the owners evaluate all candidates that have a new tetrahedron in their cavity.
struct WantAround {
  Candidates candidates;
  Span<const FlipRecord> records;
  Span<const double> eta;
  double least;
  Span<std::uint32_t> wanted;
  Span<float> slack;
  TETUNE_HD void operator()(Size i) const {
    const MeshView& mesh = candidates.mesh;
    const FlipRecord& f = records[i];
    for (int x = 0; x < f.cavity.made(); ++x) {
      const Index t = f.slot(x);
      const Links links = mesh.tet2tet[t];
      unsigned closed = 0;  // faces that are locked
      for (int face = 0; face < 4; ++face) closed |= is_locked(links[face]) ? 1U << face : 0;
      const unsigned done = seen_before(f, x);
      for (int candidate = 0; candidate < kCandidates; ++candidate) {
        if ((done >> candidate & 1U) == 0 && (closed & Candidates::faces(candidate)) == 0) want(t, candidate);
      }
    }
  }

 private:
  /// The candidates of a new tetrahedron that one before it has as well.
  TETUNE_HD unsigned seen_before(const FlipRecord& f, int x) const {
    const Tet tet = mesh_tet(f, x);
    unsigned seen = 0;
    for (int y = 0; y < x; ++y) {
      const Tet other = mesh_tet(f, y);
      unsigned shared = 0;
      for (int k = 0; k < 4; ++k) {
        unsigned in = 0;
        for (int m = 0; m < 4; ++m) in |= other[m] == tet[k] ? 1U : 0U;
        shared |= in << k;
      }
      for (int candidate = 0; candidate < kCandidates; ++candidate) {
        // A face has the three vertices that are not opposite, an edge those that its two faces lack.
        const unsigned needs = candidate < 4 ? 15U & ~(1U << candidate) : 15U & ~Candidates::faces(candidate);
        if ((shared & needs) == needs) seen |= 1U << candidate;
      }
    }
    return seen;
  }
  TETUNE_HD Tet mesh_tet(const FlipRecord& f, int x) const { return candidates.mesh.tet2vertex[f.slot(x)]; }

  TETUNE_HD void want(Index t, int candidate) const {
    const MeshView& mesh = candidates.mesh;
    Index owner = t;
    if (candidate < 4) {
      const Link link = mesh.tet2tet[t][candidate];
      const bool other = Worse{eta, t, eta[t]}(link_tet(link));
      want_from(other ? link_tet(link) : t, other ? link_face(link) : candidate);
      return;
    }
    const EdgeStar star = edge_star(mesh, candidates.max_ring, t, candidate - 4, Candidates::Never{});
    if (star.size == 0) return;
    for (int m = 1; m < star.size; ++m) owner = Worse{eta, owner, eta[owner]}(star.tets[m]) ? star.tets[m] : owner;
    const Tet tet = mesh.tet2vertex[owner];
    want_from(owner, 4 + edge_of(local_index(tet, star.a), local_index(tet, star.b)));
  }
  TETUNE_HD void want_from(Index owner, int candidate) const {
    if (!LeastAfter(candidates.mesh.law).worth_a_look(eta[owner])) return;
    if (eta[owner] > least) {
      par::atomic_or(wanted[owner], 1U << candidate);
    } else {
      par::store_shared(slack[owner], kNeverSeen);
    }
  }
};

}  // namespace flip_detail

template <class Backend>
double refresh_energy(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state) {
  using namespace flip_detail;
  state.eta.resize(mesh.slots(), mesh.room());
  return par.template reduce<EnergySum>(mesh.slots(), RefreshEta{mesh.view(), state.eta.span()}).sum;
}

template <class Backend>
void refresh_energy_of(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state,
                       Span<const Index> slots) {
  using namespace flip_detail;
  par.for_each(slots.size(), RefreshEtaOf{{mesh.view(), state.eta.span()}, slots});
}

template <class Backend>
double sum_energy(const Backend& par, FlipState<Backend>& state) {
  using namespace flip_detail;
  return par.template reduce<EnergySum>(state.eta.size(), EtaOf{state.eta.span()}).sum;
}

template <class Backend, class Keep>
void activate_where(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state, const Keep& keep,
                    double least = 0) {
  const Size slots = mesh.slots();
  state.least = least;
  state.active.resize(slots, mesh.room());
  state.wanted.resize(slots, mesh.room());
  state.proposal.resize(slots, mesh.room());
  par.fill(state.wanted.span(), std::uint32_t{0});
  const Size count = par.compact(slots, keep, state.active.span());
  state.active.resize(count);
  par.for_each(count, flip_detail::WantAll{state.active.span(), state.wanted.span()});
  state.seen.resize(mesh.vertices());
  Backend::copy(state.seen.span().data(), mesh.points.span().data(),
                static_cast<std::size_t>(mesh.vertices()) * sizeof(Point));
}

template <class Backend>
void activate_all(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state, double least) {
  state.slack.resize(mesh.slots(), mesh.room());
  par.fill(state.slack.span(), flip_detail::kNeverSeen);
  activate_where(par, mesh, state,
                 flip_detail::IsWorthALook{mesh.view(), LeastAfter(mesh.law), state.eta.span(), least}, least);
}

template <class Backend>
double activate_drifted(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state) {
  using namespace flip_detail;
  const EnergySum energy = par.template reduce<EnergySum>(
      mesh.slots(), Drift{mesh.view(), state.seen.span(), state.eta.span(), state.slack.span()});
  activate_where(par, mesh, state, HasDrifted{mesh.view(), LeastAfter(mesh.law), state.eta.span(), state.slack.span()});
  return energy.sum;
}

template <class Backend>
void activate_around(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state,
                     Span<const std::uint8_t> flags) {
  activate_where(par, mesh, state, flip_detail::HasFlaggedEdge{mesh.view(), flags});
}

namespace flip_detail {

/// Carries out agreed flips: `before` holds what each takes and frees. What is made is active afterwards.
template <class Backend>
FlipSum apply_flips(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state,
                    typename Backend::template Buffer<FlipRecord>& records,
                    typename Backend::template Buffer<SlotCounts>& before, Span<std::uint8_t> awake) {
  const SlotCounts counts = par.exclusive_scan(Span<const SlotCounts>(before.span()), before.span());
  const SlotChange change(mesh, counts);
  check_slots(change.needed);
  change.make_room(mesh);
  state.eta.grow(change.needed);
  state.proposal.grow(change.needed);
  state.wanted.grow(change.needed);
  par.fill(Span<std::uint32_t>(state.wanted.span().data() + change.slots, change.needed - change.slots),
           std::uint32_t{0});
  state.slack.grow(change.needed);

  par.for_each(records.size(), Forward{mesh.view(), records.span(), before.span(), mesh.free_slots.span(), change});
  par.for_each(records.size(), Resolve{mesh.view(), records.span(), state.proposal.span()});
  const FlipSum sum = par.template reduce<FlipSum>(
      records.size(), Write{mesh.view(), records.span(), before.span(), mesh.free_slots.span(), change.free_kept,
                            state.eta.span(), state.slack.span(), state.wanted.span(), awake});
  change.finish(mesh);

  par.for_each(records.size(), WantAround{{mesh.view(), state.constrained(), state.max_ring}, records.span(),
                                          state.eta.span(), state.least, state.wanted.span(), state.slack.span()});
  state.active.resize(change.needed);
  state.active.resize(par.compact(change.needed, IsWanted{state.wanted.span()}, state.active.span()));
  return sum;
}

}  // namespace flip_detail

/// Proposals between two looks whether a stop is requested: about a tenth of a second of one core.
inline constexpr Size kProposeAtOnce = 1 << 16;

template <class Backend>
FlipReport flip_pass(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state, Span<std::uint8_t> awake) {
  using namespace flip_detail;
  using Ids = typename Backend::template Buffer<Index>;
  FlipReport report;
  const Candidates candidates{mesh.view(), state.constrained(), state.max_ring};
  const Size active = state.active.size();
  report.active = active;
  par.fill(state.proposal.span(), std::uint64_t{0});
  for (Size first = 0; first < active; first += kProposeAtOnce) {
    if (par.stop_requested()) return report;
    const Span<const Index> some(state.active.span().data() + first, std::min(kProposeAtOnce, active - first));
    report.evaluated +=
        par.template reduce<EvaluatedSum>(some.size(), Propose{candidates, some, state.wanted.span(), state.eta.span(),
                                                               state.proposal.span(), state.slack.span()})
            .evaluated;
  }

  Ids agreed(active);
  const Size flips = par.compact(active, Agreed{candidates, state.active.span(), state.proposal.span()}, agreed.span());
  typename Backend::template Buffer<FlipRecord> records(flips);
  typename Backend::template Buffer<SlotCounts> before(flips);
  par.for_each(flips, Gather{candidates, state.active.span(), agreed.span(), state.eta.span(), state.proposal.span(),
                             records.span(), before.span()});
  par.for_each(active, KeepRefused{state.active.span(), state.slack.span(), state.wanted.span()});

  const FlipSum sum = apply_flips(par, mesh, state, records, before, awake);
  report.flips23 = sum.flips23;
  report.flips32 = sum.flips32;
  report.edge_removals = sum.edge_removals;
  report.decrease = sum.decrease;
  return report;
}

}  // namespace tetune

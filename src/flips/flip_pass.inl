// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "flips/active_set.inl"
#include "flips/apply_flips.inl"
#include "flips/candidates.hpp"

namespace tetune {
namespace flip_detail {

/// Each candidate is evaluated once, by the worst tetrahedron of its cavity: its owner.
struct Propose {
  static constexpr Size kGrain = 32;
  Candidates candidates;
  Span<const Index> active;
  Span<const double> energies;
  Span<std::uint64_t> proposal;
  Span<float> slack;

  TETUNE_INLINE void prefetch(Size i, Size) const { FetchAhead{candidates.mesh, energies, active}(i); }

  TETUNE_HD EvaluatedSum operator()(Size i) const {
    const Index t = active[i];
    const MeshView& mesh = candidates.mesh;
    const Links links = mesh.tet2tet[t];
    const Worse worse{energies, t, energies[t]};
    const LeastAfter bound(mesh.law);
    const RingLimit limit = bound.ring_limit(worse.energy_t, candidates.max_ring);
    Look look{1 + kMaxSlack < limit.ratio ? 1 + kMaxSlack : limit.ratio, {}};
    unsigned closed = 0;  // faces that are locked, or beyond which an owner lies
    for (int f = 0; f < 4; ++f) {
      const bool locked = is_locked(links[f]);
      const bool owner_beyond = worse(locked ? t : link_tet(links[f]));
      const unsigned no = (locked ? 1U : 0U) | (owner_beyond ? 1U : 0U);
      closed |= no << f;
    }
    for (int candidate = 0; candidate < kCandidates; ++candidate) {
      if ((closed & Candidates::faces(candidate)) != 0) continue;
      if (candidate < 4) {
        const double before = worse.energy_t + energies[link_tet(links[candidate])];
        if (look.possible(bound.split(), before)) {
          evaluate(face_cavity(mesh, t, candidate), before, flip_id(t, candidate), look);
        }
      } else {
        const EdgeStar star = edge_star(mesh, limit.ring, t, candidate - 4, worse);
        if (star.size == 0) continue;
        double before = 0;
        for (int m = 0; m < star.size; ++m) before += energies[star.tets[m]];
        if (!look.possible(bound.removal(star.size), before)) continue;
        const Cavity c = edge_cavity(star, candidates.constrained);
        if (c.kind != FlipKind::none) evaluate(c, energy_before(c, energies), flip_id(t, candidate), look);
      }
    }
    slack[t] = static_cast<float>(look.least - 1);
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
    offer_to(c.tets, c.size(), make_offer(before - after, id), proposal);
  }
};

/// The tetrahedra whose best offer is their own and agreed.
struct Agreed {
  Candidates candidates;
  Span<const Index> active;
  Span<const std::uint64_t> proposal;
  TETUNE_HD bool operator()(Size i) const {
    const Index t = active[i];
    const std::uint64_t best = proposal[t];
    if (best == 0 || id_tet(offer_id(best)) != t) return false;
    const Cavity c = candidates.offered(best);
    return all_hold(c.tets, c.size(), best, proposal);
  }
};

/// Reads all that a flip needs before any tetrahedron changes, and marks its tetrahedra.
struct Gather {
  static constexpr Size kGrain = 32;
  Candidates candidates;
  Span<const Index> active;
  Span<const Index> agreed;
  Span<const double> energies;
  Span<std::uint64_t> proposal;
  Span<FlipRecord> records;
  Span<SlotCounts> counts;

  TETUNE_HD void operator()(Size i) const {
    const MeshView& mesh = candidates.mesh;
    FlipRecord f{};
    f.cavity = candidates.offered(proposal[active[agreed[i]]]);
    const Cavity& c = f.cavity;
    const double energy = energy_before(c, energies);
    best_energy(mesh, c, energy, (1 + kMaxSlack) * energy, f.triangulation);
    f.gather(mesh, proposal, counts[i]);
    records[i] = f;
  }
};

/// Of the tetrahedra that were active, those stay so that own a flip worth making which was not made.
struct KeepRefused {
  Span<const Index> active;
  Span<const float> slack;
  Span<std::uint8_t> wanted;
  TETUNE_HD void operator()(Size i) const { wanted[active[i]] = slack[active[i]] < 0 ? kWanted : 0; }
};

}  // namespace flip_detail

template <class Backend>
FlipReport flip_pass(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state, Span<std::uint8_t> awake) {
  using namespace flip_detail;
  using Ids = typename Backend::template Buffer<Index>;
  FlipReport report;
  const Candidates candidates{mesh.view(), state.constrained(), state.max_ring};
  const Span<const Index> active = state.active.span();
  report.active = active.size();
  par.fill(state.proposal.span(), std::uint64_t{0});
  const auto propose = [&](Span<const Index> part) {
    return Propose{candidates, part, state.energies.span(), state.proposal.span(), state.slack.span()};
  };
  if (!propose_all(par, active, propose, report)) return report;

  Ids agreed(active.size());
  const Size flips = par.compact(active.size(), Agreed{candidates, active, state.proposal.span()}, agreed.span());
  typename Backend::template Buffer<FlipRecord> records(flips);
  typename Backend::template Buffer<SlotCounts> before(flips);
  par.for_each(flips, Gather{candidates, active, agreed.span(), state.energies.span(), state.proposal.span(),
                             records.span(), before.span()});
  par.for_each(active.size(), KeepRefused{active, state.slack.span(), state.wanted.span()});

  const FlipSum sum = apply_flips(par, mesh, state, records, before, awake);
  report.flips23 = sum.flips23;
  report.flips32 = sum.flips32;
  report.edge_removals = sum.edge_removals;
  report.decrease = sum.decrease;
  return report;
}

}  // namespace tetune

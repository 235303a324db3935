// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/slot_pack.hpp"
#include "operators/engine/active_set.hpp"

namespace tetune {
namespace active_set_detail {

/// Computes the energies again, and subtracts from the slack of each tetrahedron what it has drifted. With q four times
/// the sum of the squared areas and w six times the volume, each height is at least w / sqrt(q), so that no height
/// changes by a larger part.
template <class Pack>
struct SubtractDrift {
  RatedMesh mesh;
  Span<const Point> origin;
  Span<double> energies;
  Span<float> slack;
  TETUNE_HD Sum<double> operator()(Size pack) const {
    const SlotPack<Pack> slots(mesh, pack);
    const TetEnergyT<Pack> e = slots.energy();
    Pack move2{};
    for (int k = 0; k < 4; ++k) {
      const Vec3T<Pack> move = slots.corner(k, mesh.points) - slots.corner(k, origin);
      const Pack length2 = dot(move, move);
      move2 = length2 > move2 ? length2 : move2;
    }
    const Pack moved = move2 * e.q;
    const Pack drift = drift_rate(mesh.objective) * square_root(moved) / e.w;
    slots.for_each([&](Size slot, int l) { slack[slot] -= static_cast<float>(lane(drift, l)); });
    return slots.store_and_sum(e.energy, energies);
  }
};

/// Whether a tetrahedron is evaluated at all. Free slots, of energy 0, are not.
struct IsPromising {
  FlipEnergyLowerBound bound;
  Span<const double> energies;
  double min_energy;
  TETUNE_HD bool operator()(Size t) const { return bound.may_gain(energies[t]) && energies[t] > min_energy; }
};

struct HasDrifted {
  IsPromising is_promising;
  Span<const float> slack;
  TETUNE_HD bool operator()(Size t) const {
    // Slack may be NaN where a volume is not certified.
    return is_promising(t) && !(slack[t] >= 0);
  }
};

struct HasFlaggedEdge {
  MeshView mesh;
  Span<const std::uint8_t> flags;
  TETUNE_HD bool operator()(Size t) const {
    if (!mesh.alive(t)) return false;
    const Tet tet = mesh.tet2vertex[t];
    int flagged = 0;
    for (int k = 0; k < 4; ++k) flagged += flags[tet[k]] != 0 ? 1 : 0;
    return flagged >= 2;
  }
};

/// Marks the tetrahedra for which a predicate holds, and no others. Clears the bids.
template <class Predicate>
struct MarkActive {
  Predicate predicate;
  Span<std::uint8_t> marks;
  Span<std::uint64_t> tet2bid;
  TETUNE_HD bool operator()(Size t) const {
    const bool is_active = predicate(t);
    marks[t] = is_active ? kActive : 0;
    tet2bid[t] = 0;
    return is_active;
  }
};

/// Whether a tetrahedron is marked; resolves kActiveIfPromising to kActive or 0. Clears the bids.
struct ResolveMark {
  Span<std::uint8_t> marks;
  Span<std::uint64_t> tet2bid;
  IsPromising is_promising;
  TETUNE_HD bool operator()(Size t) const {
    tet2bid[t] = 0;
    if (marks[t] == kActiveIfPromising) marks[t] = is_promising(t) ? kActive : 0;
    return marks[t] != 0;
  }
};

template <class Backend>
IsPromising is_promising(const Criterion& criterion, FlipState<Backend>& state) {
  return {FlipEnergyLowerBound(criterion.objective), state.energies.span(), state.min_energy};
}

/// Makes the tetrahedra active for which a predicate over the slots holds.
template <class Backend, class Predicate>
void activate_where(const Backend& backend, WorkMesh<Backend>& mesh, FlipState<Backend>& state,
                    const Predicate& predicate) {
  const Size slots = mesh.slots();
  state.active.resize(backend, slots, mesh.room());
  state.marks.resize(backend, slots, mesh.room());
  state.tet2bid.resize(backend, slots, mesh.room());
  const MarkActive<Predicate> mark{predicate, state.marks.span(), state.tet2bid.span()};
  state.active.resize(backend, backend.compact(slots, mark, state.active.span()));
  state.bids_are_clear = true;
  state.drift_origin.assign(backend, mesh.points);
}

}  // namespace active_set_detail

template <class Backend>
void activate_all(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                  FlipState<Backend>& state, double min_energy) {
  using namespace active_set_detail;
  state.min_energy = min_energy;
  reset_slack(backend, mesh, state);
  activate_where(backend, mesh, state, is_promising(criterion, state));
}

template <class Backend>
double activate_drifted(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                        FlipState<Backend>& state, double min_energy) {
  using namespace active_set_detail;
  using Pack = typename Backend::Pack;
  state.min_energy = min_energy;
  const auto energy = backend.template reduce_async<Sum<double>>(
      SlotPack<Pack>::pack_count(mesh.slots()), SubtractDrift<Pack>{rated(mesh, criterion), state.drift_origin.span(),
                                                                    state.energies.span(), state.slack.span()});
  activate_where(backend, mesh, state, HasDrifted{is_promising(criterion, state), state.slack.span()});
  return energy.get().value;
}

template <class Backend>
void activate_around(const Backend& backend, WorkMesh<Backend>& mesh, FlipState<Backend>& state,
                     Span<const std::uint8_t> flags) {
  state.min_energy = 0;
  active_set_detail::activate_where(backend, mesh, state, active_set_detail::HasFlaggedEdge{mesh.view(), flags});
}

template <class Backend>
void activate_marked(const Backend& backend, const Criterion& criterion, FlipState<Backend>& state) {
  using namespace active_set_detail;
  const Size slots = state.marks.size();
  const ResolveMark is_marked{state.marks.span(), state.tet2bid.span(), is_promising(criterion, state)};
  state.active.resize(backend, slots);
  state.active.resize(backend, backend.compact(slots, is_marked, state.active.span()));
  state.bids_are_clear = true;
}

}  // namespace tetune

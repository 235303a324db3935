// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "core/gather.hpp"
#include "flips/candidates.hpp"
#include "flips/least_after.hpp"

/// Energies of the slots, and the set of tetrahedra that look for flips.
namespace tetune {
namespace flip_detail {

struct EnergySum {
  double sum = 0;
  TETUNE_HD void merge(const EnergySum& other) { sum += other.sum; }
};

/// Some slots in a row, and their vertices, one slot a lane. Beyond the last slot, and of free ones, anything.
template <class Pack>
class SlotPack {
 public:
  TETUNE_HD TETUNE_INLINE SlotPack(const MeshView& mesh, Size pack)
      : mesh_(mesh),
        first_(kLanes * pack),
        count_(mesh.tet2vertex.size() - first_ < kLanes ? static_cast<int>(mesh.tet2vertex.size() - first_) : kLanes) {
    for (int l = 0; l < kLanes; ++l) {
      const Tet tet = mesh.tet2vertex[first_ + (l < count_ ? l : 0)];
      alive_[l] = tet[0] != kFreeSlot;
      for (int k = 0; k < 4; ++k) ids_[k][l] = alive_[l] ? tet[k] : 0;
    }
  }
  TETUNE_HD TETUNE_INLINE static Size packs(Size slots) { return (slots + kLanes - 1) / kLanes; }

  TETUNE_HD TETUNE_INLINE Vec3T<Pack> corner(int k, Span<const Point> points) const {
    return gather<Pack>(points, ids_[k]);
  }
  TETUNE_HD TETUNE_INLINE TetEnergyT<Pack> energy() const {
    return tet_energy(mesh_.law, corner(0, mesh_.points), corner(1, mesh_.points), corner(2, mesh_.points),
                      corner(3, mesh_.points));
  }
  /// Stores what the slots have of it, 0 for free ones, and sums it up.
  TETUNE_HD TETUNE_INLINE EnergySum put(const Pack& values, Span<double> to) const {
    EnergySum total;
    for_each([&](Size slot, int l) {
      to[slot] = alive_[l] ? lane(values, l) : 0;
      total.merge({to[slot]});
    });
    return total;
  }
  /// f(slot, lane)
  template <class F>
  TETUNE_HD TETUNE_INLINE void for_each(const F& f) const {
    for (int l = 0; l < count_; ++l) f(first_ + l, l);
  }

 private:
  static constexpr int kLanes = kLanesOf<Pack>;
  const MeshView& mesh_;
  Size first_;
  int count_;
  bool alive_[kLanes];
  Index ids_[4][kLanes];
};

struct RefreshEnergy {
  MeshView mesh;
  Span<double> energies;
  TETUNE_HD EnergySum operator()(Size pack) const {
    const SlotPack<par::Pack> slots(mesh, pack);
    return slots.put(slots.energy().energy, energies);
  }
};

struct RefreshEnergyOf {
  MeshView mesh;
  Span<double> energies;
  Span<const Index> slots;
  TETUNE_HD void operator()(Size i) const {
    const Index t = slots[i];
    energies[t] = mesh.alive(t) ? slot_energy(mesh, mesh.tet2vertex[t]).energy : 0;
  }
};

struct EnergyOf {
  Span<const double> energies;
  TETUNE_HD EnergySum operator()(Size t) const { return {energies[t]}; }
};

/// Computes energies anew, and takes from the slack of a tetrahedron what it has drifted. With q four times the sum of
/// the squared areas and w six times the volume, each height is at least w / sqrt(q), so that no height changes by a
/// larger part.
struct Drift {
  MeshView mesh;
  Span<const Point> seen;
  Span<double> energies;
  Span<float> slack;
  TETUNE_HD EnergySum operator()(Size pack) const {
    using Pack = par::Pack;
    const SlotPack<Pack> slots(mesh, pack);
    const TetEnergyT<Pack> e = slots.energy();
    Pack move2{};
    for (int k = 0; k < 4; ++k) {
      const Vec3T<Pack> move = slots.corner(k, mesh.points) - slots.corner(k, seen);
      const Pack length2 = dot(move, move);
      move2 = length2 > move2 ? length2 : move2;
    }
    const Pack moved = move2 * e.q;
    const Pack drift = drift_rate(mesh.law) * square_root(moved) / e.w;
    slots.for_each([&](Size slot, int l) { slack[slot] -= static_cast<float>(lane(drift, l)); });
    return slots.put(e.energy, energies);
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

struct HasDrifted {
  IsWorthALook worth;
  Span<const float> slack;
  TETUNE_HD bool operator()(Size t) const {
    // Slack is not a number where a volume is in doubt.
    return worth(t) && !(slack[t] >= 0);
  }
};

struct Want {
  Span<const Index> slots;
  Span<std::uint8_t> wanted;
  TETUNE_HD void operator()(Size i) const { wanted[slots[i]] = kWanted; }
};

}  // namespace flip_detail

template <class Backend>
double refresh_energy(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state) {
  using namespace flip_detail;
  state.energies.resize(mesh.slots(), mesh.room());
  return par
      .template reduce<EnergySum>(SlotPack<par::Pack>::packs(mesh.slots()),
                                  RefreshEnergy{mesh.view(), state.energies.span()})
      .sum;
}

template <class Backend>
void refresh_energy_of(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state,
                       Span<const Index> slots) {
  using namespace flip_detail;
  par.for_each(slots.size(), RefreshEnergyOf{mesh.view(), state.energies.span(), slots});
}

template <class Backend>
double sum_energy(const Backend& par, FlipState<Backend>& state) {
  using namespace flip_detail;
  return par.template reduce<EnergySum>(state.energies.size(), EnergyOf{state.energies.span()}).sum;
}

template <class Backend, class Keep>
void activate_where(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state, const Keep& keep,
                    double least = 0) {
  const Size slots = mesh.slots();
  state.least = least;
  state.active.resize(slots, mesh.room());
  state.wanted.resize(slots, mesh.room());
  state.proposal.resize(slots, mesh.room());
  par.fill(state.wanted.span(), std::uint8_t{0});
  const Size count = par.compact(slots, keep, state.active.span());
  state.active.resize(count);
  par.for_each(count, flip_detail::Want{state.active.span(), state.wanted.span()});
  state.seen.assign(mesh.points);
}

template <class Backend>
void activate_all(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state, double least) {
  state.slack.resize(mesh.slots(), mesh.room());
  par.fill(state.slack.span(), flip_detail::kNeverSeen);
  activate_where(par, mesh, state, flip_detail::IsWorthALook{LeastAfter(mesh.law), state.energies.span(), least},
                 least);
}

template <class Backend>
double activate_drifted(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state, double least) {
  using namespace flip_detail;
  const EnergySum energy =
      par.template reduce<EnergySum>(SlotPack<par::Pack>::packs(mesh.slots()),
                                     Drift{mesh.view(), state.seen.span(), state.energies.span(), state.slack.span()});
  const IsWorthALook worth{LeastAfter(mesh.law), state.energies.span(), least};
  activate_where(par, mesh, state, HasDrifted{worth, state.slack.span()}, least);
  return energy.sum;
}

template <class Backend>
void activate_around(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state,
                     Span<const std::uint8_t> flags) {
  activate_where(par, mesh, state, flip_detail::HasFlaggedEdge{mesh.view(), flags});
}

}  // namespace tetune

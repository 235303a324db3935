// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "flips/candidates.hpp"
#include "flips/least_after.hpp"
#include "flips/triangulate.hpp"
#include "par/atomic.hpp"

/// Agreed flips of every kind are carried out in place.
namespace tetune {
namespace flip_detail {

/// Proposal of a slot whose tetrahedron is being flipped away in this pass.
inline constexpr std::uint64_t kFlipped = ~std::uint64_t{0};

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

/// Records so many ahead have what they need fetched: their cavities lie anywhere in memory.
inline constexpr Size kRecordsAhead = 6;

/// Hands out the slots and leaves, in each outer face of the old tetrahedra, the address of the new one.
struct Forward {
  static constexpr Size kGrain = 32;
  MeshView mesh;
  Span<FlipRecord> records;
  Span<const SlotCounts> before;  ///< counts of the flips before this one
  Span<const Index> free_slots;
  SlotChange change;
  TETUNE_INLINE void prefetch(Size i, Size) const {
    if (i + kRecordsAhead >= records.size()) return;
    const Cavity& c = records[i + kRecordsAhead].cavity;
    for (int k = 0; k < c.size(); ++k) par::prefetch(&mesh.tet2tet[c.tets[k]]);
  }
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
  static constexpr Size kGrain = 32;
  MeshView mesh;
  Span<FlipRecord> records;
  Span<const std::uint64_t> proposal;
  /// Records from `end` on are another thread's.
  TETUNE_INLINE void prefetch(Size i, Size end) const {
    if (i + kRecordsAhead >= end) return;
    const FlipRecord& f = records[i + kRecordsAhead];
    for (int k = 0; k < f.outer_faces(); ++k) {
      const Index t = f.across[k] == kNoLink ? 0 : link_tet(f.across[k]);
      par::prefetch(&proposal[t]);
      par::prefetch(&mesh.tet2tet[t]);
    }
  }
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
  static constexpr Size kGrain = 32;
  MeshView mesh;
  Span<const FlipRecord> records;
  Span<const SlotCounts> before;
  Span<Index> free_slots;
  Size free_kept;
  Span<double> energies;
  Span<std::uint8_t> wanted;
  Span<std::uint8_t> awake;

  TETUNE_INLINE void prefetch(Size i, Size) const {
    if (i + kRecordsAhead >= records.size()) return;
    const Cavity& c = records[i + kRecordsAhead].cavity;
    for (int k = 0; k < c.size(); ++k) fetch_tet(mesh, energies, c.tets[k]);
    par::prefetch(&mesh.tet2original[c.tets[0]]);
    par::prefetch(&mesh.points[c.a]);
    par::prefetch(&mesh.points[c.b]);
    for (int m = 0; m < c.ring_size; ++m) par::prefetch(&mesh.points[c.ring[m]]);
  }
  TETUNE_HD FlipSum operator()(Size i) const {
    const FlipRecord& f = records[i];
    const Cavity& c = f.cavity;
    for (int k = 0; k < c.size(); ++k) wanted[c.tets[k]] = 0;
    const Index original = mesh.tet2original[c.tets[0]];
    double decrease = energy_before(c, energies);
    for (int x = 0; x < c.made(); ++x) {
      const Index s = f.slot(x);
      mesh.tet2vertex[s] = new_tet(c, f.triangulation, x);
      mesh.tet2tet[s] = c.kind == FlipKind::face_removal ? links_at_edge(f, x) : links_on_triangle(f, x);
      if (x >= c.size()) mesh.tet2original[s] = original;
      energies[s] = slot_energy(mesh, mesh.tet2vertex[s]).energy;
      decrease -= energies[s];
    }
    for (int x = c.made(); x < c.size(); ++x) {
      mesh.tet2vertex[c.tets[x]][0] = kFreeSlot;
      energies[c.tets[x]] = 0;
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

/// Has the new tetrahedra look for flips, and those beside them: of the candidates whose cavity has changed, few have
/// an owner that lies farther away.
struct WantNear {
  Span<const FlipRecord> records;
  Span<std::uint8_t> wanted;
  Span<float> slack;
  TETUNE_HD void operator()(Size i) const {
    const FlipRecord& f = records[i];
    for (int x = 0; x < f.cavity.made(); ++x) want(f.slot(x));
    for (int k = 0; k < f.outer_faces(); ++k) {
      if (!is_locked(f.across[k])) want(link_tet(f.across[k]));
    }
  }

 private:
  /// Those that look anyway go on, worth it or not.
  TETUNE_HD void want(Index t) const {
    if (par::load_shared(wanted[t]) == 0) par::store_shared(wanted[t], kWantedIfWorth);
    par::store_shared(slack[t], kNeverSeen);
  }
};

/// Decides who looks if it is worth it, eight slots at a time, as in most there is nothing to decide.
struct SettleWanted {
  static constexpr Size kSlots = 8;
  Span<std::uint8_t> wanted;
  IsWorthALook worth;
  TETUNE_HD void operator()(Size i) const {
    const Size first = kSlots * i;
    const Size count = wanted.size() - first < kSlots ? wanted.size() - first : kSlots;
    unsigned any = 0;
    for (Size k = 0; k < count; ++k) any |= wanted[first + k];
    for (Size t = first; any != 0 && t < first + count; ++t) {
      if (wanted[t] == kWantedIfWorth) wanted[t] = worth(t) ? kWanted : 0;
    }
  }
};

struct IsWanted {
  Span<const std::uint8_t> wanted;
  TETUNE_HD bool operator()(Size t) const { return wanted[t] != 0; }
};

/// Carries out agreed flips: `before` holds what each takes and frees. What is made is active afterwards.
template <class Backend>
FlipSum apply_flips(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state,
                    typename Backend::template Buffer<FlipRecord>& records,
                    typename Backend::template Buffer<SlotCounts>& before, Span<std::uint8_t> awake) {
  const SlotCounts counts = par.exclusive_scan(Span<const SlotCounts>(before.span()), before.span());
  const SlotChange change(mesh, counts);
  check_slots(change.needed);
  change.make_room(mesh);
  state.energies.grow(change.needed);
  state.proposal.grow(change.needed);
  state.wanted.grow(change.needed);
  par.fill(Span<std::uint8_t>(state.wanted.span().data() + change.slots, change.needed - change.slots),
           std::uint8_t{0});
  state.slack.grow(change.needed);

  par.for_each(records.size(), Forward{mesh.view(), records.span(), before.span(), mesh.free_slots.span(), change});
  par.for_each(records.size(), Resolve{mesh.view(), records.span(), state.proposal.span()});
  const FlipSum sum = par.template reduce<FlipSum>(
      records.size(), Write{mesh.view(), records.span(), before.span(), mesh.free_slots.span(), change.free_kept,
                            state.energies.span(), state.wanted.span(), awake});
  change.finish(mesh);

  par.for_each(records.size(), WantNear{records.span(), state.wanted.span(), state.slack.span()});
  const IsWorthALook worth{LeastAfter(mesh.law), state.energies.span(), state.least};
  par.for_each((change.needed + SettleWanted::kSlots - 1) / SettleWanted::kSlots,
               SettleWanted{state.wanted.span(), worth});
  state.active.resize(change.needed);
  state.active.resize(par.compact(change.needed, IsWanted{state.wanted.span()}, state.active.span()));
  return sum;
}

}  // namespace flip_detail
}  // namespace tetune

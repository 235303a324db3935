// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstring>

#include "flips/flip_pass.hpp"
#include "par/atomic.hpp"

namespace tetune {
namespace flip_detail {

/// Candidates of one tetrahedron: four faces, six edges.
inline constexpr std::uint32_t kCandidates = 10;
/// Proposal of a slot whose tetrahedron is being flipped away in this pass.
inline constexpr std::uint64_t kFlipped = ~std::uint64_t{0};

/// Orders flips by gain, then by id: the lower id wins. The gain is rounded to single precision, so that flips which
/// are equally good but for round-off count as equal.
TETUNE_HD inline std::uint64_t make_proposal(double gain, std::uint32_t id) {
  const auto rounded = static_cast<float>(gain);
  std::uint32_t bits = 0;
  static_assert(sizeof bits == sizeof rounded);
  std::memcpy(&bits, &rounded, sizeof bits);
  return (static_cast<std::uint64_t>(bits) << 32) | ~id;
}
TETUNE_HD inline std::uint32_t proposal_id(std::uint64_t proposal) {
  return ~static_cast<std::uint32_t>(proposal & 0xffffffffU);
}

TETUNE_HD inline Cavity cavity_of(const MeshView& mesh, const ConstrainedEdges& constrained, std::uint32_t id) {
  const auto t = static_cast<Index>(id / kCandidates);
  const auto candidate = static_cast<int>(id % kCandidates);
  return candidate < 4 ? face_cavity(mesh, t, candidate) : edge_cavity(mesh, constrained, t, candidate - 4);
}
TETUNE_HD inline int cavity_size(const Cavity& c) { return c.kind == FlipKind::face23 ? 2 : 3; }

TETUNE_HD inline double slot_energy(const MeshView& mesh, const Tet& t) {
  return tet_energy(mesh.law, vec(mesh.points[t[0]]), vec(mesh.points[t[1]]), vec(mesh.points[t[2]]),
                    vec(mesh.points[t[3]]))
      .eta;
}

struct EnergySum {
  double sum = 0;
  TETUNE_HD void merge(const EnergySum& other) { sum += other.sum; }
};

struct RefreshEta {
  MeshView mesh;
  Span<double> eta;
  TETUNE_HD EnergySum operator()(Size t) const {
    eta[t] = mesh.alive(t) ? slot_energy(mesh, mesh.tet2vertex[t]) : 0;
    return {eta[t]};
  }
};

struct IsAliveSlot {
  MeshView mesh;
  TETUNE_HD bool operator()(Size t) const { return mesh.alive(t); }
};

struct IsStirred {
  MeshView mesh;
  Span<const std::uint8_t> stirred;
  TETUNE_HD bool operator()(Size t) const {
    if (!mesh.alive(t)) return false;
    const Tet tet = mesh.tet2vertex[t];
    return (stirred[tet[0]] | stirred[tet[1]] | stirred[tet[2]] | stirred[tet[3]]) != 0;
  }
};

struct SetFlag {
  Span<const Index> slots;
  Span<std::uint8_t> flags;
  std::uint8_t value;
  TETUNE_HD void operator()(Size i) const { flags[slots[i]] = value; }
};

struct EvaluatedSum {
  Size evaluated = 0;
  TETUNE_HD void merge(const EvaluatedSum& other) { evaluated += other.evaluated; }
};

/// Each candidate is evaluated once, by the lowest active tetrahedron of its cavity.
struct Propose {
  MeshView mesh;
  ConstrainedEdges constrained;
  Span<const Index> active;
  Span<const std::uint8_t> is_active;
  Span<const double> eta;
  Span<std::uint64_t> proposal;

  TETUNE_HD EvaluatedSum operator()(Size i) const {
    const Index t = active[i];
    EvaluatedSum sum;
    for (std::uint32_t candidate = 0; candidate < kCandidates; ++candidate) {
      const std::uint32_t id = static_cast<std::uint32_t>(t) * kCandidates + candidate;
      const Cavity c = cavity_of(mesh, constrained, id);
      if (c.kind == FlipKind::none) continue;
      const int n = cavity_size(c);
      bool mine = true;
      double before = eta[t];
      for (int k = 1; k < n; ++k) {
        mine = mine && !(c.tets[k] < t && is_active[c.tets[k]] != 0);
        before += eta[c.tets[k]];
      }
      if (!mine) continue;
      ++sum.evaluated;
      const double after = energy_after(mesh, c, before);
      if (after < 0 || !(before - after > kMinRelativeGain * before)) continue;
      const std::uint64_t offer = make_proposal(before - after, id);
      for (int k = 0; k < n; ++k) par::atomic_max(proposal[c.tets[k]], offer);
    }
    return sum;
  }
};

/// A flip is agreed when all its tetrahedra hold it as their best (Alg. 5, lines 21 to 33). Its evaluator decides.
struct Agreed {
  MeshView mesh;
  ConstrainedEdges constrained;
  Span<const Index> active;
  Span<const std::uint64_t> proposal;
  TETUNE_HD bool operator()(Size i) const {
    const Index t = active[i];
    const std::uint64_t best = proposal[t];
    if (best == 0 || proposal_id(best) / kCandidates != static_cast<std::uint32_t>(t)) return false;
    const Cavity c = cavity_of(mesh, constrained, proposal_id(best));
    for (int k = 1; k < cavity_size(c); ++k) {
      if (proposal[c.tets[k]] != best) return false;
    }
    return true;
  }
};

/// One agreed flip on its way through the phases.
struct FlipRecord {
  Cavity cavity;
  Index slots[3];    ///< of the new tetrahedra; the third of a 3-2 flip is the one it frees
  Link old_face[6];  ///< outer faces before: 2 m and 2 m + 1 are those at ring edge m, on the side of a and of b
  Link across[6];    ///< what lies across them
};

/// Where outer face k of a flip is afterwards.
TETUNE_HD inline Link new_face(const FlipRecord& f, int k) {
  const int m = k / 2;
  if (f.cavity.kind == FlipKind::face23) return make_link(f.slots[m], k % 2 == 0 ? 3 : 0);
  // In (a,p,q,r) and (b,p,r,q), the vertex opposite ring edge m = pq, qr, rp.
  constexpr int kOpposite[2][3] = {{3, 1, 2}, {2, 1, 3}};
  return make_link(f.slots[k % 2], kOpposite[k % 2][m]);
}

/// Reads all that a flip needs before any tetrahedron changes, and marks its tetrahedra.
struct Gather {
  MeshView mesh;
  ConstrainedEdges constrained;
  Span<const Index> active;
  Span<const Index> agreed;
  Span<std::uint64_t> proposal;
  Span<FlipRecord> records;
  Span<std::uint32_t> takes_slot;

  TETUNE_HD void operator()(Size i) const {
    FlipRecord f;
    f.cavity = cavity_of(mesh, constrained, proposal_id(proposal[active[agreed[i]]]));
    const Cavity& c = f.cavity;
    const bool split = c.kind == FlipKind::face23;
    for (int m = 0; m < 3; ++m) {
      f.slots[m] = c.tets[m];
      for (int side = 0; side < 2; ++side) {
        const Index t = split ? c.tets[side] : c.tets[m];
        const Index opposite = split ? c.ring[(m + 2) % 3] : side == 0 ? c.b : c.a;
        const int face = local_index(mesh.tet2vertex[t], opposite);
        f.old_face[2 * m + side] = make_link(t, face);
        f.across[2 * m + side] = mesh.tet2tet[t][face];
      }
    }
    for (int k = 0; k < cavity_size(c); ++k) proposal[c.tets[k]] = kFlipped;
    takes_slot[i] = split ? 1 : 0;
    records[i] = f;
  }
};

/// Forgets the proposals of an active tetrahedron and its neighbours, which is wherever its flips were offered.
struct ClearProposals {
  MeshView mesh;
  Span<const Index> active;
  Span<std::uint64_t> proposal;
  TETUNE_HD void operator()(Size i) const {
    const Index t = active[i];
    clear(t);
    for (int f = 0; f < 4; ++f) {
      const Link link = mesh.tet2tet[t][f];
      if (link != kNoLink) clear(link_tet(link));
    }
  }

 private:
  TETUNE_HD void clear(Index t) const {
    if (par::load_shared(proposal[t]) != kFlipped) par::store_shared(proposal[t], std::uint64_t{0});
  }
};

struct Refused {
  Span<const Index> active;
  Span<const std::uint64_t> proposal;
  TETUNE_HD bool operator()(Size i) const {
    const std::uint64_t p = proposal[active[i]];
    return p != 0 && p != kFlipped;
  }
};

/// Hands out the slots and leaves, in each outer face of the old tetrahedra, the address of the new one.
struct Forward {
  MeshView mesh;
  Span<FlipRecord> records;
  Span<const std::uint32_t> rank23;  ///< number of 2-3 flips before this one
  Span<Index> free_slots;
  Size free_count;  ///< before this pass
  Size slots;       ///< before this pass
  Size free_kept;   ///< free slots that stay free
  TETUNE_HD void operator()(Size i) const {
    FlipRecord& f = records[i];
    const Size rank = rank23[i];
    if (f.cavity.kind == FlipKind::face23) {
      f.slots[2] =
          rank < free_count ? free_slots[free_count - 1 - rank] : static_cast<Index>(slots + rank - free_count);
    }
    for (int k = 0; k < 6; ++k) {
      mesh.tet2tet[link_tet(f.old_face[k])][link_face(f.old_face[k])] = new_face(f, k);
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
    for (int k = 0; k < 6; ++k) {
      const Link old = f.across[k];
      if (old == kNoLink) continue;
      Link& there = mesh.tet2tet[link_tet(old)][link_face(old)];
      if (proposal[link_tet(old)] == kFlipped) {
        f.across[k] = there | (old & kLocked);
      } else {
        there = new_face(f, k) | (old & kLocked);
      }
    }
  }
};

struct FlipSum {
  double decrease = 0;
  Size flips23 = 0, flips32 = 0;
  TETUNE_HD void merge(const FlipSum& other) {
    decrease += other.decrease;
    flips23 += other.flips23;
    flips32 += other.flips32;
  }
};

/// Puts the new tetrahedra in place.
struct Write {
  MeshView mesh;
  Span<const FlipRecord> records;
  Span<const std::uint32_t> rank23;
  Span<Index> free_slots;
  Size free_kept;
  Span<double> eta;
  Span<std::uint64_t> proposal;
  Span<Index> next_active;  ///< its part for the new tetrahedra
  Span<std::uint8_t> awake;

  TETUNE_HD FlipSum operator()(Size i) const {
    const FlipRecord f = records[i];
    const Cavity& c = f.cavity;
    const bool split = c.kind == FlipKind::face23;
    const Index *s = f.slots, *ring = c.ring;
    const int tag = mesh.tet_tags[c.tets[0]];
    double decrease = 0;
    for (int k = 0; k < cavity_size(c); ++k) {
      decrease += eta[c.tets[k]];
      proposal[c.tets[k]] = 0;
    }
    Tet tets[3];
    Links links[3];
    const int made = split ? 3 : 2;
    if (split) {
      for (int m = 0; m < 3; ++m) {
        tets[m] = {{c.a, ring[m], ring[(m + 1) % 3], c.b}};
        links[m] = {{f.across[2 * m + 1], make_link(s[(m + 1) % 3], 2), make_link(s[(m + 2) % 3], 1), f.across[2 * m]}};
      }
    } else {
      tets[0] = {{c.a, ring[0], ring[1], ring[2]}};
      links[0] = {{make_link(s[1], 0), f.across[2], f.across[4], f.across[0]}};
      tets[1] = {{c.b, ring[0], ring[2], ring[1]}};
      links[1] = {{make_link(s[0], 0), f.across[3], f.across[1], f.across[5]}};
    }
    for (int m = 0; m < made; ++m) {
      mesh.tet2vertex[s[m]] = tets[m];
      mesh.tet2tet[s[m]] = links[m];
      mesh.tet_tags[s[m]] = tag;
      eta[s[m]] = slot_energy(mesh, tets[m]);
      decrease -= eta[s[m]];
    }
    // 2 i + rank23: two tetrahedra for each flip before this one, and a third for each 2-3 flip among them.
    const Size next = 2 * i + rank23[i];
    for (int m = 0; m < made; ++m) next_active[next + m] = s[m];
    if (split) {
      proposal[s[2]] = 0;
    } else {
      mesh.tet2vertex[s[2]][0] = kFreeSlot;
      eta[s[2]] = 0;
      free_slots[free_kept + i - rank23[i]] = s[2];
    }
    if (awake.size() > 0) {
      par::store_shared(awake[c.a], 1);
      par::store_shared(awake[c.b], 1);
      for (int m = 0; m < 3; ++m) par::store_shared(awake[ring[m]], 1);
    }
    return {decrease, split ? 1 : 0, split ? 0 : 1};
  }
};

struct PickSlots {
  Span<const Index> from;
  Span<const Index> positions;
  Span<Index> to;
  TETUNE_HD void operator()(Size i) const { to[i] = from[positions[i]]; }
};

}  // namespace flip_detail

template <class Backend>
double refresh_energy(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state) {
  using namespace flip_detail;
  state.eta.resize(mesh.slots());
  return par.template reduce<EnergySum>(mesh.slots(), RefreshEta{mesh.view(), state.eta.span()}).sum;
}

template <class Backend, class Keep>
Size activate_where(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state, const Keep& keep) {
  const Size slots = mesh.slots();
  state.active.resize(slots);
  state.is_active.resize(slots);
  state.proposal.resize(slots);
  par.fill(state.is_active.span(), std::uint8_t{0});
  par.fill(state.proposal.span(), std::uint64_t{0});
  const Size count = par.compact(slots, keep, state.active.span());
  state.active.resize(count);
  par.for_each(count, flip_detail::SetFlag{state.active.span(), state.is_active.span(), 1});
  return count;
}

template <class Backend>
void activate_all(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state) {
  activate_where(par, mesh, state, flip_detail::IsAliveSlot{mesh.view()});
}

template <class Backend>
Size activate_stirred(const Backend& par, WorkMesh<Backend>& mesh, Span<std::uint8_t> stirred,
                      FlipState<Backend>& state) {
  const Size count = activate_where(par, mesh, state, flip_detail::IsStirred{mesh.view(), stirred});
  par.fill(stirred, std::uint8_t{0});
  return count;
}

template <class Backend>
FlipReport flip_pass(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state, Span<std::uint8_t> awake) {
  using namespace flip_detail;
  using Ids = typename Backend::template Buffer<Index>;
  FlipReport report;
  const ConstrainedEdges constrained = state.constrained();
  const Size active = state.active.size();
  report.active = active;
  report.evaluated = par.template reduce<EvaluatedSum>(
                            active, Propose{mesh.view(), constrained, state.active.span(), state.is_active.span(),
                                            state.eta.span(), state.proposal.span()})
                         .evaluated;

  Ids agreed(active);
  const Size flips =
      par.compact(active, Agreed{mesh.view(), constrained, state.active.span(), state.proposal.span()}, agreed.span());
  typename Backend::template Buffer<FlipRecord> records(flips);
  typename Backend::template Buffer<std::uint32_t> rank23(flips);
  par.for_each(flips, Gather{mesh.view(), constrained, state.active.span(), agreed.span(), state.proposal.span(),
                             records.span(), rank23.span()});
  const Size flips23 = par.exclusive_scan(Span<const std::uint32_t>(rank23.span()), rank23.span());
  const Size flips32 = flips - flips23;
  Ids refused_positions(active);
  const Size refused =
      par.compact(active, Refused{state.active.span(), state.proposal.span()}, refused_positions.span());
  par.for_each(active, ClearProposals{mesh.view(), state.active.span(), state.proposal.span()});

  const Size slots = mesh.slots();
  const Size free_kept = std::max<Size>(0, mesh.free_count - flips23);
  const Size needed = slots + std::max<Size>(0, flips23 - mesh.free_count);
  mesh.tet2vertex.grow(needed);
  mesh.tet2tet.grow(needed);
  mesh.tet_tags.grow(needed);
  state.eta.grow(needed);
  state.proposal.grow(needed);
  state.is_active.grow(needed);
  mesh.free_slots.grow(std::max(mesh.free_count, free_kept + flips32));

  par.for_each(flips, Forward{mesh.view(), records.span(), rank23.span(), mesh.free_slots.span(), mesh.free_count,
                              slots, free_kept});
  par.for_each(flips, Resolve{mesh.view(), records.span(), state.proposal.span()});
  Ids next(refused + 2 * flips + flips23);
  const FlipSum sum = par.template reduce<FlipSum>(
      flips, Write{mesh.view(), records.span(), rank23.span(), mesh.free_slots.span(), free_kept, state.eta.span(),
                   state.proposal.span(), Span<Index>(next.span().data() + refused, 2 * flips + flips23), awake});
  mesh.free_count = free_kept + flips32;

  par.for_each(refused, PickSlots{state.active.span(), refused_positions.span(), next.span()});
  par.for_each(active, SetFlag{state.active.span(), state.is_active.span(), 0});
  par.for_each(next.size(), SetFlag{next.span(), state.is_active.span(), 1});
  state.active.swap(next);

  report.flips23 = sum.flips23;
  report.flips32 = sum.flips32;
  report.decrease = sum.decrease;
  return report;
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "flips/apply_flips.inl"
#include "flips/face_cluster.hpp"
#include "flips/face_removals.hpp"

namespace tetune {
namespace face_removal_detail {

/// The best cluster around a face. A function of its own in the machine code, so that every kernel finds the same.
struct FindCluster {
  MeshView mesh;
  ConstrainedEdges constrained;
  Span<const double> energies;
  int most_faces;

  /// What the removal takes from the energy; 0: nothing.
  TETUNE_HD __attribute__((noinline)) double operator()(Index t, int face, Cavity& c,
                                                        Triangulation& triangulation) const {
    FaceCluster cluster(mesh, constrained);
    if (!cluster.grow(t, face, most_faces) || !(cluster.settle(energies) < 0)) return 0;
    c = cluster.cavity(triangulation);
    const double before = flip_detail::energy_before(c, energies);
    const double gain = before - energy_after(mesh, c, triangulation, before);
    return gain > kMinRelativeGain * before ? gain : 0;
  }
};

/// Each face is looked at by the worse of its two tetrahedra.
struct Propose {
  static constexpr Size kGrain = 32;
  FindCluster find;
  Span<const Index> active;
  Span<std::uint64_t> proposal;

  TETUNE_INLINE void prefetch(Size i, Size) const { flip_detail::FetchAhead{find.mesh, find.energies, active}(i); }

  TETUNE_HD flip_detail::EvaluatedSum operator()(Size i) const {
    const Index t = active[i];
    const MeshView& mesh = find.mesh;
    const Tet tet = mesh.tet2vertex[t];
    const Links links = mesh.tet2tet[t];
    const flip_detail::Worse worse{find.energies, t, find.energies[t]};
    Index beyond[4];  // the vertex across each face; -1: locked
    for (int face = 0; face < 4; ++face) beyond[face] = is_locked(links[face]) ? -1 : far_vertex(links[face]);
    flip_detail::EvaluatedSum sum;
    for (int face = 0; face < 4; ++face) {
      if (beyond[face] < 0 || worse(link_tet(links[face])) || !has_two_beside(tet, beyond, face, link_tet(links[face])))
        continue;
      ++sum.evaluated;
      Cavity c;
      Triangulation triangulation;
      const double gain = find(t, face, c, triangulation);
      if (!(gain > 0)) continue;
      offer_to(c.tets, c.size(), make_offer(gain, flip_detail::flip_id(t, face)), proposal);
    }
    return sum;
  }

 private:
  TETUNE_HD TETUNE_INLINE Index far_vertex(Link link) const {
    return find.mesh.tet2vertex[link_tet(link)][link_face(link)];
  }
  /// Whether two faces beside this one may lie between the same two vertices: the cheapest test, which few faces pass.
  TETUNE_HD TETUNE_INLINE bool has_two_beside(const Tet& tet, const Index beyond[4], int face, Index other) const {
    const Tet other_tet = find.mesh.tet2vertex[other];
    const Links other_links = find.mesh.tet2tet[other];
    int count = 0;
    for (int side = 0; side < 4; ++side) {
      if (side == face || beyond[side] < 0) continue;
      const Link below = other_links[place_of(other_tet, tet[side])];
      count += !is_locked(below) && far_vertex(below) == beyond[side] ? 1 : 0;
    }
    return count >= 2;
  }
};

/// The tetrahedra whose best offer is their own and agreed.
struct Agreed {
  FindCluster find;
  Span<const Index> active;
  Span<const std::uint64_t> proposal;
  TETUNE_HD bool operator()(Size i) const {
    const std::uint64_t best = proposal[active[i]];
    if (best == 0 || flip_detail::id_tet(offer_id(best)) != active[i]) return false;
    Cavity c;
    Triangulation triangulation;
    find(active[i], static_cast<int>(offer_id(best) % kCandidates), c, triangulation);
    return all_hold(c.tets, c.size(), best, proposal);
  }
};

struct Gather {
  static constexpr Size kGrain = 32;
  FindCluster find;
  Span<const Index> active;
  Span<const Index> agreed;
  Span<std::uint64_t> proposal;
  Span<flip_detail::FlipRecord> records;
  Span<SlotCounts> counts;
  TETUNE_HD void operator()(Size i) const {
    const Index t = active[agreed[i]];
    flip_detail::FlipRecord f{};
    find(t, static_cast<int>(offer_id(proposal[t]) % kCandidates), f.cavity, f.triangulation);
    f.gather(find.mesh, proposal, counts[i]);
    records[i] = f;
  }
};

}  // namespace face_removal_detail

template <class Backend>
FlipReport face_removal_pass(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state,
                             Span<std::uint8_t> awake) {
  using namespace face_removal_detail;
  using Ids = typename Backend::template Buffer<Index>;
  FlipReport report;
  report.active = state.active.size();
  const FindCluster find{mesh.view(), state.constrained(), state.energies.span(), state.max_ring - 2};
  if (find.most_faces < 3) return report;
  const Span<const Index> active = state.active.span();
  par.fill(state.proposal.span(), std::uint64_t{0});
  const auto propose = [&](Span<const Index> part) { return Propose{find, part, state.proposal.span()}; };
  if (!flip_detail::propose_all(par, active, propose, report)) return report;
  Ids agreed(active.size());
  const Size flips = par.compact(active.size(), Agreed{find, active, state.proposal.span()}, agreed.span());
  typename Backend::template Buffer<flip_detail::FlipRecord> records(flips);
  typename Backend::template Buffer<SlotCounts> counts(flips);
  par.for_each(flips, Gather{find, active, agreed.span(), state.proposal.span(), records.span(), counts.span()});
  const flip_detail::FlipSum sum = flip_detail::apply_flips(par, mesh, state, records, counts, awake);
  report.face_removals = sum.face_removals;
  report.flips23 = sum.flips23;
  report.decrease = sum.decrease;
  return report;
}

}  // namespace tetune

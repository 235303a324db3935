// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "flips/offer.hpp"
#include "par/atomic.hpp"
#include "vertices/revise.hpp"
#include "vertices/star.hpp"

namespace tetune {
namespace revise_detail {

/// What a tetrahedron may propose: one of its edges removed, with a vertex of the ring moved; a vertex on each of its
/// edges; each of its vertices pulled into each other.
inline constexpr int kRemovals = 1;
inline constexpr int kInsertions = 6;
inline constexpr int kProposals = kRemovals + kInsertions + 12;
/// The cotangent of the smallest angle must fall by this part.
inline constexpr double kLeastGain = 0.02;
/// A place for a new vertex is worth more trials when it makes that no worse than so many times what it was.
inline constexpr double kHope = 1.5;
/// The same before the cavity is enlarged.
inline constexpr double kDoubt = 2;
/// Of a proposal that removes no vertex.
inline constexpr Index kNoVertex = -1;
/// Most tetrahedra around an edge that is removed: with more it hardly ever helps.
inline constexpr int kMaxMovedRing = 6;
/// In place of the best offer of a tetrahedron that is taken away.
inline constexpr std::uint64_t kTaken = ~std::uint64_t{0};
/// Proposals between two questions whether to stop: some tenths of a second of one thread.
template <class Backend>
inline constexpr Size kReviseAtOnce = Size{1} << (par::kBesideHost<Backend> ? 26 : 12);

/// A cavity and its apex: a vertex, or the place of a new one.
struct Proposal {
  double gain;  ///< 0: none
  Vec3 x;
  Index apex;     ///< vertex, or kNewVertex
  Index removed;  ///< vertex, or kNoVertex
  Index tets[kMaxStarTets];
  int tet_count;
};

struct Propose {
  static constexpr Size kGrain = 4;
  MeshView mesh;
  ConstrainedEdges constrained;
  Span<const Mobility> kind;
  Span<const Index> around;
  Span<Proposal> proposals;
  Span<std::uint64_t> best;
  int max_ring;
  double vertex_cot;
  int choices;  ///< of each tetrahedron
  Size first;   ///< id of the first proposal

  TETUNE_HD void operator()(Size offset) const {
    const Size id = first + offset;
    const Index t = around[id / choices];
    const auto choice = static_cast<int>(id % choices);
    Proposal& p = proposals[id];
    p.gain = 0;
    if (choice < kRemovals) {
      remove_edge(t, p);
    } else if (largest_cot(mesh, t) > vertex_cot) {
      Star star(mesh, constrained);
      if (choice < kRemovals + kInsertions) {
        insert(star, t, choice - kRemovals, p);
      } else {
        collapse(star, t, choice - kRemovals - kInsertions, p);
      }
    }
    if (!(p.gain > 0)) return;
    offer_to(p.tets, p.tet_count, make_offer(p.gain, static_cast<std::uint32_t>(id)), best);
  }

 private:
  /// Of all edges, by each vertex of its ring in turn.
  TETUNE_HD void remove_edge(Index t, Proposal& p) const {
    Moved most{Star(mesh, constrained), -1, {}, 0, kHope};
    const Tet tet = mesh.tet2vertex[t];
    for (int edge = 0; edge < 6; ++edge) {
      Star ring(mesh, constrained);
      if (!ring.take_edge(t, edge) || ring.tet_count() > max_ring) continue;
      const EdgeCorners e = edge_corners(edge);
      Index before = tet[e.k];
      for (int i = 0; i < ring.tet_count(); ++i) {
        // Tetrahedron i has the vertices before and after the face to the next one.
        const Tet there = mesh.tet2vertex[ring.tet(i)];
        Index v = before;
        for (int k = 0; k < 4; ++k)
          v = there[k] != tet[e.i] && there[k] != tet[e.j] && there[k] != before ? there[k] : v;
        before = v;
        if (kind[v] == Mobility::free && !constrained.has_end(v)) move_over(ring, v, most);
      }
    }
    if (most.v >= 0) propose(most.star, most.before, most.v, kNoVertex, most.star.open_angle(most.x), p);
  }

  /// A vertex moved so that it may fill a cavity.
  struct Moved {
    Star star;
    Index v;  ///< -1: none
    Vec3 x;
    double before;
    double ratio;  ///< of the cotangents after and before
  };
  TETUNE_HD void move_over(Star star, Index v, Moved& most) const {
    if (!star.spread(v)) return;
    Vec3 x = vec(mesh.points[v]);
    if (!star.face_all(x)) return;
    x = star.relax(x);
    const double far = kDoubt * most.ratio * star.cot_before();
    if (!(star.cot_after(v, x, far) < far)) return;
    x = star.settle(x);
    const double before = star.cot_before();
    const double limit = most.ratio * before;
    const double after = star.cot_after(v, x, limit);
    if (after < limit && star.keeps_all(v)) most = {star, v, x, before, after / before};
  }

  TETUNE_HD void insert(Star& star, Index t, int edge, Proposal& p) const {
    if (!star.take_edge(t, edge)) return;
    const Tet tet = mesh.tet2vertex[t];
    const EdgeCorners e = edge_corners(edge);
    const Vec3 x = star.settle(star.relax(0.5 * (vec(mesh.points[tet[e.i]]) + vec(mesh.points[tet[e.j]]))));
    const double before = star.cot_before();
    const double hope = kHope * before;
    if (!(star.cot_after(kNewVertex, x, hope) < hope)) return;
    propose(star, before, kNewVertex, kNoVertex, star.open_angle(x), p);
  }

  TETUNE_HD void collapse(Star& star, Index t, int choice, Proposal& p) const {
    const Tet tet = mesh.tet2vertex[t];
    const int from = choice / 3;
    const int to = (from + 1 + choice % 3) % 4;
    if (kind[tet[from]] != Mobility::free || constrained.has_end(tet[from]) || !star.take_vertex(t, from)) return;
    propose(star, star.cot_before(), tet[to], tet[from], vec(mesh.points[tet[to]]), p);
  }

  TETUNE_HD void propose(const Star& star, double before, Index apex, Index removed, const Vec3& x, Proposal& p) const {
    const double limit = (1 - kLeastGain) * before;
    const double after = star.cot_after(apex, x, limit);
    if (!(after < limit) || !(before - after > p.gain)) return;
    p.gain = before - after;
    p.x = x;
    p.apex = apex;
    p.removed = removed;
    p.tet_count = star.tet_count();
    for (int i = 0; i < p.tet_count; ++i) p.tets[i] = star.tet(i);
  }
};

/// Tetrahedra that may propose: so many, and one of so many.
inline constexpr Size kFew = 250;

/// The proposals that are agreed.
struct Agreed {
  Span<const Proposal> proposals;
  Span<const std::uint64_t> best;
  TETUNE_HD bool operator()(Size id) const {
    const Proposal& p = proposals[id];
    if (!(p.gain > 0)) return false;
    return all_hold(p.tets, p.tet_count, make_offer(p.gain, static_cast<std::uint32_t>(id)), best);
  }
};

/// What a set of fillings adds up to, as a scan needs it.
struct Counts {
  SlotCounts slots;
  std::uint32_t inserted = 0;
  std::uint32_t removed = 0;
  TETUNE_HD friend Counts operator+(Counts x, const Counts& y) { return x += y; }
  TETUNE_HD Counts& operator+=(const Counts& y) {
    slots += y.slots;
    inserted += y.inserted;
    removed += y.removed;
    return *this;
  }
};

/// One agreed filling on its way through the phases.
struct Filling {
  Index apex;
  Index removed;
  bool inserted;
  Vec3 x;
  int old_count;  ///< tetrahedra before
  int made;       ///< and after
  int face_count;
  Index slots[kMaxStarFaces];  ///< of the old tetrahedra, then those it takes
  LinkFace faces[kMaxStarFaces];
  Link sides[kMaxStarFaces];
  Link across[kMaxStarFaces];
  std::int8_t place[kMaxStarFaces];  ///< which of the new tetrahedra is on this face; negative where the apex is on it

  /// The side opposite corner k of a face: which face lies beyond it, and which of its corners is opposite.
  TETUNE_HD Link beyond(int face, int k) const {
    const Index a = faces[face].v[k == 2 ? 0 : k + 1];
    const Index b = faces[face].v[k == 0 ? 2 : k - 1];
    for (int i = 0; i < face_count; ++i) {
      for (int c = 0; c < 3; ++c) {
        if (faces[i].v[c == 2 ? 0 : c + 1] == b && faces[i].v[c == 0 ? 2 : c - 1] == a) return make_link(i, c);
      }
    }
    return kNoLink;
  }
  /// Where a face of the cavity is afterwards: opposite the apex of the tetrahedron on it; or where the apex is on it,
  /// in the one beyond the side opposite the apex.
  TETUNE_HD Link new_side(int face) const {
    if (place[face] >= 0) return make_link(slots[place[face]], 0);
    int k = 0;
    while (faces[face].v[k] != apex) ++k;
    const Link next = beyond(face, k);
    return make_link(slots[place[link_tet(next)]], link_face(next) + 1);
  }
};

struct Gather {
  static constexpr Size kGrain = 1;
  MeshView mesh;
  ConstrainedEdges constrained;
  Span<const Proposal> proposals;
  Span<const Index> agreed;
  Span<std::uint64_t> best;
  Span<Filling> fillings;
  Span<Counts> counts;

  TETUNE_HD void operator()(Size i) const {
    const Proposal& p = proposals[agreed[i]];
    Star star(mesh, constrained);
    star.take(p.tets, p.tet_count);
    Filling& f = fillings[i];
    f.apex = p.apex;
    f.removed = p.removed;
    f.inserted = p.apex == kNewVertex;
    f.x = p.x;
    f.old_count = p.tet_count;
    f.face_count = star.face_count();
    f.made = 0;
    for (int k = 0; k < p.tet_count; ++k) {
      f.slots[k] = p.tets[k];
      best[p.tets[k]] = kTaken;
    }
    for (int k = 0; k < f.face_count; ++k) {
      f.faces[k] = star.face(k);
      f.sides[k] = star.side(k);
      f.across[k] = mesh.tet2tet[link_tet(f.sides[k])][link_face(f.sides[k])];
      f.place[k] = static_cast<std::int8_t>(star.touches(k, p.apex) ? -1 : f.made++);
    }
    counts[i] = {{f.old_count, f.made}, f.inserted ? 1U : 0U, f.removed >= 0 ? 1U : 0U};
  }
};

/// Hands out slots and vertices, and leaves, in each outer face of the old tetrahedra, the address of the new one.
struct Forward {
  MeshView mesh;
  Span<Filling> fillings;
  Span<const Counts> before;
  Span<const Index> free_slots;
  SlotChange change;
  Size vertices;  ///< before this pass
  TETUNE_HD void operator()(Size i) const {
    Filling& f = fillings[i];
    for (int k = f.old_count; k < f.made; ++k) {
      f.slots[k] = change.taken(free_slots, static_cast<Size>(before[i].slots.takes) + k - f.old_count);
    }
    if (f.inserted) f.apex = static_cast<Index>(vertices + before[i].inserted);
    for (int k = 0; k < f.face_count; ++k) {
      mesh.tet2tet[link_tet(f.sides[k])][link_face(f.sides[k])] = f.new_side(k);
    }
  }
};

/// Finds what lies across the outer faces now, as flips do.
struct Resolve {
  MeshView mesh;
  Span<Filling> fillings;
  Span<const std::uint64_t> best;
  TETUNE_HD void operator()(Size i) const {
    Filling& f = fillings[i];
    for (int k = 0; k < f.face_count; ++k) {
      const Link old = f.across[k];
      if (old == kNoLink) continue;
      Link& there = mesh.tet2tet[link_tet(old)][link_face(old)];
      if (best[link_tet(old)] == kTaken) {
        f.across[k] = there | (old & kLocked);
      } else {
        there = f.new_side(k) | (old & kLocked);
      }
    }
  }
};

/// Puts the new tetrahedra and vertices in place.
struct Write {
  MeshView mesh;
  Span<const Filling> fillings;
  Span<const Counts> before;
  Span<Index> free_slots;
  Size free_kept;
  Span<double> energies;
  Span<Index> vertex2original;
  Span<Mobility> kind;
  Span<Vec3> axis;
  Span<Site> site;
  Span<std::uint8_t> constrained_vertex;
  Span<std::uint8_t> awake;

  TETUNE_HD void operator()(Size i) const {
    const Filling& f = fillings[i];
    const Index original = mesh.tet2original[f.slots[0]];
    if (f.removed >= 0) {
      vertex2original[f.removed] = kRemoved;
    } else {
      mesh.points[f.apex] = point(f.x);
    }
    if (f.inserted) insert(f);
    for (int k = 0; k < f.face_count; ++k) {
      const LinkFace& face = f.faces[k];
      for (int c = 0; c < 3; ++c) par::store_shared(awake[face.v[c]], 1);
      if (f.place[k] < 0) continue;
      const Index s = f.slots[f.place[k]];
      mesh.tet2vertex[s] = {{f.apex, face.v[0], face.v[1], face.v[2]}};
      mesh.tet2original[s] = original;
      energies[s] = tet_energy(mesh.law, vec(mesh.points[f.apex]), vec(mesh.points[face.v[0]]),
                               vec(mesh.points[face.v[1]]), vec(mesh.points[face.v[2]]))
                        .energy;
      Links links{};
      links[0] = f.across[k];
      for (int c = 0; c < 3; ++c) {
        const Link next = f.beyond(k, c);
        const std::int8_t there = f.place[link_tet(next)];
        links[c + 1] = there < 0 ? f.across[link_tet(next)] : make_link(f.slots[there], link_face(next) + 1);
      }
      mesh.tet2tet[s] = links;
    }
    par::store_shared(awake[f.apex], 1);
    for (int k = f.made; k < f.old_count; ++k) {
      mesh.tet2vertex[f.slots[k]][0] = kFreeSlot;
      energies[f.slots[k]] = 0;
      free_slots[free_kept + before[i].slots.frees + k - f.made] = f.slots[k];
    }
  }

 private:
  TETUNE_HD void insert(const Filling& f) const {
    vertex2original[f.apex] = kInserted;
    kind[f.apex] = Mobility::free;
    axis[f.apex] = {0, 0, 0};
    if (site.size() > 0) site[f.apex] = {};
    constrained_vertex[f.apex] = 0;
  }
};

}  // namespace revise_detail

template <class Backend>
ReviseReport revise_vertices(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& flips,
                             Mobilities<Backend>& mobilities, Span<const Index> around, Size most_tets,
                             double vertex_cot) {
  using namespace revise_detail;
  using Ids = typename Backend::template Buffer<Index>;
  const Size slots = mesh.slots();
  const Size vertices = mesh.vertices();

  // In a lattice any angle may be that of all.
  const int choices = vertex_cot < kNever ? kProposals : kRemovals;
  const Size count = choices * std::min(around.size(), kFew + mesh.tets() / kFew);
  typename Backend::template Buffer<Proposal> proposals(count);
  typename Backend::template Buffer<std::uint64_t> best(slots);
  par.fill(best.span(), std::uint64_t{0});
  for (Size first = 0; first < count; first += kReviseAtOnce<Backend>) {
    if (par.stop_requested()) return {};
    par.for_each(std::min(kReviseAtOnce<Backend>, count - first),
                 Propose{mesh.view(), flips.constrained(), mobilities.kind.span(), around, proposals.span(),
                         best.span(), std::min(flips.max_ring, kMaxMovedRing), vertex_cot, choices, first});
  }
  Ids agreed(count);
  const Size fills = par.compact(count, Agreed{proposals.span(), best.span()}, agreed.span());
  typename Backend::template Buffer<Filling> fillings(fills);
  typename Backend::template Buffer<Counts> before(fills);
  par.for_each(fills, Gather{mesh.view(), flips.constrained(), proposals.span(), agreed.span(), best.span(),
                             fillings.span(), before.span()});
  const Counts counts = par.exclusive_scan(Span<const Counts>(before.span()), before.span());
  const SlotChange change(mesh, counts.slots);
  const Size tets = mesh.tets() + counts.slots.takes - counts.slots.frees;
  if (fills == 0 || tets > most_tets || change.needed > kMaxSlots) return {};
  change.make_room(mesh);
  flips.energies.grow(change.needed);
  flips.slack.resize(change.needed);
  par.fill(flips.slack.span(), static_cast<float>(kMaxSlack));
  const Size all = vertices + counts.inserted;
  mesh.points.grow(all);
  mesh.vertex2original.grow(all);
  flips.constrained_vertex.grow(all);
  mobilities.kind.grow(all);
  mobilities.axis.grow(all);
  mobilities.awake.grow(all);
  if (mobilities.site.size() > 0) mobilities.site.grow(all);

  par.for_each(fills, Forward{mesh.view(), fillings.span(), before.span(), mesh.free_slots.span(), change, vertices});
  par.for_each(fills, Resolve{mesh.view(), fillings.span(), best.span()});
  par.for_each(fills,
               Write{mesh.view(), fillings.span(), before.span(), mesh.free_slots.span(), change.free_kept,
                     flips.energies.span(), mesh.vertex2original.span(), mobilities.kind.span(), mobilities.axis.span(),
                     mobilities.site.span(), flips.constrained_vertex.span(), mobilities.awake.span()});
  change.finish(mesh);
  return {counts.inserted, counts.removed, fills - counts.inserted - counts.removed};
}

}  // namespace tetune

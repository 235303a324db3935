// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "flips/apply_flips.inl"
#include "flips/boundary_flips.hpp"

namespace tetune {
namespace boundary_flip_detail {

struct VertexOfCorner {
  Span<const BoundaryTriangle> triangles;
  TETUNE_HD Size operator()(Size corner) const { return triangles[corner / 3].v[corner % 3]; }
};

struct IsAtBoundary {
  MeshView mesh;
  TETUNE_HD bool operator()(Size t) const {
    const Links links = mesh.tet2tet[t];
    return mesh.alive(t) && (is_locked(links[0]) || is_locked(links[1]) || is_locked(links[2]) || is_locked(links[3]));
  }
};

TETUNE_HD inline bool has_vertex(const BoundaryTriangle& t, Index v) {
  return t.v[0] == v || t.v[1] == v || t.v[2] == v;
}

/// Where each triangle is in the mesh; of one with tetrahedra on both sides, the lower of the two faces.
struct FindFaces {
  MeshView mesh;
  Span<const Index> tets;
  Span<const BoundaryTriangle> triangles;
  RowsView vertex2corner;
  Span<Index> triangle2face;
  TETUNE_HD void operator()(Size i) const {
    const Tet tet = mesh.tet2vertex[tets[i]];
    for (int f = 0; f < 4; ++f) {
      const Link link = mesh.tet2tet[tets[i]][f];
      if (!is_locked(link) || (link != kNoLink && link_tet(link) < tets[i])) continue;
      const Index v[3] = {tet[face_vertex(f, 0)], tet[face_vertex(f, 1)], tet[face_vertex(f, 2)]};
      const Index from = vertex2corner.shorter(vertex2corner.shorter(v[0], v[1]), v[2]);
      for (Size c = vertex2corner.begin(from); c < vertex2corner.end(from); ++c) {
        const Size triangle = vertex2corner.items[c] / 3;
        const BoundaryTriangle& t = triangles[triangle];
        if (has_vertex(t, v[0]) && has_vertex(t, v[1]) && has_vertex(t, v[2])) {
          triangle2face[triangle] = 4 * tets[i] + f;
        }
      }
    }
  }
};

/// Edges are looked at whose opposite angles have cotangents with a sum below this. It is 0 for a Delaunay edge that is
/// about to become none, and hardly any flip pays above (docs/benchmarks/cpu.md, "Flips of boundary edges").
inline constexpr double kMostCotSum = 0.3;

/// An edge of the boundary and the two triangles at it, (a, b, p) and (b, a, q).
struct BoundaryEdge {
  Index a, b, p, q;
  Index triangle, other;  ///< other -1: there is not just one
};

struct FindEdge {
  Span<const Point> points;
  ConstrainedEdges constrained;
  Span<const BoundaryTriangle> triangles;
  RowsView vertex2corner;
  double flat;

  /// The edge opposite a corner.
  TETUNE_HD BoundaryEdge operator()(Size corner) const {
    const auto triangle = static_cast<Index>(corner / 3);
    const auto k = static_cast<int>(corner % 3);
    const BoundaryTriangle& t = triangles[triangle];
    BoundaryEdge e{t.v[(k + 1) % 3], t.v[(k + 2) % 3], t.v[k], -1, triangle, -1};
    const Index end = vertex2corner.shorter(e.a, e.b);
    for (Size c = vertex2corner.begin(end); c < vertex2corner.end(end); ++c) {
      const auto o = static_cast<Index>(vertex2corner.items[c] / 3);
      const BoundaryTriangle& u = triangles[o];
      if (o == triangle || !has_vertex(u, e.a) || !has_vertex(u, e.b)) continue;
      if (e.q >= 0) return {e.a, e.b, e.p, -1, triangle, -1};  // sheets touch along the edge
      for (int j = 0; j < 3; ++j) e.q = u.v[j] != e.a && u.v[j] != e.b ? u.v[j] : e.q;
      e.other = o;
    }
    return e;
  }

  /// Of the angle at p.
  TETUNE_HD double cot(Index a, Index b, Index p) const {
    const Vec3 pa = vec(points[a]) - vec(points[p]);
    const Vec3 pb = vec(points[b]) - vec(points[p]);
    return dot(pa, pb) / norm(cross(pa, pb));
  }
  TETUNE_HD double cot(Size corner) const {
    const BoundaryTriangle& t = triangles[corner / 3];
    const auto k = static_cast<int>(corner % 3);
    return cot(t.v[(k + 1) % 3], t.v[(k + 2) % 3], t.v[k]);
  }

  /// Whether an edge lies within a flat part of one patch.
  TETUNE_HD bool may_go(const BoundaryEdge& e) const {
    if (e.other < 0 || constrained.contains(e.a, e.b)) return false;
    const BoundaryTriangle& t = triangles[e.triangle];
    const BoundaryTriangle& u = triangles[e.other];
    const bool alike = t.stays == 0 && u.stays == 0 && t.tag == u.tag && (t.listed < 0) == (u.listed < 0);
    return alike && is_flat(e) && !is_edge(e.p, e.q);
  }

 private:
  /// Flat across the edge, and across the one that a flip would make. Not folded back.
  TETUNE_HD bool is_flat(const BoundaryEdge& e) const {
    const Vec3 a = vec(points[e.a]);
    const Vec3 ab = vec(points[e.b]) - a;
    const Vec3 ap = vec(points[e.p]) - a;
    const Vec3 aq = vec(points[e.q]) - a;
    const Vec3 n1 = cross(ab, ap);
    const Vec3 n2 = cross(aq, ab);
    if (!(dot(n1, n2) > 0)) return false;
    const double volume = std::fabs(dot(n1, aq));
    const Vec3 m1 = cross(aq, ap);
    const Vec3 m2 = n1 + n2 - m1;  // of (q, b, p)
    return volume <= flat * norm(ab) * larger(n1, n2) && volume <= flat * norm(ap - aq) * larger(m1, m2);
  }
  TETUNE_HD static double larger(const Vec3& x, const Vec3& y) {
    const double xx = dot(x, x);
    const double yy = dot(y, y);
    return std::sqrt(xx > yy ? xx : yy);
  }
  TETUNE_HD bool is_edge(Index p, Index q) const {
    const Index end = vertex2corner.shorter(p, q);
    for (Size c = vertex2corner.begin(end); c < vertex2corner.end(end); ++c) {
      if (has_vertex(triangles[static_cast<Size>(vertex2corner.items[c] / 3)], p ^ q ^ end)) return true;
    }
    return false;
  }
};

/// Marks each edge that may go and that a look may be worth, at the corner with the larger angle: most corners need
/// only their own.
struct MarkEdge {
  FindEdge find;
  Span<const std::uint8_t> awake;
  Span<std::uint8_t> marks;
  TETUNE_HD void operator()(Size corner) const { marks[corner] = is_worth_a_look(corner) ? 1 : 0; }

 private:
  TETUNE_HD bool is_worth_a_look(Size corner) const {
    const double cot = find.cot(corner);
    if (!(2 * cot < kMostCotSum)) return false;
    const BoundaryEdge e = find(corner);
    if (e.other < 0 || (awake[e.a] | awake[e.b]) == 0) return false;
    const double other = find.cot(e.a, e.b, e.q);
    const bool larger = cot < other || (cot == other && e.triangle < e.other);
    return larger && cot + other < kMostCotSum && find.may_go(e);
  }
};

struct IsMarked {
  Span<const std::uint8_t> marks;
  TETUNE_HD bool operator()(Size i) const { return marks[i] != 0; }
};

struct FillEdge {
  static constexpr Size kGrain = 32;
  FindEdge find;
  Span<const Index> corners;
  Span<BoundaryEdge> edges;
  TETUNE_HD void operator()(Size i) const { edges[i] = find(corners[i]); }
};

/// The fans of an edge: that which starts at its triangle, and that which starts at the other one. On the outer
/// boundary there is just one.
struct Fans {
  Cavity fan[2];
  int count = 0;  ///< 0: the edge may not go

  TETUNE_HD bool has(int k) const { return count > 0 && fan[k].kind != FlipKind::none; }
};

struct FindFans {
  static constexpr Size kGrain = 32;
  MeshView mesh;
  Span<const BoundaryEdge> edges;
  Span<const Index> triangle2face;
  int max_ring;

  TETUNE_HD Fans operator()(Size i) const {
    const BoundaryEdge& e = edges[i];
    Fans fans;
    const bool fine = find(e, e.triangle, e.p, e.q, fans.fan[0]) && find(e, e.other, e.q, e.p, fans.fan[1]);
    for (int k = 0; k < 2 && fine; ++k) fans.count += fans.fan[k].kind != FlipKind::none ? 1 : 0;
    return fans;
  }

 private:
  /// The fan that turns from a to b about the edge, a < b, from a triangle (a, b, front) to (a, b, end); kind none
  /// where there is no tetrahedron on that side. False where it has more than max_ring vertices, or something else in
  /// it is locked.
  TETUNE_HD bool find(const BoundaryEdge& edge, Index triangle, Index front, Index end, Cavity& c) const {
    c.a = edge.a < edge.b ? edge.a : edge.b;
    c.b = edge.a < edge.b ? edge.b : edge.a;
    Index face = triangle2face[triangle];
    if (opposite_start(face, c) != (face & 3)) {
      const Link across = mesh.tet2tet[face >> 2][face & 3];
      if (across == kNoLink) return true;
      face = static_cast<Index>(across & ~kLocked);
    }
    Index t = face >> 2;
    Index behind = mesh.tet2vertex[t][face & 3];
    int n = 0;
    for (;;) {
      if (n + 2 > max_ring) return false;
      c.ring[n] = front;
      c.tets[n] = t;
      ++n;
      const Link link = mesh.tet2tet[t][place_of(mesh.tet2vertex[t], front)];
      front = behind;
      if (is_locked(link)) break;
      t = link_tet(link);
      behind = mesh.tet2vertex[t][link_face(link)];
    }
    if (n < 2 || front != end) return false;
    c.ring[n] = front;
    c.ring_size = static_cast<std::uint8_t>(n + 1);
    c.kind = FlipKind::boundary_removal;
    return true;
  }

  /// The face of the tetrahedron at `face` that a fan about (a, b) would start from.
  TETUNE_HD int opposite_start(Index face, const Cavity& c) const {
    const Tet tet = mesh.tet2vertex[face >> 2];
    const int a = local_index(tet, c.a);
    const int b = local_index(tet, c.b);
    const EdgeCorners e = edge_corners(edge_of(a < b ? a : b, a < b ? b : a));
    return a < b ? e.l : e.k;
  }
};

/// Offers each flip that is worth it to the tetrahedra of its fans.
struct Propose {
  static constexpr Size kGrain = 32;
  FindFans find;
  Span<const Index> corners;
  Span<const double> energies;
  Span<std::uint64_t> offers;
  Span<std::uint64_t> proposal;
  TETUNE_HD flip_detail::EvaluatedSum operator()(Size i) const {
    offers[i] = 0;
    const Fans fans = find(i);
    if (fans.count == 0) return {};
    double before = 0;
    int made = 0;
    for (int k = 0; k < 2; ++k) {
      if (!fans.has(k)) continue;
      before += flip_detail::energy_before(fans.fan[k], energies);
      made += fans.fan[k].made();
    }
    // The shape energy of a tetrahedron is never below 1.
    if (find.mesh.law.shape && before <= made) return {};
    // One side may lose what the other one more than gains.
    double after = 0;
    for (int k = 0; k < 2; ++k) {
      Triangulation triangulation;
      if (fans.has(k)) after += best_energy(find.mesh, fans.fan[k], before, (1 + kMaxSlack) * before, triangulation);
    }
    if (before - after > kMinRelativeGain * before) {
      offers[i] = make_offer(before - after, static_cast<std::uint32_t>(corners[i]));
      for (int k = 0; k < 2; ++k) {
        if (fans.has(k)) offer_to(fans.fan[k].tets, fans.fan[k].size(), offers[i], proposal);
      }
    }
    return {1};
  }
};

/// The fans of agreed flips, 2 * edge + fan.
struct Agreed {
  FindFans find;
  Span<const std::uint64_t> offers;
  Span<const std::uint64_t> proposal;
  TETUNE_HD bool operator()(Size id) const {
    const std::uint64_t offer = offers[id / 2];
    if (offer == 0) return false;
    const Fans fans = find(id / 2);
    for (int k = 0; k < 2; ++k) {
      if (fans.has(k) && !all_hold(fans.fan[k].tets, fans.fan[k].size(), offer, proposal)) return false;
    }
    return fans.has(static_cast<int>(id % 2));
  }
};

struct Gather {
  static constexpr Size kGrain = 32;
  FindFans find;
  Span<const Index> agreed;
  Span<const double> energies;
  Span<std::uint64_t> proposal;
  Span<flip_detail::FlipRecord> records;
  Span<SlotCounts> counts;
  TETUNE_HD void operator()(Size i) const {
    flip_detail::FlipRecord f{};
    const Fans fans = find(agreed[i] / 2);
    const int side = agreed[i] % 2;
    f.cavity = fans.fan[side];
    if (fans.count == 2) f.twin = static_cast<Index>(side == 0 ? i + 1 : i - 1);
    double energy = 0;
    for (int k = 0; k < 2; ++k) energy += fans.has(k) ? flip_detail::energy_before(fans.fan[k], energies) : 0;
    best_energy(find.mesh, f.cavity, energy, (1 + kMaxSlack) * energy, f.triangulation);
    f.gather(find.mesh, proposal, counts[i]);
    records[i] = f;
  }
};

/// The two triangles at each edge that goes become those at the new one, each turned as it was.
struct TurnTriangles {
  Span<const BoundaryEdge> edges;
  Span<const Index> agreed;
  Span<const flip_detail::FlipRecord> records;
  Span<BoundaryTriangle> triangles;
  TETUNE_HD void operator()(Size i) const {
    if (!records[i].leads(i)) return;
    const BoundaryEdge& e = edges[agreed[i] / 2];
    BoundaryTriangle& other = triangles[e.other];
    int a = 0;
    while (other.v[a] != e.a) ++a;
    // Triangles of an interface need not turn the same way.
    const bool alike = other.v[(a + 1) % 3] != e.b;
    const Index first[3] = {e.a, e.q, e.p};
    const Index second[3] = {e.q, alike ? e.b : e.p, alike ? e.p : e.b};
    for (int k = 0; k < 3; ++k) {
      triangles[e.triangle].v[k] = first[k];
      other.v[k] = second[k];
    }
  }
};

}  // namespace boundary_flip_detail

template <class Backend>
FlipReport boundary_flip_pass(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state,
                              BoundaryTriangles<Backend>& boundary, Span<std::uint8_t> awake) {
  using namespace boundary_flip_detail;
  using Ids = typename Backend::template Buffer<Index>;
  FlipReport report;
  const Size count = boundary.triangles.size();
  if (boundary.stale) {
    build_rows(par, mesh.vertices(), 3 * count, VertexOfCorner{boundary.triangles.span()}, boundary.vertex2corner);
    boundary.stale = false;
  }
  const FindEdge find{mesh.points.span(), state.constrained(), boundary.triangles.span(), boundary.vertex2corner.view(),
                      boundary.flat};
  typename Backend::template Buffer<std::uint8_t> marks(3 * count);
  par.for_each(3 * count, MarkEdge{find, awake, marks.span()});
  Ids corners(3 * count);
  corners.resize(par.compact(3 * count, IsMarked{marks.span()}, corners.span()));
  const Size candidates = corners.size();
  report.active = candidates;
  if (candidates == 0 || par.stop_requested()) return report;
  typename Backend::template Buffer<BoundaryEdge> edges(candidates);
  par.for_each(candidates, FillEdge{find, corners.span(), edges.span()});

  Ids tets(mesh.slots());
  tets.resize(par.compact(mesh.slots(), IsAtBoundary{mesh.view()}, tets.span()));
  Ids triangle2face(count);
  par.for_each(tets.size(), FindFaces{mesh.view(), tets.span(), boundary.triangles.span(),
                                      boundary.vertex2corner.view(), triangle2face.span()});

  if (par.stop_requested()) return report;
  const FindFans fans{mesh.view(), edges.span(), triangle2face.span(), state.max_ring};
  typename Backend::template Buffer<std::uint64_t> offers(candidates);
  par.fill(state.proposal.span(), std::uint64_t{0});
  report.evaluated =
      par.template reduce<flip_detail::EvaluatedSum>(
             candidates, Propose{fans, corners.span(), state.energies.span(), offers.span(), state.proposal.span()})
          .evaluated;
  if (par.stop_requested()) return report;
  Ids agreed(2 * candidates);
  const Size agreed_fans =
      par.compact(2 * candidates, Agreed{fans, offers.span(), state.proposal.span()}, agreed.span());
  if (agreed_fans == 0) return report;
  typename Backend::template Buffer<flip_detail::FlipRecord> records(agreed_fans);
  typename Backend::template Buffer<SlotCounts> counts(agreed_fans);
  par.for_each(agreed_fans, Gather{fans, agreed.span(), state.energies.span(), state.proposal.span(), records.span(),
                                   counts.span()});
  const flip_detail::FlipSum sum = flip_detail::apply_flips(par, mesh, state, records, counts, awake);
  par.for_each(agreed_fans, TurnTriangles{edges.span(), agreed.span(), records.span(), boundary.triangles.span()});
  boundary.stale = true;
  report.boundary_flips = sum.boundary_flips;
  report.decrease = sum.decrease;
  return report;
}

}  // namespace tetune

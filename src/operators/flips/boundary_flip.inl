// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/engine/application.hpp"
#include "operators/flips/boundary_edges.hpp"
#include "operators/flips/boundary_flip.hpp"
#include "operators/flips/flip_energy.hpp"

namespace tetune {
namespace boundary_flip_detail {

/// The fans of an edge: that which starts at its triangle, and that which starts at the other one. On the outer
/// boundary there is one. Of a periodic edge: its fan, and that of its image.
struct Fans {
  FlipCandidate fan[2];
  int count = 0;  ///< 0: the edge may not be flipped

  TETUNE_HD bool has(int k) const { return fan[k].kind != FlipKind::none; }
};

/// Evaluates one edge: its candidate has a part for each fan, and may lose in one what it more than gains in the other.
template <class Pack>
struct BoundaryFlipProposals {
  using Candidate = FlipCandidate;
  static constexpr int kParts = 2;
  static constexpr Size kGrain = 32;
  static constexpr Size kBatch = Size{1} << 15;
  RatedMesh mesh;
  Span<const BoundaryEdge> edges;
  Span<const BoundaryEdge> images;  ///< those that are flipped together with the edges; empty where there is none
  Span<const Index> corners;
  Span<const Index> triangle2face;
  Span<const double> energies;
  int max_ring;
  bool bend;  ///< flips may bend the surface: within its planes, where cavities do not overlap no edge is made twice

  /// Few edges per slot, as a candidate makes one or two.
  Size edge_slots() const { return bend ? 4 * edges.size() : 0; }
  TETUNE_HD Size operator()(Size i, const Proposals<FlipCandidate>& proposals) const {
    const BoundaryEdge& e = edges[i];
    Fans fans;
    const bool is_paired = images.size() > 0 && images[i].other >= 0;
    if (!(is_paired ? find_pair(e, images[i], fans) : find_sides(e, fans))) return 0;
    double before = 0;
    int new_tets = 0;
    for (int k = 0; k < 2; ++k) {
      if (!fans.has(k)) continue;
      ++fans.count;
      before += energy_before(fans.fan[k], energies);
      new_tets += fans.fan[k].new_count();
    }
    // The shape energy of a tetrahedron is never below 1.
    if (fans.count == 0 || (mesh.objective.shape && before <= new_tets)) return 0;
    double after = 0;
    for (int k = 0; k < 2; ++k) {
      if (fans.has(k)) after += best_energy<Pack>(mesh, fans.fan[k], before, (1 + kMaxSlack) * before);
    }
    if (before - after > kMinRelativeGain * before) {
      for (int k = 0; k < 2; ++k) {
        FlipCandidate& c = fans.fan[k];
        if (!fans.has(k)) continue;
        if (bend) c.bid_on_edge(proposals.highest.edges.size());
        proposals.add(i, c, before - after, static_cast<std::uint32_t>(corners[i]), k);
      }
    }
    return 1;
  }

 private:
  TETUNE_HD bool find_sides(const BoundaryEdge& e, Fans& fans) const {
    return find(e, e.triangle, e.p, e.q, fans.fan[0]) && find(e, e.other, e.q, e.p, fans.fan[1]);
  }
  /// The fan of an edge of the outer boundary, and that of its image. Returns false where they share a tetrahedron.
  TETUNE_HD bool find_pair(const BoundaryEdge& e, const BoundaryEdge& image, Fans& fans) const {
    for (int k = 0; k < 2; ++k) {
      Fans sides;
      if (!find_sides(k == 0 ? e : image, sides) || sides.has(0) == sides.has(1)) return false;
      fans.fan[k] = sides.fan[sides.has(0) ? 0 : 1];
    }
    for (int i = 0; i < fans.fan[0].old_count(); ++i) {
      for (int j = 0; j < fans.fan[1].old_count(); ++j) {
        if (fans.fan[0].tets[i] == fans.fan[1].tets[j]) return false;
      }
    }
    return true;
  }
  /// The fan that turns from a to b about the edge, a < b, from a triangle (a, b, front) to (a, b, end); kind none
  /// where there is no tetrahedron on that side. Returns false where it has more than max_ring vertices, or another
  /// face in it is locked.
  TETUNE_HD bool find(const BoundaryEdge& edge, Index triangle, Index front, Index end, FlipCandidate& c) const {
    c.a = edge.a < edge.b ? edge.a : edge.b;
    c.b = edge.a < edge.b ? edge.b : edge.a;
    auto face = static_cast<HalfFace>(triangle2face[triangle]);
    if (start_face(face, c) != face_of(face)) {
      face = mesh.across(face);
      if (face == kNoHalfFace) return true;
    }
    EdgeWalk walk{front, face};
    int n = 0;
    do {
      if (n + 2 > max_ring) return false;
      c.ring[n] = walk.next_vertex;
      c.tets[n] = walk.tet();
      ++n;
    } while (walk.step(mesh));
    const Index last = mesh.opposite_vertex(walk.entry);
    if (n < 2 || last != end) return false;
    c.ring[n] = last;
    c.ring_size = static_cast<std::uint8_t>(n + 1);
    c.kind = FlipKind::boundary_removal;
    return true;
  }

  /// The face of the tetrahedron at `face` that a fan about (a, b) would start from.
  TETUNE_HD int start_face(HalfFace face, const FlipCandidate& c) const {
    const Tet tet = mesh.tet2vertex[tet_of(face)];
    const int a = local_index(tet, c.a);
    const int b = local_index(tet, c.b);
    const EdgeCorners e = edge_corners(edge_of(a, b));
    return a < b ? e.l : e.k;
  }
};

/// The two triangles at each flipped edge, and at its image, become those at the new one, each with its orientation.
struct FlipTriangles {
  FindEdge find;
  Span<const BoundaryEdge> edges;
  Span<const BoundaryEdge> images;
  Span<const Record<FlipCandidate>> records;
  Span<const Index> selected;
  Span<BoundaryTriangle> triangles;
  Span<std::uint8_t> is_edited;
  TETUNE_HD void operator()(Size i) const {
    const Record<FlipCandidate>& r = records[selected[i]];
    if (!r.is_leader(selected[i])) return;
    flip(edges[r.proposal]);
    if (images.size() > 0 && images[r.proposal].other >= 0) flip(images[r.proposal]);
  }

 private:
  TETUNE_HD void flip(const BoundaryEdge& e) const {
    BoundaryTriangle& triangle = triangles[e.triangle];
    BoundaryTriangle& other = triangles[e.other];
    mark_edited(triangle, is_edited);
    mark_edited(other, is_edited);
    int a = 0;
    while (other.v[a] != e.a) ++a;
    // Triangles of an interface may have different orientations.
    const bool is_same = other.v[(a + 1) % 3] != e.b;
    const Index first[3] = {e.a, e.q, e.p};
    const Index second[3] = {e.q, is_same ? e.b : e.p, is_same ? e.p : e.b};
    const unsigned first_features =
        bit(is_feature_edge(triangle, e.p, e.a), 1) | bit(is_feature_edge(other, e.a, e.q), 2);
    const unsigned second_features =
        bit(is_feature_edge(triangle, e.b, e.p), 0) | bit(is_feature_edge(other, e.q, e.b), is_same ? 2 : 1);
    if (find.adds_deviation(e)) triangle.deviation = other.deviation = find.deviation_after(e);
    triangle.features = first_features;
    other.features = second_features;
    for (int k = 0; k < 3; ++k) {
      triangle.v[k] = first[k];
      other.v[k] = second[k];
    }
  }
  TETUNE_HD static unsigned bit(bool is_set, unsigned k) { return is_set ? 1U << k : 0U; }
};

/// The corners opposite the edges that may be flipped with a gain.
template <class Backend>
auto find_corners(const Backend& backend, const FindEdge& find, Span<const std::uint8_t> changed) {
  const Size count = 3 * find.triangles.size();
  BufferOf<Backend, std::uint8_t> marks(backend, count);
  backend.for_each(count, MarkEdge{find, changed, marks.span()});
  BufferOf<Backend, Index> corners(backend, count);
  corners.resize(backend, backend.compact(count, IsMarkedCorner{marks.span()}, corners.span()));
  return corners;
}

/// Each triangle's face in the mesh, 4 * slot + face; of the triangles at edges with a `changed` end, or at their
/// periodic images.
template <class Backend>
auto find_faces(const Backend& backend, WorkMesh<Backend>& mesh, BoundaryTriangles<Backend>& boundary,
                Span<const std::uint8_t> changed) {
  BufferOf<Backend, Index> triangle2face(backend, boundary.triangles.size());
  if (boundary.images.members.size() > 0) changed = {};
  backend.for_each(mesh.slots(), FindFaces{mesh.view(), boundary.triangles.span(), boundary.vertex2corner.view(),
                                           changed, triangle2face.span()});
  return triangle2face;
}

}  // namespace boundary_flip_detail

template <class Backend>
PassResult boundary_flip_pass(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                              FlipState<Backend>& state, BoundaryTriangles<Backend>& boundary,
                              const CheckedSurfaceView& checked, Span<std::uint8_t> changed) {
  using namespace boundary_flip_detail;
  PassResult result;
  list_corners(backend, mesh, boundary);
  const FindEdge find{.points = mesh.points.span(),
                      .constrained = state.constrained(),
                      .triangles = boundary.triangles.span(),
                      .vertex2corner = boundary.vertex2corner.view(),
                      .flips_bend = boundary.flips_bend,
                      .limit = {boundary.max_bend, checked.edited_points},
                      .images = boundary.images.view()};
  auto corners = find_corners(backend, find, changed);
  const Size count = corners.size();
  result.active = count;
  if (count == 0 || backend.stop_requested()) return result;
  BufferOf<Backend, BoundaryEdge> edges(backend, count);
  BufferOf<Backend, BoundaryEdge> images(backend, boundary.images.members.size() > 0 ? count : 0);
  backend.for_each(count, FillEdge{find, corners.span(), edges.span(), images.span()});
  auto triangle2face = find_faces(backend, mesh, boundary, changed);

  const BoundaryFlipProposals<typename Backend::Pack> proposals{
      rated(mesh, criterion), edges.span(),          images.span(),  corners.span(),
      triangle2face.span(),   state.energies.span(), state.max_ring, boundary.flips_bend};
  auto selection = select_candidates(backend, mesh, count, proposals, state);
  result.evaluated = selection.evaluated;
  if (selection.size() == 0 || backend.stop_requested()) return result;
  result = flip_selected(backend, mesh, criterion, state, selection, changed);
  result.active = count;
  backend.for_each(selection.size(),
                   FlipTriangles{find, edges.span(), images.span(), selection.records.span(), selection.selected.span(),
                                 boundary.triangles.span(), checked.is_edited});
  boundary.stale = true;
  return result;
}

}  // namespace tetune

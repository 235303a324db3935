// SPDX-License-Identifier: Apache-2.0
#include "phases/restart/neighborhood.hpp"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "mesh/sorted.hpp"
#include "phases/restart/near_reference.hpp"

namespace tetune {
namespace {

/// The number of items per triangle or vertex of the reference surface.
Index items_of(SurfacePointKind kind) {
  return kind == SurfacePointKind::edge ? 3 : kind == SurfacePointKind::segment ? 2 : 1;
}

}  // namespace

CornersByVertex list_corners(const backend::Cpu& backend, const HostWork& whole) {
  CornersByVertex corners;
  build_csr(backend, whole.vertices(), 3 * std::ssize(whole.triangles),
            VertexOfCorner<BoundaryTriangle>{span_of(whole.triangles)}, corners);
  return corners;
}

Neighborhood::Neighborhood(const HostWork& whole, FoundTets found, const CornersByVertex& corners)
    : slot2whole_(std::move(found.slots)) {
  std::sort(slot2whole_.begin(), slot2whole_.end());
  std::sort(found.vertices.begin(), found.vertices.end(),
            [](const FoundTets::Vertex& a, const FoundTets::Vertex& b) { return a.vertex < b.vertex; });
  for (const FoundTets::Vertex& v : found.vertices) vertex2whole_.push_back(v.vertex);
  find_vertices(whole, corners);
  take_reference(whole);
  take_tets(whole);
  take_vertices(whole, found.vertices);
  take_triangles(whole, corners);
  take_edges(whole);
}

Index Neighborhood::vertex_of(Index of_whole) const { return position_in(vertex2whole_, of_whole); }

SurfacePoint Neighborhood::to_part(const SurfacePoint& on) const {
  if (on.kind == SurfacePointKind::none) return on;
  const bool is_triangle = on.kind == SurfacePointKind::triangle || on.kind == SurfacePointKind::edge;
  const Index each = items_of(on.kind);
  const Index item = position_in(is_triangle ? reference2whole_ : vertex2whole_, on.item / each);
  return item < 0 ? SurfacePoint{} : SurfacePoint{on.kind, each * item + on.item % each};
}

SurfacePoint Neighborhood::to_whole(const SurfacePoint& on) const {
  if (on.kind == SurfacePointKind::none) return on;
  const bool is_triangle = on.kind == SurfacePointKind::triangle || on.kind == SurfacePointKind::edge;
  const Index each = items_of(on.kind);
  const Index item = span_of(is_triangle ? reference2whole_ : vertex2whole_)[on.item / each];
  return {on.kind, each * item + on.item % each};
}

std::vector<Index> Neighborhood::triangles_inside(const HostWork& whole, const CornersByVertex& corners) const {
  const CsrView vertex2corner = corners.view();
  std::vector<Index> inside;
  for (const Index lowest : vertex2whole_) {
    for (Size at = vertex2corner.begin(lowest); at < vertex2corner.end(lowest); ++at) {
      const auto i = to_index(Size{vertex2corner.items[at] / 3});
      const BoundaryTriangle& t = span_of(whole.triangles)[i];
      const auto is_inside = [&](Index v) { return v >= lowest && vertex_of(v) >= 0; };
      if (std::all_of(t.v, t.v + 3, is_inside)) inside.push_back(i);
    }
  }
  std::sort(inside.begin(), inside.end());
  return inside;
}

void Neighborhood::find_vertices(const HostWork& whole, const CornersByVertex& corners) {
  if (whole.surface_point.empty()) return;

  // A vertex moves by at most its displacement bound, which is below the length of an edge.
  constexpr int kReferenceRings = 3;
  NearReference near(whole.reference);
  for (const Index v : vertex2whole_) {
    near.add(span_of(whole.surface_point)[v]);
    if (whole.checked.points.empty()) continue;
    near.add(span_of(whole.checked.surface_points)[v]);
    // The bound is tested on all triangles of the reference surface at v.
    if (v < std::ssize(whole.reference.points)) near.add({SurfacePointKind::vertex, v});
  }
  if (whole.bends) {
    for (const Index i : triangles_inside(whole, corners)) near.add_triangle(span_of(whole.triangles)[i].reference);
  }
  for (int ring = 0; ring < kReferenceRings; ++ring) near.add_ring();
  std::vector<Index> both;
  std::sort(near.vertices.begin(), near.vertices.end());
  std::set_union(vertex2whole_.begin(), vertex2whole_.end(), near.vertices.begin(), near.vertices.end(),
                 std::back_inserter(both));
  vertex2whole_.swap(both);
  for (const Index v : near.vertices) {
    for (const std::uint32_t corner : whole.reference.corners_at(v)) {
      const Index t = to_index(corner / 3);
      const auto& ends = span_of(whole.reference.triangles)[t].v;
      if (std::all_of(ends, ends + 3, [&](Index w) { return span_of(near.is_near)[w] != 0; })) {
        reference2whole_.push_back(t);
      }
    }
  }
  sort_unique(reference2whole_);
}

void Neighborhood::take_reference(const HostWork& whole) {
  if (whole.surface_point.empty()) return;
  const ReferenceSurfaceOnHost& from = whole.reference;
  ReferenceSurfaceOnHost to;
  for (const Index t : reference2whole_) {
    SurfaceTriangle triangle = span_of(from.triangles)[t];
    for (Index& v : triangle.v) v = vertex_of(v);
    to.triangles.push_back(triangle);
    for (Index k = 0; k < 3; ++k) {
      const Index across = span_of(from.across)[3 * t + k];
      const Index other = across == kFeatureEdge ? -1 : position_in(reference2whole_, across / 3);
      to.across.push_back(other < 0 ? kFeatureEdge : 3 * other + across % 3);
    }
  }
  to.offsets.push_back(0);
  for (const Index v : vertex2whole_) {
    if (v >= std::ssize(from.points)) break;  // inserted, as are all that follow
    bool is_cut = false;
    LineVertex line{{-1, -1}};
    for (const std::uint32_t corner : from.corners_at(v)) {
      const Index t = position_in(reference2whole_, to_index(corner / 3));
      is_cut = is_cut || t < 0;
      if (t >= 0) to.corners.push_back(3 * std::uint32_t(t) + corner % 3);
    }
    VertexDof dof = span_of(from.dof)[v];
    if (dof == VertexDof::curve) {
      for (int side = 0; side < 2; ++side) {
        line.next[side] = vertex_of(span_of(from.line)[v].next[side]);
        is_cut = is_cut || line.next[side] < 0;
      }
    }
    if (is_cut) dof = VertexDof::fixed;
    to.offsets.push_back(std::uint32_t(to.corners.size()));
    to.points.push_back(span_of(from.points)[v]);
    to.line.push_back(line);
    to.dof.push_back(dof);
  }
  work.dofs.reference.upload(backend_, to);
}

void Neighborhood::take_tets(const HostWork& whole) {
  std::vector<Tet> tets;
  std::vector<FaceAdjacency> links;
  std::vector<Index> originals;
  for (const Index t : slot2whole_) {
    Tet tet = span_of(whole.tet2vertex)[t];
    for (int k = 0; k < 4; ++k) tet[k] = vertex_of(tet[k]);
    FaceAdjacency adjacency = span_of(whole.tet2tet)[t];
    for (int f = 0; f < 4; ++f) {
      HalfFace& across = adjacency[f];
      if (across == kNoHalfFace) continue;
      const Index other = position_in(slot2whole_, tet_of(across));
      if (other >= 0) {
        across = make_half_face(other, face_of(across)) | (across & kLocked);
      } else {
        const FaceKey key = face_key(tet, f);
        cut_.push_back({{key.low, key.middle, key.high}, across});
        across = kNoHalfFace;
      }
    }
    tets.push_back(tet);
    links.push_back(adjacency);
    originals.push_back(span_of(whole.tet2original)[t]);
  }
  std::sort(cut_.begin(), cut_.end(), [](const CutFace& a, const CutFace& b) { return a.v < b.v; });
  work.mesh.tet2vertex.upload(backend_, tets);
  work.mesh.tet2tet.upload(backend_, links);
  work.mesh.tet2original.upload(backend_, originals);
  work.flips.slack.resize(backend_, work.mesh.slots(), work.mesh.room());
  backend_.fill(work.flips.slack.span(), kUnknownSlack);
}

void Neighborhood::take_vertices(const HostWork& whole, const std::vector<FoundTets::Vertex>& found) {
  auto next = found.begin();
  for (const Index v : vertex2whole_) {
    const bool is_found = next != found.end() && next->vertex == v;
    ring_.push_back(is_found ? (next++)->ring : FoundTets::kNoRing);
  }
  HostWork::for_each_vertex_array(whole, work, [this](const auto& array, auto& buffer) {
    std::remove_cvref_t<decltype(array)> taken;
    if (!array.empty()) {
      taken.reserve(vertex2whole_.size());
      for (std::size_t v = 0; v < vertex2whole_.size(); ++v) {
        taken.push_back(vertex_to_part(span_of(array)[vertex2whole_[v]], Size(v)));
      }
    }
    buffer.upload(backend_, taken);
  });
  work.dofs.max_deviation = whole.max_deviation;
  work.dofs.active.resize(backend_, work.mesh.vertices());
  backend_.fill(work.dofs.active.span(), std::uint8_t{0});
}

void Neighborhood::take_triangles(const HostWork& whole, const CornersByVertex& corners) {
  std::vector<BoundaryTriangle> taken;
  for (const Index i : triangles_inside(whole, corners)) {
    BoundaryTriangle t = span_of(whole.triangles)[i];
    if (t.stays == kFlipsWithImage) continue;
    for (Index& v : t.v) v = vertex_of(v);
    // Operators refuse where a triangle is missing.
    if (std::none_of(t.v, t.v + 3, [this](Index v) { return moves(v); })) continue;
    if (whole.bends) t.reference = position_in(reference2whole_, t.reference);
    taken.push_back(t);
    triangle2whole_.push_back(i);
  }
  work.boundary.triangles.upload(backend_, taken);
  work.boundary.bends = work.boundary.flips_bend = whole.bends;
  work.boundary.max_bend = whole.max_bend;
}

void Neighborhood::take_edges(const HostWork& whole) {
  std::vector<std::uint64_t> keys;
  for (const Index low : vertex2whole_) {
    if (span_of(whole.constrained_vertex)[low] == 0) continue;
    const std::uint64_t first = ConstrainedEdges::edge_key(low, low);
    for (auto key = std::lower_bound(whole.constrained_keys.begin(), whole.constrained_keys.end(), first);
         key != whole.constrained_keys.end() && Index(*key >> 32) == low; ++key) {
      const Index high = vertex_of(Index(*key & 0xffffffffU));
      if (high >= 0) keys.push_back(ConstrainedEdges::edge_key(vertex_of(low), high));
    }
  }
  work.flips.constrained_keys.upload(backend_, keys);
}

bool Neighborhood::doubles_surface(const HostWork& whole, const CornersByVertex& corners) const {
  const Span<const BoundaryTriangle> triangles = span_of(whole.triangles);
  std::vector<std::uint64_t> edges;
  for (const Index i : triangle2whole_) {
    const Index* const v = triangles[i].v;
    for (int k = 0; k < 3; ++k) edges.push_back(ConstrainedEdges::edge_key(v[k], v[(k + 1) % 3]));
  }
  std::sort(edges.begin(), edges.end());
  const auto was_edge = [&](Index p, Index q) {
    return std::binary_search(edges.begin(), edges.end(), ConstrainedEdges::edge_key(p, q));
  };
  const Span<const BoundaryTriangle> now = work.boundary.triangles.span();
  for (Size i = 0; i < now.size(); ++i) {
    const BoundaryTriangle& t = now[i];
    Index v[3];
    for (int k = 0; k < 3; ++k) v[k] = t.v[k] < std::ssize(vertex2whole_) ? span_of(vertex2whole_)[t.v[k]] : -1;
    for (int k = 0; k < 3; ++k) {
      const Index p = v[k];
      const Index q = v[(k + 1) % 3];
      if (p >= 0 && q >= 0 && !was_edge(p, q) && have_edge(triangles, corners.view(), p, q)) return true;
    }
    if (*std::min_element(v, v + 3) < 0) continue;
    const Index same = find_triangle(triangles, corners.view(), v);
    if (same >= 0 && position_in(triangle2whole_, same) < 0) return true;
  }
  return false;
}

std::vector<std::uint8_t> Neighborhood::flags(int rings) const {
  std::vector<std::uint8_t> flags;
  for (const std::uint8_t ring : ring_) flags.push_back(ring <= rings ? 1 : 0);
  return flags;
}

void Neighborhood::put_back(HostWork& whole) {
  put_vertices(whole);
  put_slots(whole);
  put_tets(whole);
  put_triangles(whole);
}

void Neighborhood::put_vertices(HostWork& whole) {
  Index vertices = to_index(whole.vertices());
  for (Size v = std::ssize(vertex2whole_); v < work.mesh.vertices(); ++v) {
    const bool is_removed = work.mesh.vertex2original.span()[v] == kRemoved;
    vertex2whole_.push_back(is_removed ? -1 : vertices++);
  }
  HostWork::for_each_vertex_array(whole, work, [&](auto& array, const auto& buffer) {
    if (array.empty()) return;
    array.resize(to_size_t(vertices));
    for (Size v = 0; v < work.mesh.vertices(); ++v) {
      const Index to = span_of(vertex2whole_)[v];
      if (to >= 0 && moves(v)) span_of(array)[to] = vertex_to_whole(buffer.span()[v]);
    }
  });
  // Triangles at vertices that do not move may have changed as well.
  for (Size v = 0; v < work.dofs.checked.is_edited.size(); ++v) {
    const Index to = span_of(vertex2whole_)[v];
    if (to >= 0 && work.dofs.checked.is_edited.span()[v] != 0) span_of(whole.checked.is_edited)[to] = 1;
  }
}

void Neighborhood::put_slots(HostWork& whole) {
  const Size taken = std::ssize(slot2whole_);
  const MeshView mesh = work.mesh.view();
  for (Size t = 0; t < taken; ++t) {
    if (mesh.alive(t)) continue;
    span_of(whole.tet2vertex)[slot2whole_[to_size_t(t)]].v[0] = kFreeSlot;
    whole.free_slots.push_back(slot2whole_[to_size_t(t)]);
  }
  for (Size t = taken; t < work.mesh.slots(); ++t) {
    if (!mesh.alive(t)) {
      slot2whole_.push_back(-1);
    } else if (!whole.free_slots.empty()) {
      slot2whole_.push_back(whole.free_slots.back());
      whole.free_slots.pop_back();
    } else {
      slot2whole_.push_back(to_index(whole.tet2vertex.size()));
      whole.tet2vertex.emplace_back();
      whole.tet2tet.emplace_back();
      whole.tet2original.emplace_back();
    }
  }
}

void Neighborhood::put_tets(HostWork& whole) {
  const MeshView mesh = work.mesh.view();
  const auto across_cut = [&](const Tet& tet, int f) {
    const FaceKey key = face_key(tet, f);
    const std::array<Index, 3> v{key.low, key.middle, key.high};
    const auto found =
        std::lower_bound(cut_.begin(), cut_.end(), v, [](const CutFace& a, const auto& b) { return a.v < b; });
    return found != cut_.end() && found->v == v ? found->across : kNoHalfFace;
  };
  for (Size t = 0; t < work.mesh.slots(); ++t) {
    if (!mesh.alive(t)) continue;
    const Tet old = mesh.tet2vertex[t];
    const Index to = span_of(slot2whole_)[t];
    Tet tet = old;
    for (int k = 0; k < 4; ++k) tet[k] = span_of(vertex2whole_)[old[k]];
    FaceAdjacency adjacency = mesh.tet2tet[t];
    for (int f = 0; f < 4; ++f) {
      HalfFace& across = adjacency[f];
      if (across == kNoHalfFace) {
        across = across_cut(old, f);
        if (across != kNoHalfFace) {
          span_of(whole.tet2tet)[tet_of(across)][face_of(across)] = make_half_face(to, f) | (across & kLocked);
        }
      } else {
        across = make_half_face(span_of(slot2whole_)[tet_of(across)], face_of(across)) | (across & kLocked);
      }
    }
    span_of(whole.tet2vertex)[to] = tet;
    span_of(whole.tet2tet)[to] = adjacency;
    span_of(whole.tet2original)[to] = mesh.tet2original[t];
  }
}

void Neighborhood::put_triangles(HostWork& whole) const {
  const Span<const BoundaryTriangle> now = work.boundary.triangles.span();
  for (Size i = 0; i < now.size(); ++i) {
    BoundaryTriangle t = now[i];
    for (Index& v : t.v) v = span_of(vertex2whole_)[v];
    if (whole.bends) t.reference = span_of(reference2whole_)[t.reference];
    if (i < std::ssize(triangle2whole_)) {
      span_of(whole.triangles)[triangle2whole_[to_size_t(i)]] = t;
    } else {
      whole.triangles.push_back(t);
    }
  }
  for (Size i = now.size(); i < std::ssize(triangle2whole_); ++i) {
    span_of(whole.triangles)[triangle2whole_[to_size_t(i)]].v[0] = kRemoved;
  }
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "backend/atomic.hpp"
#include "boundary/periodic_images.hpp"
#include "boundary/surface.hpp"
#include "boundary/vertex_dof.hpp"
#include "energy/objective.hpp"

namespace tetune {

/// Values of BoundaryTriangle::stays other than 0: the triangle does not change; it may be flipped together with its
/// periodic image; it may be flipped with another one in its plane.
inline constexpr std::uint16_t kStays = 1;
inline constexpr std::uint16_t kFlipsWithImage = 2;
inline constexpr std::uint16_t kFlipsInPlane = 3;

/// A triangle of the boundary as boundary flips change it. "Boundary" is all that flips must preserve: the outer
/// boundary, interfaces and constrained triangles.
struct BoundaryTriangle {
  Index v[3];    ///< in the order of face_vertex()
  int tag;       ///< of its patch
  Index listed;  ///< its position in the caller's list, or -1
  /// With Boundary::slide, where operations may bend the surface: a triangle of the reference surface in the same
  /// sheet, the bound on the distance that these operations have added, and the feature edges: bit k is set where the
  /// edge opposite corner k is one.
  Index reference;
  double deviation;
  std::uint32_t features;
  std::uint16_t turned;  ///< the caller lists it in the opposite orientation
  std::uint16_t stays;   ///< 0, kStays, kFlipsWithImage or kFlipsInPlane
};
static_assert(sizeof(BoundaryTriangle) == 40, "copies between host and device read no padding");

/// The bound on the distance that operations on a curved surface add, in local lengths of its edges
/// (docs/method.md, "Vertices of the surface").
inline constexpr double kMaxBend = 0.15;

/// Where operations may bend the surface, and how far.
struct BendLimit {
  /// Beside kMaxBend: the part of a bound on the deviation of the surface that is left to operations; kInfeasible
  /// without such a bound.
  double max_bend = kInfeasible;
  /// With such a bound the distance that operations add is that of the edited surface (DeviationBound), or of the
  /// mesh's where that is larger. The positions of the vertices in the edited surface; empty without a bound.
  Span<const Point> edited = {};

  TETUNE_HD bool is_bounded() const { return edited.size() > 0; }
  /// The deviation of the triangles that an operation makes: its distance is added to the largest deviation of those
  /// that it replaces. kInfeasible beyond the limit.
  TETUNE_HD double add(double largest, double distance, double edge_length) const {
    const double sum = largest + distance;
    return sum <= kMaxBend * edge_length && sum <= max_bend ? sum : kInfeasible;
  }
  /// The deviation after an operation: the larger one of `deviation_of(points)` for the mesh's surface and for the
  /// edited one.
  template <class DeviationOf>
  TETUNE_HD double largest(Span<const Point> points, const DeviationOf& deviation_of) const {
    const double own = deviation_of(points);
    if (!is_bounded() || !(own < kInfeasible)) return own;
    const double of_edited = deviation_of(edited);
    return own > of_edited ? own : of_edited;
  }
};

/// Marks the vertices of a triangle that is replaced; they keep their checked positions. `is_edited`:
/// CheckedSurface::is_edited; empty without a bound on the deviation.
TETUNE_HD inline void mark_edited(const BoundaryTriangle& t, Span<std::uint8_t> is_edited) {
  if (is_edited.size() == 0) return;
  for (const Index v : t.v) backend::store_shared(is_edited[v], std::uint8_t{1});
}

TETUNE_HD inline bool has_vertex(const BoundaryTriangle& t, Index v) {
  return t.v[0] == v || t.v[1] == v || t.v[2] == v;
}
/// Whether the edge between two vertices of a triangle is a feature edge.
TETUNE_HD inline bool is_feature_edge(const BoundaryTriangle& t, Index a, Index b) {
  const int k = t.v[0] != a && t.v[0] != b ? 0 : t.v[1] != a && t.v[1] != b ? 1 : 2;
  return (t.features >> k & 1) != 0;
}
/// Whether two vertices have an edge of the surface. `vertex2corner`: BoundaryTriangles::vertex2corner.
TETUNE_HD inline bool have_edge(Span<const BoundaryTriangle> triangles, const CsrView& vertex2corner, Index p,
                                Index q) {
  const Index end = vertex2corner.shorter(p, q);
  for (Size c = vertex2corner.begin(end); c < vertex2corner.end(end); ++c) {
    if (has_vertex(triangles[vertex2corner.items[c] / 3], p ^ q ^ end)) return true;
  }
  return false;
}
/// Whether two triangles are in one patch.
TETUNE_HD inline bool in_one_patch(const BoundaryTriangle& t, const BoundaryTriangle& u) {
  return t.tag == u.tag && (t.listed < 0) == (u.listed < 0);
}

template <class Backend>
struct BoundaryTriangles {
  BufferOf<Backend, BoundaryTriangle> triangles;
  /// The corners 3 * triangle + k at each vertex.
  Csr<Backend> vertex2corner;
  bool stale = true;  ///< vertex2corner must be rebuilt
  /// Inserted and removed vertices may bend the surface within kMaxBend: new ones are on the reference surface, not in
  /// planes of the present one, which has left it where vertices slid.
  bool bends = false;
  /// Flips may bend it too, from improve_angles() on. Flips that lower the energy would use up the bound that the worst
  /// angles need.
  bool flips_bend = false;
  double max_bend = kInfeasible;  ///< see BendLimit
  /// The images of the vertices of triangles that flip with their image; empty if there is none.
  PeriodicImages<Backend> images;
};

/// Lists the corners at each vertex, if they are out of date.
template <class Backend>
void list_corners(const Backend& backend, const WorkMesh<Backend>& mesh, BoundaryTriangles<Backend>& boundary) {
  if (!boundary.stale) return;
  const Size corners = 3 * boundary.triangles.size();
  build_csr(backend, mesh.vertices(), corners, VertexOfCorner<BoundaryTriangle>{boundary.triangles.span()},
            boundary.vertex2corner, corners);
  boundary.stale = false;
}

/// Changes of the boundary, by entries of the caller's list of triangles.
struct ChangedTriangles {
  /// The entries whose triangle is another one, and that triangle.
  std::vector<std::pair<Index, std::array<Index, 3>>> changes;
  std::vector<std::uint8_t> is_present;  ///< per entry: a triangle of the boundary has it
  /// More triangles that descend from an entry, and that entry.
  std::vector<std::array<Index, 3>> more;
  std::vector<Index> origin;
};

/// Finds what operations have made of the caller's listed triangles, each in the orientation it had.
inline ChangedTriangles follow_changes(const std::vector<BoundaryTriangle>& boundary,
                                       const std::vector<Index>& vertex2original,
                                       const std::vector<std::array<Index, 3>>& triangles) {
  ChangedTriangles changed{{}, std::vector<std::uint8_t>(triangles.size(), 0), {}, {}};
  const Span<const Index> ids = span_of(vertex2original);
  for (const BoundaryTriangle& t : boundary) {
    if (t.listed < 0) continue;
    const std::array<Index, 3>& entry = span_of(triangles)[t.listed];
    std::array<Index, 3> now{ids[t.v[0]], ids[t.v[1]], ids[t.v[2]]};
    const bool is_same = std::is_permutation(now.begin(), now.end(), entry.begin());
    if (t.turned != 0) std::swap(now[1], now[2]);
    std::uint8_t& is_present = span_of(changed.is_present)[t.listed];
    if (is_present != 0) {
      changed.more.push_back(now);
      changed.origin.push_back(t.listed);
    } else if (!is_same) {
      changed.changes.emplace_back(t.listed, now);
    }
    is_present = 1;
  }
  return changed;
}

namespace boundary_triangles_detail {

/// Counts the listed triangles that name a face of the surface, and stores the position of the last one.
struct CountListed {
  Span<const Index> listed2triangle;
  Span<std::uint32_t> counts;
  Span<std::uint32_t> last;
  TETUNE_HD void operator()(Size i) const {
    const Index s = listed2triangle[i];
    if (s < 0) return;
    backend::atomic_add(counts[s], 1);
    backend::atomic_max(last[s], static_cast<std::uint32_t>(i));
  }
};

struct FillTriangle {
  Span<const SurfaceTriangle> surface;
  Span<const int> tags;
  ListedTriangles listed;
  Span<const std::uint32_t> counts;
  Span<const std::uint32_t> last;
  Span<const VertexConstraint> constraints;
  Span<BoundaryTriangle> triangles;
  TETUNE_HD void operator()(Size s) const {
    BoundaryTriangle t{};
    for (int k = 0; k < 3; ++k) t.v[k] = surface[s].v[k];
    t.tag = tags[s];
    t.listed = counts[s] == 0 ? -1 : to_index(last[s]);
    if (t.listed >= 0) {
      const ListedTriangle entry = listed[t.listed];
      const int first = entry.v[0] == t.v[0] ? 0 : entry.v[1] == t.v[0] ? 1 : 2;
      t.turned = entry.v[(first + 1) % 3] == t.v[1] ? 0 : 1;
    }
    // Triangles that are required or of a frozen patch have frozen vertices.
    const bool is_frozen = constraints[t.v[0]] == VertexConstraint::frozen &&
                           constraints[t.v[1]] == VertexConstraint::frozen &&
                           constraints[t.v[2]] == VertexConstraint::frozen;
    t.stays = is_frozen || counts[s] > 1 ? kStays : 0;
    triangles[s] = t;
  }
};

/// Of the triangles that periodic links alone freeze, those of periodic vertices flip with their image, and the others
/// stay.
struct PairTriangles {
  PeriodicImagesView images;
  Span<const VertexConstraint> constraints;
  Span<BoundaryTriangle> triangles;
  TETUNE_HD void operator()(Size s) const {
    BoundaryTriangle& t = triangles[s];
    bool is_frozen = t.stays == 0;
    bool is_periodic = true;
    for (const Index v : t.v) {
      is_frozen = is_frozen && constraints[v] == VertexConstraint::frozen;
      is_periodic = is_periodic && images.class_of(v) >= 0;
    }
    if (is_frozen) t.stays = is_periodic ? kFlipsWithImage : kStays;
  }
};

struct LinkReference {
  Span<const Index> across;
  Span<BoundaryTriangle> triangles;
  TETUNE_HD void operator()(Size s) const {
    unsigned features = 0;
    for (unsigned k = 0; k < 3; ++k) features |= across[3 * s + k] == kFeatureEdge ? 1U << k : 0U;
    triangles[s].features = features;
    triangles[s].reference = to_index(s);
  }
};

}  // namespace boundary_triangles_detail

/// Finds the feature edges of the boundary where it is the reference surface, given the corners across its edges, and
/// makes each triangle the reference of itself.
template <class Backend>
void link_to_reference(const Backend& backend, Span<const Index> across, BoundaryTriangles<Backend>& boundary) {
  backend.for_each(boundary.triangles.size(),
                   boundary_triangles_detail::LinkReference{across, boundary.triangles.span()});
}

/// Pairs the boundary triangles of periodic vertices. `constraints` has those of periodic links too, and
/// build_boundary() had those without.
template <class Backend>
void pair_triangles(const Backend& backend, Span<const VertexConstraint> constraints,
                    BoundaryTriangles<Backend>& boundary) {
  backend.for_each(boundary.triangles.size(), boundary_triangles_detail::PairTriangles{
                                                  boundary.images.view(), constraints, boundary.triangles.span()});
}

/// Builds the boundary triangles from the surface and the caller's list.
template <class Backend>
void build_boundary(const Backend& backend, const Surface<Backend>& surface, const ListedTriangles& listed,
                    Span<const VertexConstraint> constraints, BoundaryTriangles<Backend>& boundary) {
  using namespace boundary_triangles_detail;
  const Size faces = surface.triangles.size();
  BufferOf<Backend, std::uint32_t> counts(backend, faces);
  BufferOf<Backend, std::uint32_t> last(backend, faces);
  backend.fill(counts.span(), std::uint32_t{0});
  backend.fill(last.span(), std::uint32_t{0});
  backend.for_each(listed.size(), CountListed{surface.listed2triangle, counts, last});
  boundary.triangles.resize(backend, faces);
  backend.for_each(
      faces, FillTriangle{surface.triangles, surface.tags, listed, counts, last, constraints, boundary.triangles});
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/boundary_triangles.hpp"
#include "operators/engine/selection.hpp"
#include "operators/stars/star_cavity.hpp"

/// The boundary triangles, as operators that insert or remove vertices of the surface read and change them.
namespace tetune {

struct SurfaceTriangles {
  Span<const BoundaryTriangle> triangles;  ///< empty: the vertices of the surface stay
  CsrView vertex2corner;
  bool bends;                              ///< operations may bend the surface,
  BendLimit limit;                         ///< within this limit
  ReferenceView reference;                 ///< where it bends: the surface that its vertices slide on,
  Span<const SurfacePoint> surface_point;  ///< and their places there

  /// Whether a vertex is on the surface, among vertices that existed when the corners were listed.
  TETUNE_HD bool has(Index v) const { return vertex2corner.size(v) > 0; }
  /// The number of triangles that contain a simplex.
  TETUNE_HD int count(const SurfaceSimplex& simplex) const {
    int found = 0;
    const Index v = simplex.size > 1 ? vertex2corner.shorter(simplex.v[0], simplex.v[1]) : simplex.v[0];
    for (Size c = vertex2corner.begin(v); c < vertex2corner.end(v); ++c) {
      const BoundaryTriangle& t = triangles[vertex2corner.items[c] / 3];
      int shared = 0;
      for (const Index w : t.v) shared += simplex.has(w) ? 1 : 0;
      found += shared == simplex.size ? 1 : 0;
    }
    return found;
  }
  /// Finds the triangles that a cavity replaces. Returns false where one of them must stay, or where not all triangles
  /// at the simplex are on the cavity: parts of the mesh touch there.
  TETUNE_HD bool find_replaced(const StarCavity& star, const SurfaceSimplex& simplex,
                               ReplacedTriangles& replaced) const {
    if (count(simplex) != star.base_count()) return false;
    replaced.count = star.base_count();
    for (int i = 0; i < star.base_count(); ++i) {
      const Index t = find_triangle(triangles, vertex2corner, star.base(i).v);
      if (t < 0 || triangles[t].stays != 0) return false;
      replaced.triangle[i] = t;
    }
    return true;
  }
};

/// The normal of a triangle; its length is twice the area.
TETUNE_HD inline Vec3 area_normal(const MeshView& mesh, const LinkFace& f) {
  const Vec3 a = vec(mesh.points[f.v[0]]);
  return cross(vec(mesh.points[f.v[1]]) - a, vec(mesh.points[f.v[2]]) - a);
}

namespace surface_triangles_detail {

/// Whether one of the replaced triangles has a feature edge between two vertices.
TETUNE_HD inline bool had_feature_edge(const StarPatch& patch, Span<const BoundaryTriangle> triangles, Index a,
                                       Index b) {
  for (int i = 0; i < patch.replaced.count; ++i) {
    const BoundaryTriangle& t = triangles[patch.replaced.triangle[i]];
    if (has_vertex(t, a) && has_vertex(t, b) && is_feature_edge(t, a, b)) return true;
  }
  return false;
}

/// Whether the new edge between the apex and w is a feature edge: a part of the edge that a vertex was inserted on, or
/// the edge between w and one of the two vertices that a contraction made one.
TETUNE_HD inline bool has_feature_edge_to(const StarPatch& patch, Span<const BoundaryTriangle> triangles, Index w) {
  const SurfaceSimplex& s = patch.simplex;
  if (patch.is_inserted) return s.size == 2 && s.has(w) && had_feature_edge(patch, triangles, s.v[0], s.v[1]);
  return had_feature_edge(patch, triangles, s.v[0], w) || had_feature_edge(patch, triangles, patch.apex, w);
}

/// Makes the new triangles of each applied record, the first in place of the old one. Each is an old one with a vertex
/// of the simplex replaced by the apex, so it keeps orientation, tag and place in the caller's list.
struct ReplaceTriangles {
  Span<const Record<StarPatch>> records;
  Span<const Index> selected;
  Span<const ChangeCounts> before;
  Span<BoundaryTriangle> triangles;
  Size old_count;
  Span<std::uint8_t> is_edited;
  TETUNE_HD void operator()(Size i) const {
    const StarPatch& patch = records[selected[i]].patch;
    for (int k = 0; k < patch.replaced.count; ++k) mark_edited(triangles[patch.replaced.triangle[k]], is_edited);
    const int size = patch.simplex.size;
    unsigned features[3 * kMaxStarTriangles];
    for (int n = 0; n < patch.replaced.count * size; ++n) features[n] = new_features(patch, n / size, n % size);
    Size next = old_count + before[i].triangles;
    for (int k = 0; k < patch.replaced.count; ++k) {
      const BoundaryTriangle old = triangles[patch.replaced.triangle[k]];
      for (int s = 0; s < size; ++s) {
        BoundaryTriangle t = old;
        bool has_apex = false;
        for (Index& v : t.v) {
          has_apex = has_apex || v == patch.apex;
          v = v == patch.simplex.v[s] ? patch.apex : v;
        }
        if (has_apex) t.v[0] = kRemoved;
        t.features = features[k * size + s];
        t.deviation = patch.replaced.deviation;
        triangles[s == 0 ? patch.replaced.triangle[k] : next++] = t;
      }
    }
  }

 private:
  /// The feature edges of replaced triangle k with vertex s of the simplex replaced by the apex.
  TETUNE_HD unsigned new_features(const StarPatch& patch, int k, int s) const {
    const BoundaryTriangle& t = triangles[patch.replaced.triangle[k]];
    unsigned features = 0;
    for (unsigned c = 0; c < 3; ++c) {
      // The edge opposite corner c keeps its ends, or has the apex at one.
      const Index v = patch.simplex.v[s];
      const Index a = t.v[(c + 1) % 3];
      const Index b = t.v[(c + 2) % 3];
      const bool is_feature = t.v[c] == v ? is_feature_edge(t, a, b) : has_feature_edge_to(patch, triangles, a ^ b ^ v);
      features |= is_feature ? 1U << c : 0U;
    }
    return features;
  }
};

struct IsPresent {
  Span<const BoundaryTriangle> triangles;
  TETUNE_HD bool operator()(Size i) const { return triangles[i].v[0] != kRemoved; }
};

struct CopyTriangles {
  Span<const BoundaryTriangle> from;
  Span<const Index> kept;
  Span<BoundaryTriangle> to;
  TETUNE_HD void operator()(Size i) const { to[i] = from[kept[i]]; }
};

}  // namespace surface_triangles_detail

/// Updates the boundary triangles after the application of a selection. `is_edited`: CheckedSurface::is_edited.
template <class Backend>
void replace_triangles(const Backend& backend, Selection<Backend, StarPatch>& selection, Span<std::uint8_t> is_edited,
                       BoundaryTriangles<Backend>& boundary) {
  using namespace surface_triangles_detail;
  const Size old_count = boundary.triangles.size();
  if (old_count == 0) return;
  boundary.triangles.grow(backend, old_count + selection.total.triangles);
  backend.for_each(selection.size(),
                   ReplaceTriangles{selection.records.span(), selection.selected.span(), selection.before.span(),
                                    boundary.triangles.span(), old_count, is_edited});
  const Size count = boundary.triangles.size();
  BufferOf<Backend, Index> kept(backend, count);
  const Size present = backend.compact(count, IsPresent{boundary.triangles.span()}, kept.span());
  boundary.stale = true;
  if (present == count) return;
  BufferOf<Backend, BoundaryTriangle> triangles(backend, present);
  backend.for_each(present, CopyTriangles{boundary.triangles.span(), kept.span(), triangles.span()});
  boundary.triangles.swap(triangles);
}

}  // namespace tetune

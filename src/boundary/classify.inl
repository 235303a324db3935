// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>

#include "boundary/classify.hpp"
#include "core/connect.hpp"
#include "core/rows.hpp"
#include "par/atomic.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace classify_detail {

TETUNE_HD inline bool same_triangle(const Index a[3], const Index b[3]) {
  for (int k = 0; k < 3; ++k) {
    if (a[k] != b[0] && a[k] != b[1] && a[k] != b[2]) return false;
  }
  return true;
}

/// Boundary faces, and one side of each locked face.
struct IsSurfaceFace {
  Span<const Tet> tets;
  Span<const Links> links;
  TETUNE_HD bool operator()(Size item) const {
    if (tets[item >> 2].v[0] == kFreeSlot) return false;
    const Link link = links[item >> 2][static_cast<int>(item & 3)];
    return link == kNoLink || (is_locked(link) && (item >> 2) < link_tet(link));
  }
};

/// Corners are numbered in 32 bits.
inline void check_surface_size(Size faces) {
  constexpr Size kMost = std::numeric_limits<std::uint32_t>::max() / 3;
  if (faces <= kMost) return;
  throw MeshError("the mesh has " + std::to_string(faces) + " faces on its boundary and interfaces; at most " +
                  std::to_string(kMost) + " can be handled. Split the mesh, or weld the vertices that coincide.");
}

struct TriangleOfFace {
  Span<const Tet> tets;
  Span<const Index> faces;
  Span<SurfaceTriangle> triangles;
  TETUNE_HD void operator()(Size s) const {
    const Tet tet = tets[faces[s] >> 2];
    for (int k = 0; k < 3; ++k) triangles[s].v[k] = tet[face_vertex(faces[s] & 3, k)];
  }
};

struct VertexOfSurfaceCorner {
  Span<const SurfaceTriangle> triangles;
  TETUNE_HD Size operator()(Size corner) const { return triangles[corner / 3].v[corner % 3]; }
};

struct PendingSum {
  Size pending = 0;
  TETUNE_HD void merge(const PendingSum& other) { pending += other.pending; }
};

/// Looks a listed triangle up in the surface. Where several name one face, the last one with a tag gives it its tag.
struct MatchListed {
  Span<const SurfaceTriangle> triangles;
  RowsView vertex2corner;
  ListedTriangles listed;
  Span<Listed> state;
  Span<Index> listed2triangle;
  Span<std::uint32_t> triangle2listed;  ///< position + 1; 0: not listed with a tag
  TETUNE_HD PendingSum operator()(Size i) const {
    const ListedTriangle t = listed[i];
    const Index s = find(t.v);
    listed2triangle[i] = s;
    if (s < 0) {
      state[i] = t.locks != 0 ? Listed::absent : Listed::loose;
      return {t.locks};
    }
    state[i] = Listed::surface;
    if (t.tag != 0) par::atomic_max(triangle2listed[s], static_cast<std::uint32_t>(i + 1));
    return {};
  }

 private:
  TETUNE_HD Index find(const Index v[3]) const {
    const Index from = vertex2corner.shorter(vertex2corner.shorter(v[0], v[1]), v[2]);
    for (Size c = vertex2corner.begin(from); c < vertex2corner.end(from); ++c) {
      const std::uint32_t s = vertex2corner.items[c] / 3;
      if (same_triangle(triangles[s].v, v)) return static_cast<Index>(s);
    }
    return -1;
  }
};

/// Locks the faces of constraining triangles inside regions. The face and its other side both find the triangle, by
/// rows of the same vertex, so each thread writes only its own.
struct LockListed {
  MeshView mesh;
  RowsView vertex2tet;
  ListedTriangles listed;
  Span<const Listed> state;
  TETUNE_HD void operator()(Size i) const {
    if (state[i] != Listed::absent) return;
    const ListedTriangle t = listed[i];
    const Index from = vertex2tet.shorter(vertex2tet.shorter(t.v[0], t.v[1]), t.v[2]);
    for (Size c = vertex2tet.begin(from); c < vertex2tet.end(from); ++c) {
      const auto tet = static_cast<Index>(vertex2tet.items[c] >> 2);
      for (int f = 0; f < 4; ++f) {
        Index v[3];
        for (int k = 0; k < 3; ++k) v[k] = mesh.tet2vertex[tet][face_vertex(f, k)];
        if (same_triangle(v, t.v)) par::atomic_or(mesh.tet2tet[tet][f], kLocked);
      }
    }
  }
};

struct TagFaces {
  Span<const std::uint32_t> triangle2listed;
  ListedTriangles listed;
  Span<int> tags;
  TETUNE_HD void operator()(Size s) const {
    tags[s] = triangle2listed[s] == 0 ? 0 : listed[triangle2listed[s] - 1].tag;
  }
};

struct VertexOfEdgeEnd {
  Span<const Index> edges;
  TETUNE_HD Size operator()(Size item) const { return edges[item]; }
};

struct Classify {
  Span<const Point> points;
  Span<const SurfaceTriangle> triangles;
  Span<const int> tags;
  RowsView vertex2corner;
  Span<const Index> edges;
  RowsView vertex2edge_end;
  ConstrainedEdges constrained;
  Span<const std::uint8_t> frozen;
  bool surface_fixed;
  Span<Mobility> kind;
  Span<Vec3> axis;

  /// The two other vertices of a surface triangle at a vertex, in order.
  struct Wing {
    Index q1, q2;
    int tag;
  };
  TETUNE_HD Wing wing(Size corner_position) const {
    const std::uint32_t corner = vertex2corner.items[corner_position];
    const SurfaceTriangle t = triangles[corner / 3];
    const std::uint32_t k = corner % 3;
    return {t.v[k == 2 ? 0 : k + 1], t.v[k == 0 ? 2 : k - 1], tags[corner / 3]};
  }

  /// Directions of the feature edges at a vertex: at most two are kept.
  struct Features {
    int count = 0;
    Vec3 direction[2];
    TETUNE_HD void add(const Vec3& d) {
      if (count < 2) direction[count] = d;
      ++count;
    }
  };

  /// The wings of a vertex, each looked at from all others where they fit here, as those of most vertices do.
  class Wings {
   public:
    TETUNE_HD Wings(const Classify& classify, Size begin, Size end)
        : classify_(classify), begin_(begin), few_(end - begin <= kFew) {
      for (Size c = begin; few_ && c < end; ++c) kept_[c - begin] = classify.wing(c);
    }
    TETUNE_HD bool kept() const { return few_; }
    TETUNE_HD Wing operator()(Size c) const { return few_ ? kept_[c - begin_] : classify_.wing(c); }

   private:
    static constexpr Size kFew = 16;
    const Classify& classify_;
    Size begin_;
    bool few_;
    Wing kept_[kFew];
  };

  TETUNE_HD void operator()(Size v) const {
    Vec3 direction{0, 0, 0};
    kind[v] = mobility(static_cast<Index>(v), direction);
    axis[v] = direction;
  }

 private:
  struct Around {
    Index v;
    Vec3 x;
    Size begin, end;
    Wings wings;
  };

  TETUNE_HD Mobility mobility(Index v, Vec3& direction) const {
    const Size begin = vertex2corner.begin(v);
    const Size end = vertex2corner.end(v);
    const Size edge_begin = vertex2edge_end.begin(v);
    const Size edge_end = vertex2edge_end.end(v);
    if (frozen[v] == kFrozen || (surface_fixed && end > begin)) return Mobility::fixed;
    if (begin == end && edge_begin == edge_end) return Mobility::free;

    const Around around{v, vec(points[v]), begin, end, Wings(*this, begin, end)};
    // Edges that are features whatever their angle.
    Features features;
    for (Size e = edge_begin; e < edge_end; ++e) {
      features.add(vec(points[edges[static_cast<Size>(vertex2edge_end.items[e]) ^ 1]]) - around.x);
    }
    Features folds;
    for (Size c = begin; c < end; ++c) {
      const Wing w = around.wings(c);
      star_edge(around, c, w.q1, w.q2, w.tag, features, folds);
      star_edge(around, c, w.q2, w.q1, w.tag, features, folds);
      // Fixed, whatever else there is: along a feature, all that is folded beside it would be torn.
      if (features.count > 2 || folds.count > 2 || (features.count > 0 && folds.count > 0)) return Mobility::fixed;
    }
    // Without the folds, a sheet thinner than the tolerance would count as flat at its very rim.
    if (features.count == 0 && folds.count == 0 && is_flat(around, direction)) return Mobility::plane;
    return is_straight(around, features.count > 0 ? features : folds, direction) ? Mobility::line : Mobility::fixed;
  }

  /// Whether the triangles around lie in one plane, and its normal.
  TETUNE_HD bool is_flat(const Around& around, Vec3& unit) const {
    Vec3 normal{0, 0, 0};
    double length = 0;
    for (Size c = around.begin; c < around.end; ++c) {
      const Wing w = around.wings(c);
      const Vec3 e1 = vec(points[w.q1]) - around.x;
      const Vec3 e2 = vec(points[w.q2]) - around.x;
      Vec3 n = cross(e1, e2);
      // Interface triangles come from either side: take all normals to one half space.
      if (dot(n, normal) < 0) n = -1.0 * n;
      normal = normal + n;
      length += 0.5 * (norm(e1) + norm(e2));
    }
    const double size = norm(normal);
    if (!(size > 0)) return false;
    length /= static_cast<double>(around.end - around.begin);
    for (Size c = around.begin; c < around.end; ++c) {
      const Wing w = around.wings(c);
      const double height = dot(normal, vec(points[w.q1]) - around.x) / size;
      const double height2 = dot(normal, vec(points[w.q2]) - around.x) / size;
      if (!(std::fabs(height) <= kFlat * length && std::fabs(height2) <= kFlat * length)) return false;
    }
    unit = (1 / size) * normal;
    return true;
  }

  /// Whether two lines go on in one, along which the vertex can move in the planes of all triangles, and which way.
  TETUNE_HD bool is_straight(const Around& around, const Features& lines, Vec3& unit) const {
    if (lines.count != 2) return false;
    const Vec3 d0 = lines.direction[0];
    const Vec3 d1 = lines.direction[1];
    if (dot(d0, d1) >= 0) return false;
    const Vec3 way = d0 - d1;
    const Vec3 along = (1 / norm(way)) * way;
    if (norm(cross(d0, along)) > kFlat * norm(d0) || norm(cross(d1, along)) > kFlat * norm(d1)) return false;
    // Moving along the line leaves a triangle in its plane only if the plane contains the line.
    for (Size c = around.begin; c < around.end; ++c) {
      const Wing w = around.wings(c);
      const Vec3 e1 = vec(points[w.q1]) - around.x;
      const Vec3 e2 = vec(points[w.q2]) - around.x;
      const double longest = dot(e1, e1) > dot(e2, e2) ? dot(e1, e1) : dot(e2, e2);
      if (std::fabs(dot(cross(e1, e2), along)) > kFlat * longest) return false;
    }
    unit = along;
    return true;
  }

  /// The other triangles at an edge of the star: how many, and what is known of one.
  struct Other {
    Size count = 0;
    Index apex = -1;
    int tag = 0;
  };
  /// Of edge (v, q), besides the triangle at `c`. False where that is not the first: each edge is looked at once.
  TETUNE_HD bool find_other(const Around& around, Size c, Index q, Other& other) const {
    for (Size o = around.begin; o < around.end; ++o) {
      if (o == c) continue;
      const Wing w = around.wings(o);
      if (w.q1 != q && w.q2 != q) continue;
      if (o < c) return false;
      other = {other.count + 1, w.q1 == q ? w.q2 : w.q1, w.tag};
    }
    return true;
  }
  /// The same from the other end, where v has many triangles.
  TETUNE_HD bool find_other_at(Index q, const Around& around, Size c, Other& other) const {
    const std::uint32_t own = vertex2corner.items[c] / 3;
    for (Size o = vertex2corner.begin(q); o < vertex2corner.end(q); ++o) {
      const std::uint32_t triangle = vertex2corner.items[o] / 3;
      const Wing w = wing(o);
      if (triangle == own || (w.q1 != around.v && w.q2 != around.v)) continue;
      if (triangle < own) return false;
      other = {other.count + 1, w.q1 == around.v ? w.q2 : w.q1, w.tag};
    }
    return true;
  }

  /// Looks at the edge (v, q) of the star, seen from the triangle at `c` whose third vertex is `apex`.
  TETUNE_HD void star_edge(const Around& around, Size c, Index q, Index apex, int tag, Features& features,
                           Features& folds) const {
    if (constrained.contains(around.v, q)) return;  // counted already
    Other other;
    if (!(around.wings.kept() ? find_other(around, c, q, other) : find_other_at(q, around, c, other))) return;
    const Vec3 e = vec(points[q]) - around.x;
    if (other.count != 1 || other.tag != tag) {
      features.add(e);
      return;
    }
    const Vec3 p1 = vec(points[apex]) - around.x;
    const Vec3 p2 = vec(points[other.apex]) - around.x;
    const Vec3 n1 = cross(e, p1);
    const Vec3 n2 = cross(p2, e);
    const bool first_larger = dot(n1, n1) > dot(n2, n2);
    const Vec3 n = first_larger ? n1 : n2;
    const Vec3 far = first_larger ? p2 : p1;
    // Folded: the apex of the smaller triangle stands off the plane of the larger one, or they lie on each other.
    if (std::fabs(dot(n, far)) > kFlat * norm(e) * norm(n) || dot(n1, n2) <= 0) folds.add(e);
  }
};

struct CountCorners {
  Span<const std::uint8_t> frozen;
  Span<const Mobility> kind;
  TETUNE_HD PlainCount operator()(Size v) const {
    return {kind[v] != Mobility::free ? 1 : 0, frozen[v] == kCorner && kind[v] != Mobility::fixed ? 1 : 0};
  }
};

struct HoldCorner {
  Span<const std::uint8_t> frozen;
  Span<Mobility> kind;
  TETUNE_HD void operator()(Size v) const {
    if (frozen[v] == kCorner) kind[v] = Mobility::fixed;
  }
};

}  // namespace classify_detail

template <class Backend>
void collect_surface(const Backend& par, WorkMesh<Backend>& mesh, Surface<Backend>& surface) {
  using namespace classify_detail;
  typename Backend::template Buffer<Index> faces(4 * mesh.slots());
  const Size count =
      par.compact(4 * mesh.slots(), IsSurfaceFace{mesh.tet2vertex.span(), mesh.tet2tet.span()}, faces.span());
  check_surface_size(count);
  surface.triangles.resize(count);
  par.for_each(count, TriangleOfFace{mesh.tet2vertex.span(), faces.span(), surface.triangles.span()});
  build_rows(par, mesh.vertices(), 3 * count, VertexOfSurfaceCorner{surface.triangles.span()}, surface.vertex2corner);
}

template <class Backend>
void build_surface(const Backend& par, WorkMesh<Backend>& mesh, const ListedTriangles& listed,
                   typename Backend::template Buffer<Listed>& listed_state, Surface<Backend>& surface) {
  using namespace classify_detail;
  collect_surface(par, mesh, surface);
  listed_state.resize(listed.size());
  surface.listed2triangle.resize(listed.size());
  typename Backend::template Buffer<std::uint32_t> triangle2listed;
  const auto match = [&]() {
    triangle2listed.resize(surface.triangles.size());
    par.fill(triangle2listed.span(), std::uint32_t{0});
    return par
        .template reduce<PendingSum>(
            listed.size(), MatchListed{surface.triangles.span(), surface.vertex2corner.view(), listed,
                                       listed_state.span(), surface.listed2triangle.span(), triangle2listed.span()})
        .pending;
  };
  if (match() > 0) {
    Rows<Backend> vertex2tet;
    build_vertex2tet(par, mesh, vertex2tet);
    par.for_each(listed.size(), LockListed{mesh.view(), vertex2tet.view(), listed, listed_state.span()});
    collect_surface(par, mesh, surface);
    match();
  }
  surface.tags.resize(surface.triangles.size());
  par.for_each(surface.triangles.size(), TagFaces{triangle2listed.span(), listed, surface.tags.span()});
}

template <class Backend>
void classify_vertices(const Backend& par, WorkMesh<Backend>& mesh, const Surface<Backend>& surface,
                       Span<const Index> edges, const ConstrainedEdges& constrained, Span<const std::uint8_t> frozen,
                       bool surface_fixed, Span<Mobility> kind, Span<Vec3> axis) {
  using namespace classify_detail;
  Rows<Backend> vertex2edge_end;
  build_rows(par, mesh.vertices(), edges.size(), VertexOfEdgeEnd{edges}, vertex2edge_end);
  par.for_each(mesh.vertices(),
               Classify{mesh.points.span(), surface.triangles.span(), surface.tags.span(), surface.vertex2corner.view(),
                        edges, vertex2edge_end.view(), constrained, frozen, surface_fixed, kind, axis});
}

template <class Backend>
Size hold_corners(const Backend& par, Span<const std::uint8_t> frozen, Span<Mobility> kind) {
  using namespace classify_detail;
  const auto count = par.template reduce<PlainCount>(kind.size(), CountCorners{frozen, kind});
  if (!count.few()) return count.plain;
  par.for_each(kind.size(), HoldCorner{frozen, kind});
  return 0;
}

}  // namespace tetune

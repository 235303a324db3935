// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "boundary/surface.hpp"
#include "boundary/vertex_dof.hpp"
#include "mesh/constrained_edges.hpp"

namespace tetune {

/// Vertices of the surface that may move within planes and along straight lines, so that its shape stays as it is.

/// Distances from a plane or line below this part of the local edge length count as zero. A vertex that moves in such a
/// plane changes the surface by at most about that much.
inline constexpr double kFlat = 1e-6;

/// The number of corners, or junctions of feature lines, that only a list names and the geometry does not show.
/// Heuristic: where these are more than 10 and more than 5 % of the constrained vertices, the list is no list of
/// features (TetGen lists every vertex and edge of its input).
struct ListedOnlyCount {
  Size constrained = 0;  ///< vertices that are not free
  Size listed_only = 0;
  bool are_features() const { return listed_only <= 10 || 20 * listed_only <= constrained; }
};

/// Whether the edges of a list from entry `first` of `ends` on can be feature lines, given where vertices may go
/// without them: feature lines meet in few places. (TetGen lists and tags all edges of its input.)
inline bool are_feature_lines(Span<const Index> ends, Size first, Span<const VertexDof> dof) {
  std::vector<std::uint8_t> degree(to_size_t(dof.size()), 0);
  for (Size i = first; i < ends.size(); ++i) {
    std::uint8_t& d = span_of(degree)[ends[i]];
    if (d < 3) ++d;
  }
  ListedOnlyCount count;
  for (Size v = 0; v < dof.size(); ++v) {
    if (dof[v] != VertexDof::free) ++count.constrained;
    if (dof[v] != VertexDof::fixed && span_of(degree)[v] > 2) ++count.listed_only;
  }
  return count.are_features();
}

/// Fixes the listed corners, unless the list is not one of corners (see ListedOnlyCount): returns then the number of
/// listed vertices that it leaves movable, else 0.
inline Size fix_corners(Span<const std::uint8_t> frozen, Span<VertexDof> dof) {
  ListedOnlyCount count;
  for (Size v = 0; v < dof.size(); ++v) {
    if (dof[v] != VertexDof::free) ++count.constrained;
    if (frozen[v] == kCorner && dof[v] != VertexDof::fixed) ++count.listed_only;
  }
  if (!count.are_features()) return count.listed_only;
  for (Size v = 0; v < dof.size(); ++v) {
    if (frozen[v] == kCorner) dof[v] = VertexDof::fixed;
  }
  return 0;
}

namespace classify_detail {

struct ClassifyVertex {
  Span<const Point> points;
  Span<const SurfaceTriangle> triangles;
  Span<const int> tags;
  CsrView vertex2corner;
  Span<const Index> edges;
  CsrView vertex2edge_end;
  ConstrainedEdges constrained;
  Span<const std::uint8_t> frozen;
  bool surface_fixed;
  Span<VertexDof> dof;
  Span<Vec3> axis;

  TETUNE_HD void operator()(Size v) const {
    Vec3 direction{0, 0, 0};
    dof[v] = classify(to_index(v), direction);
    axis[v] = direction;
  }

 private:
  /// A surface triangle at a vertex: its two other vertices, in order, and its tag.
  struct FanTriangle {
    Index q1, q2;
    int tag;
  };
  TETUNE_HD FanTriangle fan_triangle(Size corner_position) const {
    const std::uint32_t corner = vertex2corner.items[corner_position];
    const SurfaceTriangle t = triangles[corner / 3];
    const std::uint32_t k = corner % 3;
    return {t.v[k == 2 ? 0 : k + 1], t.v[k == 0 ? 2 : k - 1], tags[corner / 3]};
  }

  /// The surface triangles at a vertex. A fan of ordinary size is copied, as each triangle is compared with all others.
  struct Fan {
    static constexpr Size kMaxCopied = 16;
    Index v;
    Vec3 x;
    Size begin, end;
    FanTriangle copies[kMaxCopied];
    TETUNE_HD bool copied() const { return end - begin <= kMaxCopied; }
  };
  TETUNE_HD Fan fan_of(Index v) const {
    Fan fan;
    fan.v = v;
    fan.x = vec(points[v]);
    fan.begin = vertex2corner.begin(v);
    fan.end = vertex2corner.end(v);
    for (Size c = fan.begin; fan.copied() && c < fan.end; ++c) fan.copies[c - fan.begin] = fan_triangle(c);
    return fan;
  }
  TETUNE_HD FanTriangle triangle(const Fan& fan, Size c) const {
    return fan.copied() ? fan.copies[c - fan.begin] : fan_triangle(c);
  }

  /// Directions of the edges of one kind at a vertex; the first two are stored.
  struct EdgeDirections {
    int count = 0;
    Vec3 direction[2];
    TETUNE_HD void add(const Vec3& d) {
      if (count < 2) direction[count] = d;
      ++count;
    }
  };

  TETUNE_HD VertexDof classify(Index v, Vec3& direction) const {
    const Size surface_corners = vertex2corner.size(v);
    const Size edge_begin = vertex2edge_end.begin(v);
    const Size edge_end = vertex2edge_end.end(v);
    if (frozen[v] == kFrozen || (surface_fixed && surface_corners > 0)) return VertexDof::fixed;
    if (surface_corners == 0 && edge_begin == edge_end) return VertexDof::free;

    const Fan fan = fan_of(v);
    // Feature edges whatever their angle; constrained edges come first.
    EdgeDirections features;
    for (Size e = edge_begin; e < edge_end; ++e) {
      features.add(vec(points[edges[Size{vertex2edge_end.items[e]} ^ 1]]) - fan.x);
    }
    EdgeDirections folds;
    for (Size c = fan.begin; c < fan.end; ++c) {
      const FanTriangle t = triangle(fan, c);
      add_edge(fan, c, t.q1, t.q2, t.tag, features, folds);
      add_edge(fan, c, t.q2, t.q1, t.tag, features, folds);
      // Motion along a feature would tear folds beside it, so a vertex with both is fixed.
      if (features.count > 2 || folds.count > 2 || (features.count > 0 && folds.count > 0)) return VertexDof::fixed;
    }
    // The test for folds comes first: without it, a sheet thinner than the tolerance would count as flat at its border.
    if (features.count == 0 && folds.count == 0 && is_flat(fan, direction)) return VertexDof::plane;
    return is_straight(fan, features.count > 0 ? features : folds, direction) ? VertexDof::line : VertexDof::fixed;
  }

  /// Whether the triangles of the fan lie in one plane; `unit` receives its normal.
  TETUNE_HD bool is_flat(const Fan& fan, Vec3& unit) const {
    Vec3 normal{0, 0, 0};
    double length = 0;
    for (Size c = fan.begin; c < fan.end; ++c) {
      const FanTriangle t = triangle(fan, c);
      const Vec3 e1 = vec(points[t.q1]) - fan.x;
      const Vec3 e2 = vec(points[t.q2]) - fan.x;
      Vec3 n = cross(e1, e2);
      // Interface triangles come from either side: turn all normals into one half space.
      if (dot(n, normal) < 0) n = -1.0 * n;
      normal = normal + n;
      length += 0.5 * (norm(e1) + norm(e2));
    }
    const double size = norm(normal);
    if (!(size > 0)) return false;
    length /= static_cast<double>(fan.end - fan.begin);
    for (Size c = fan.begin; c < fan.end; ++c) {
      const FanTriangle t = triangle(fan, c);
      const double height = dot(normal, vec(points[t.q1]) - fan.x) / size;
      const double height2 = dot(normal, vec(points[t.q2]) - fan.x) / size;
      if (!(std::fabs(height) <= kFlat * length && std::fabs(height2) <= kFlat * length)) return false;
    }
    unit = (1 / size) * normal;
    return true;
  }

  /// Whether two edges form one straight line that lies in the planes of all triangles; `unit` receives its direction.
  TETUNE_HD bool is_straight(const Fan& fan, const EdgeDirections& lines, Vec3& unit) const {
    if (lines.count != 2) return false;
    const Vec3 d0 = lines.direction[0];
    const Vec3 d1 = lines.direction[1];
    if (dot(d0, d1) >= 0) return false;
    const Vec3 difference = d0 - d1;
    const Vec3 along = (1 / norm(difference)) * difference;
    if (norm(cross(d0, along)) > kFlat * norm(d0) || norm(cross(d1, along)) > kFlat * norm(d1)) return false;
    // Motion along the line leaves a triangle in its plane only if the plane contains the line.
    for (Size c = fan.begin; c < fan.end; ++c) {
      const FanTriangle t = triangle(fan, c);
      const Vec3 e1 = vec(points[t.q1]) - fan.x;
      const Vec3 e2 = vec(points[t.q2]) - fan.x;
      const double longest = dot(e1, e1) > dot(e2, e2) ? dot(e1, e1) : dot(e2, e2);
      if (std::fabs(dot(cross(e1, e2), along)) > kFlat * longest) return false;
    }
    unit = along;
    return true;
  }

  /// The triangles at an edge besides a given one: their number, and the apex and tag of the last.
  struct OtherTriangles {
    Size count = 0;
    Index apex = -1;
    int tag = 0;
  };
  /// Finds those at edge (v, q) besides the triangle at `c`. False where `c` is not the first triangle of the edge, so
  /// that each edge is processed once.
  TETUNE_HD bool find_others(const Fan& fan, Size c, Index q, OtherTriangles& others) const {
    for (Size o = fan.begin; o < fan.end; ++o) {
      if (o == c) continue;
      const FanTriangle t = triangle(fan, o);
      if (t.q1 != q && t.q2 != q) continue;
      if (o < c) return false;
      others = {others.count + 1, t.q1 == q ? t.q2 : t.q1, t.tag};
    }
    return true;
  }
  /// Same as find_others(), from the triangles at q: for a vertex v of many triangles.
  TETUNE_HD bool find_others_at(Index q, const Fan& fan, Size c, OtherTriangles& others) const {
    const std::uint32_t own = vertex2corner.items[c] / 3;
    for (Size o = vertex2corner.begin(q); o < vertex2corner.end(q); ++o) {
      const std::uint32_t other = vertex2corner.items[o] / 3;
      const FanTriangle t = fan_triangle(o);
      if (other == own || (t.q1 != fan.v && t.q2 != fan.v)) continue;
      if (other < own) return false;
      others = {others.count + 1, t.q1 == fan.v ? t.q2 : t.q1, t.tag};
    }
    return true;
  }

  /// Classifies the edge (v, q) of the fan's triangle at `c`, whose third vertex is `apex`, as feature, fold or
  /// neither.
  TETUNE_HD void add_edge(const Fan& fan, Size c, Index q, Index apex, int tag, EdgeDirections& features,
                          EdgeDirections& folds) const {
    if (constrained.contains(fan.v, q)) return;  // counted already
    OtherTriangles others;
    if (!(fan.copied() ? find_others(fan, c, q, others) : find_others_at(q, fan, c, others))) return;
    const Vec3 e = vec(points[q]) - fan.x;
    if (others.count != 1 || others.tag != tag) {
      features.add(e);
      return;
    }
    const Vec3 p1 = vec(points[apex]) - fan.x;
    const Vec3 p2 = vec(points[others.apex]) - fan.x;
    const Vec3 n1 = cross(e, p1);
    const Vec3 n2 = cross(p2, e);
    const bool first_larger = dot(n1, n1) > dot(n2, n2);
    const Vec3 n = first_larger ? n1 : n2;
    const Vec3 far = first_larger ? p2 : p1;
    // A fold: the apex of the smaller triangle is off the plane of the larger one, or the triangles overlap.
    if (std::fabs(dot(n, far)) > kFlat * norm(e) * norm(n) || dot(n1, n2) <= 0) folds.add(e);
  }
};

}  // namespace classify_detail

/// Decides for each vertex where it may go without changing the surface (Sect. 4.2, Alg. 2):
///   free   not on the surface and on no constrained edge
///   plane  V_F: its triangles lie in one plane, none folded back on another, and have one tag
///   line   V_E: the planes of all its triangles contain one line, along which its two feature edges run. Feature edges
///          are folds, borders between tags, edges not on two triangles, and the constrained edges
///   fixed  V_C: all others; with `surface_fixed` the whole surface; and where `frozen` is kFrozen
/// `edges` are the constrained edges, as pairs of work vertices. `axis` receives the direction of the line or the
/// normal of the plane.
template <class Backend>
void classify_vertices(const Backend& backend, WorkMesh<Backend>& mesh, const Surface<Backend>& surface,
                       Span<const Index> edges, const ConstrainedEdges& constrained, Span<const std::uint8_t> frozen,
                       bool surface_fixed, Span<VertexDof> dof, Span<Vec3> axis) {
  Csr<Backend> vertex2edge_end;
  build_csr(backend, mesh.vertices(), edges.size(), VertexOfEdgeEnd{edges}, vertex2edge_end);
  backend.for_each(mesh.vertices(), classify_detail::ClassifyVertex{
                                        mesh.points, surface.triangles, surface.tags, surface.vertex2corner.view(),
                                        edges, vertex2edge_end.view(), constrained, frozen, surface_fixed, dof, axis});
}

}  // namespace tetune

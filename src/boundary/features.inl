// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include "boundary/classify.inl"
#include "boundary/features.hpp"

namespace tetune {
namespace features_detail {

/// What lies across the edge of a corner; kWall where it is not on exactly two triangles.
TETUNE_HD inline Index opposite_corner(Span<const SurfaceTriangle> triangles, const RowsView& vertex2corner,
                                       Size corner) {
  const Size triangle = corner / 3;
  const SurfaceTriangle t = triangles[triangle];
  const Index a = t.v[(corner + 1) % 3];
  const Index b = t.v[(corner + 2) % 3];
  const Index from = vertex2corner.shorter(a, b);
  const Index to = a ^ b ^ from;
  Index opposite = kWall;
  for (Size c = vertex2corner.begin(from); c < vertex2corner.end(from); ++c) {
    const Size other = vertex2corner.items[c] / 3;
    if (other == triangle) continue;
    const SurfaceTriangle q = triangles[other];
    const int end = q.v[0] == to ? 0 : q.v[1] == to ? 1 : q.v[2] == to ? 2 : -1;
    if (end < 0) continue;
    if (opposite != kWall) return kWall;
    opposite = static_cast<Index>(3 * other + 3 - end - vertex2corner.items[c] % 3);
  }
  return opposite;
}

/// Finds what lies across each edge, or that it is a feature.
struct FindAcross {
  Span<const Point> points;
  Span<const SurfaceTriangle> triangles;
  Span<const int> tags;
  RowsView vertex2corner;
  ConstrainedEdges constrained;
  double cos_angle;
  Span<Index> across;

  TETUNE_HD void operator()(Size corner) const {
    across[corner] = kWall;
    const Size triangle = corner / 3;
    const auto k = static_cast<int>(corner % 3);
    const SurfaceTriangle t = triangles[triangle];
    const Index a = t.v[(k + 1) % 3];
    const Index b = t.v[(k + 2) % 3];
    if (constrained.contains(a, b)) return;
    const Index opposite = opposite_corner(triangles, vertex2corner, corner);
    if (opposite == kWall || tags[opposite / 3] != tags[triangle]) return;
    const Vec3 x = vec(points[a]);
    const Vec3 e = vec(points[b]) - x;
    const Vec3 n1 = cross(e, vec(points[t.v[k]]) - x);
    const Vec3 n2 = cross(vec(points[triangles[opposite / 3].v[opposite % 3]]) - x, e);
    // Of their lengths, as the product of their squares underflows in a small part of a large mesh.
    if (dot(n1, n2) < cos_angle * (norm(n1) * norm(n2))) return;
    across[corner] = opposite;
  }
};

struct ClassifySliding {
  Span<const Point> points;
  Span<const SurfaceTriangle> triangles;
  Span<const Index> across;
  RowsView vertex2corner;
  Span<const Index> edges;
  RowsView vertex2edge_end;
  Span<const std::uint8_t> frozen;
  double cos_angle;
  Span<Mobility> kind;
  Span<LineVertex> line;

  TETUNE_HD void operator()(Size v) const {
    line[v] = {{-1, -1}};
    kind[v] = Mobility::fixed;
    if (frozen[v] == kFrozen) return;
    const Size begin = vertex2corner.begin(v);
    const Size end = vertex2corner.end(v);
    const bool on_edge = vertex2edge_end.end(v) > vertex2edge_end.begin(v);
    if (begin == end && !on_edge) {
      kind[v] = Mobility::free;
      return;
    }

    // The feature edges at the vertex: walls of the surface, and constrained edges.
    int features = 0;
    Index next[2] = {-1, -1};
    const auto add = [&](Index q) {
      if (features > 2 || (features > 0 && next[0] == q) || (features > 1 && next[1] == q)) return;
      if (features < 2) next[features] = q;
      ++features;
    };
    for (Size e = vertex2edge_end.begin(v); e < vertex2edge_end.end(v); ++e) {
      add(edges[static_cast<Size>(vertex2edge_end.items[e]) ^ 1]);
    }
    Size reached = 0;
    for (Size c = begin; c < end; ++c) {
      const std::uint32_t corner = vertex2corner.items[c];
      for (int side = 1; side <= 2; ++side) {
        if (across_edge(corner, side) != kWall) continue;
        add(other_end(corner, side));
        reached += sector(corner, side, end - begin);
      }
    }
    if (features == 0) {
      // One closed fan; sheets that only touch here have several.
      if (end > begin && sector(vertex2corner.items[begin], 1, end - begin) == end - begin) kind[v] = Mobility::surface;
      return;
    }
    // Each sector between two features was walked from both its ends; what was not reached is a sheet that touches.
    if (features != 2 || reached != 2 * (end - begin)) return;
    const Vec3 x = vec(points[v]);
    const Vec3 d0 = vec(points[next[0]]) - x;
    const Vec3 d1 = vec(points[next[1]]) - x;
    if (-dot(d0, d1) < cos_angle * norm(d0) * norm(d1)) return;
    kind[v] = Mobility::curve;
    line[v] = {{next[0], next[1]}};
  }

 private:
  /// Across the edge of a vertex's triangle that runs to the next (side 1) or the one after (side 2) of its vertices.
  TETUNE_HD Index across_edge(std::uint32_t corner, int side) const {
    return across[Size{corner / 3} * 3 + (corner + 3 - static_cast<std::uint32_t>(side)) % 3];
  }
  TETUNE_HD Index other_end(std::uint32_t corner, int side) const {
    return triangles[corner / 3].v[(corner + static_cast<std::uint32_t>(side)) % 3];
  }

  /// Number of triangles from this one on around the vertex, away from the edge on `side`, to the next wall or back to
  /// the start; at most one more than `most`.
  TETUNE_HD Size sector(std::uint32_t corner, int side, Size most) const {
    const std::uint32_t start = corner;
    Size count = 0;
    do {
      ++count;
      // Leave by the other edge, and enter the next triangle by it.
      const Index through = across_edge(corner, 3 - side);
      if (through == kWall) break;
      const Index shared = other_end(corner, 3 - side);
      const auto opposite = static_cast<std::uint32_t>(through);
      const SurfaceTriangle t = triangles[opposite / 3];
      const std::uint32_t k = opposite % 3;
      // Of the two ends of the edge opposite `through`, one is shared, the other is the vertex.
      const std::uint32_t at = t.v[(k + 1) % 3] == shared ? (k + 2) % 3 : (k + 1) % 3;
      corner = opposite / 3 * 3 + at;
      side = t.v[(at + 1) % 3] == shared ? 1 : 2;
    } while (corner != start && count <= most);
    return count;
  }
};

}  // namespace features_detail

template <class Backend>
void build_reference(const Backend& par, WorkMesh<Backend>& mesh, const Surface<Backend>& surface,
                     Span<const Index> edges, const ConstrainedEdges& constrained, Span<const std::uint8_t> frozen,
                     double feature_angle, Span<Mobility> kind, ReferenceSurface<Backend>& reference) {
  using namespace features_detail;
  const Size vertices = mesh.vertices();
  const Size triangles = surface.triangles.size();
  constexpr Size kMost = std::numeric_limits<Index>::max() / 3;
  if (triangles > kMost) {
    throw MeshError("the mesh has " + std::to_string(triangles) + " faces on its boundary and interfaces; at most " +
                    std::to_string(kMost) + " can slide. Preserve the boundary, or split the mesh.");
  }
  reference.points.assign(mesh.points);
  reference.triangles.assign(surface.triangles);
  reference.vertex2corner.offsets.assign(surface.vertex2corner.offsets);
  reference.vertex2corner.items.assign(surface.vertex2corner.items);
  reference.across.resize(3 * triangles);
  // Beyond 180 degrees nothing turns, rounding included.
  const double cos_angle = feature_angle >= 180 ? -2 : std::cos(feature_angle * std::numbers::pi / 180);
  par.for_each(3 * triangles,
               FindAcross{mesh.points.span(), reference.triangles.span(), surface.tags.span(),
                          reference.vertex2corner.view(), constrained, cos_angle, reference.across.span()});
  Rows<Backend> vertex2edge_end;
  build_rows(par, vertices, edges.size(), classify_detail::VertexOfEdgeEnd{edges}, vertex2edge_end);
  reference.line.resize(vertices);
  par.for_each(vertices, ClassifySliding{mesh.points.span(), reference.triangles.span(), reference.across.span(),
                                         reference.vertex2corner.view(), edges, vertex2edge_end.view(), frozen,
                                         cos_angle, kind, reference.line.span()});
}

}  // namespace tetune

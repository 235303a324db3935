// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>

#include "boundary/surface.hpp"
#include "tetune/error.hpp"

/// Internal to src/boundary: the corners of surface triangles as items of CSR rows, and the edge opposite a corner.
namespace tetune {

/// Corners are numbered in 32 bits.
inline void check_surface_size(Size faces) {
  constexpr Size kMaxFaces = std::numeric_limits<std::uint32_t>::max() / 3;
  if (faces <= kMaxFaces) return;
  throw MeshError("the mesh has " + std::to_string(faces) + " faces on its boundary and interfaces; at most " +
                  std::to_string(kMaxFaces) + " can be handled. Split the mesh, or weld the vertices that coincide.");
}

/// The edge has no neighbor that a vertex may slide to: it is a feature.
inline constexpr Index kFeatureEdge = -1;

struct VertexOfSurfaceCorner {
  Span<const SurfaceTriangle> triangles;
  TETUNE_HD Size operator()(Size corner) const { return triangles[corner / 3].v[corner % 3]; }
};

struct VertexOfEdgeEnd {
  Span<const Index> edges;
  TETUNE_HD Size operator()(Size item) const { return edges[item]; }
};

/// The corner across the edge of a corner; kFeatureEdge where that edge is not on exactly two triangles.
TETUNE_HD inline Index opposite_corner(Span<const SurfaceTriangle> triangles, const CsrView& vertex2corner,
                                       Size corner) {
  const Size triangle = corner / 3;
  const SurfaceTriangle t = triangles[triangle];
  const Index a = t.v[(corner + 1) % 3];
  const Index b = t.v[(corner + 2) % 3];
  const Index from = vertex2corner.shorter(a, b);
  const Index to = a ^ b ^ from;
  Index opposite = kFeatureEdge;
  for (Size c = vertex2corner.begin(from); c < vertex2corner.end(from); ++c) {
    const Size other = vertex2corner.items[c] / 3;
    if (other == triangle) continue;
    const SurfaceTriangle q = triangles[other];
    const int end = q.v[0] == to ? 0 : q.v[1] == to ? 1 : q.v[2] == to ? 2 : -1;
    if (end < 0) continue;
    if (opposite != kFeatureEdge) return kFeatureEdge;
    opposite = to_index(3 * other + 3 - end - vertex2corner.items[c] % 3);
  }
  return opposite;
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/prefetch.hpp"
#include "backend/span.hpp"
#include "mesh/tet.hpp"
#include "mesh/unit_scale.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// The points and tetrahedra of a TetMesh on the host, with signed indices. Positions are multiplied by `scale`.
struct TetMeshView {
  explicit TetMeshView(const TetMesh& mesh, double unit = 1)
      : points(span_of(mesh.points)), tets(span_of(mesh.tets)), scale(unit) {}

  Tet tet(Size t) const { return {{tets[t][0], tets[t][1], tets[t][2], tets[t][3]}}; }
  Vec3 position(Index v) const { return scale * vec(points[v]); }
  /// Six times the signed volume.
  double six_volume(const Tet& tet) const {
    const Vec3 a = position(tet[0]);
    return dot(cross(position(tet[1]) - a, position(tet[2]) - a), position(tet[3]) - a);
  }
  /// The centroid of a tetrahedron, not scaled.
  Point3 centroid(Size t) const {
    Point3 sum{};
    for (const Index v : tets[t]) {
      for (std::size_t k = 0; k < 3; ++k) sum[k] += 0.25 * points[v][k];
    }
    return sum;
  }
  /// Prefetches the vertices of a later tetrahedron in a loop over all: in files their order is often random.
  TETUNE_INLINE void prefetch_ahead(Size t) const {
    constexpr Size kDistance = 12;
    if (t + kDistance >= tets.size()) return;
    for (const Index v : tets[t + kDistance]) backend::prefetch(&points[v]);
  }

  Span<const Point3> points;
  Span<const std::array<Index, 4>> tets;
  double scale;
};

}  // namespace tetune

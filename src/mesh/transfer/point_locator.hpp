// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "mesh/host_mesh.hpp"

namespace tetune {

/// A point of a mesh: barycentric coordinates in a tetrahedron, none negative, that sum to 1.
struct TetPoint {
  Tet vertices;
  std::array<double, 4> weights;
};

/// Finds points in a mesh of positive volumes. Queries may run concurrently.
class PointLocator {
 public:
  explicit PointLocator(HostMesh mesh);
  const HostMesh& mesh() const { return mesh_; }
  /// Whether a vertex is one of a tetrahedron.
  bool has_tet(Index vertex) const { return vertex < std::ssize(vertex2tet_) && span_of(vertex2tet_)[vertex] >= 0; }
  /// The tetrahedron that contains `p`; for a point outside the mesh the closest point of those around `start`, a
  /// vertex of a tetrahedron. The search takes a time proportional to the number of tetrahedra between it and `p`.
  TetPoint locate(const Vec3& p, Index start) const;

 private:
  struct Hit {
    Index slot;
    std::array<double, 4> weights;
    double distance2;  ///< of `p` from the point with these weights
  };
  Hit closest_in(const Vec3& p, Index slot) const;
  Hit search(const Vec3& p, Index slot) const;

  HostMesh mesh_;
  std::vector<Index> vertex2tet_;  ///< a slot with the vertex, or -1
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <mutex>
#include <optional>
#include <vector>

#include "math/box_tree.hpp"
#include "mesh/host_mesh.hpp"

namespace tetune {

/// The barycentric coordinates of a point, times six volumes of the tetrahedron. Their sum may be 0 or negative by
/// rounding where the true volume is positive.
std::array<double, 4> volumes_at(const Vec3& p, const std::array<Vec3, 4>& corners);

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
  /// The place of `p` in the tetrahedron that contains it. For a point outside the mesh, that of the closest point of
  /// the tetrahedra around `start`, a vertex of a tetrahedron, or of all tetrahedra where it is far from there. The
  /// time is proportional to the number of tetrahedra between `start` and `p`, up to a limit.
  TetPoint locate(const Vec3& p, Index start) const;

 private:
  struct Hit {
    Index slot;
    std::array<double, 4> weights;
    double distance2;  ///< of `p` from the point with these weights
  };
  std::array<Vec3, 4> corners(Index slot) const;
  Hit closest_in(const Vec3& p, Index slot) const;
  bool touches(const Hit& hit) const;
  Hit search(const Vec3& p, Index slot, bool& is_complete) const;
  void build_tree() const;
  Hit look_up(const Vec3& p, const Hit& known, bool is_outside) const;

  HostMesh mesh_;
  std::vector<Index> vertex2tet_;  ///< a slot with the vertex, or -1
  /// Over all tetrahedra, for points that are far from their start. Built on demand, as most meshes have no such
  /// points.
  mutable std::once_flag is_tree_built_;
  mutable std::optional<BoxTree> tree_;
  mutable std::vector<Index> tree2slot_;
};

}  // namespace tetune

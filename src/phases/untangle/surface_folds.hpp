// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "boundary/sliding/reference_surface.hpp"
#include "boundary/vertex_dof.hpp"
#include "mesh/host_mesh.hpp"

/// Exact checks of an untangled mesh, on the host.
namespace tetune {

/// Returns those of the `slots` whose volume is not positive in exact arithmetic.
std::vector<Index> exactly_tangled(const HostMesh& mesh, std::vector<Index> slots);

/// Where vertices are on the surface on which they slide, in the host's memory; empty unless some slide.
class SlidingVertices {
 public:
  SlidingVertices() = default;
  template <class Dofs>
  explicit SlidingVertices(const Dofs& dofs)
      : surface_points_(dofs.surface_point.download()),
        points_(dofs.reference.points.download()),
        triangles_(dofs.reference.triangles.download()),
        across_(dofs.reference.across.download()),
        line_(dofs.reference.line.download()),
        offsets_(dofs.reference.vertex2corner.offsets.download()),
        corners_(dofs.reference.vertex2corner.items.download()) {}

  /// Whether a face with this normal at a vertex is turned by more than 120 degrees from all triangles of the surface
  /// there.
  bool is_turned(Index v, const Vec3& normal) const;

 private:
  bool is_turned_from(Index triangle, const Vec3& normal) const;

  std::vector<SurfacePoint> surface_points_;
  std::vector<Point> points_;
  std::vector<SurfaceTriangle> triangles_;
  std::vector<Index> across_;
  std::vector<LineVertex> line_;
  std::vector<std::uint32_t> offsets_, corners_;
};

/// Flags each vertex that moves on the surface where the surface is folded: a vertex that moves within a plane or along
/// a line and whose boundary faces in one plane do not all have the same orientation, and one that slides and has a
/// face that is turned over with respect to the surface that it slides on.
std::vector<std::uint8_t> folded_vertices(const HostMesh& mesh, const std::vector<VertexDof>& dofs,
                                          const SlidingVertices& sliding = {});

/// Returns the slots with a boundary face at a vertex that is folded now and was not folded `before`: all volumes may
/// be positive, but the surface has changed.
std::vector<Index> newly_folded(const HostMesh& mesh, const std::vector<VertexDof>& dofs,
                                const std::vector<std::uint8_t>& before, const SlidingVertices& sliding = {});

/// Returns the slots with a boundary face that crosses another one or is folded onto a neighbor, among the faces near
/// `slots`: there no mesh with this surface has positive volumes and covers its inside once. A crossing is exact, a
/// fold to 1e-6 of a radian.
std::vector<Index> surface_faults(const HostMesh& mesh, const std::vector<Index>& slots);

}  // namespace tetune

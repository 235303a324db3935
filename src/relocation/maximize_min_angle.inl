// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/sum.hpp"
#include "relocation/maximize_min_angle.hpp"
#include "relocation/min_angle_ring.hpp"
#include "relocation/reduce_colors.hpp"

namespace tetune {
namespace maximize_min_angle_detail {

/// Moves one vertex.
template <class Pack>
struct MaximizeMinAngle {
  static constexpr Size kGrain = 16;
  RatedMesh mesh;
  RingsView rings;
  Span<const VertexDof> dof;
  Span<const Vec3> axis;
  Span<SurfacePoint> surface_point;
  ReferenceView reference;
  double max_deviation;
  Span<const std::uint8_t> flags;
  double target_cot;
  Span<const Index> vertices = {};

  TETUNE_HD backend::Sum<Size> operator()(Size i) const {
    const Index v = vertices[i];
    const Size begin = rings.offsets[v];
    const auto count = static_cast<int>(rings.offsets[v + 1] - begin);
    if (flags[v] == 0 || count == 0) return {};
    const MinAngleRing ring(mesh, rings.faces.data() + begin, count);
    Vec3 x = vec(mesh.points[v]);
    if (dof[v] == VertexDof::curve || dof[v] == VertexDof::surface) {
      SlideMotion<Pack> motion{reference, DeviationBound<Pack>(reference, mesh.points, surface_point, v, max_deviation),
                               dof[v], surface_point[v], surface_point[v]};
      if (!ring.maximize(x, motion, target_cot)) return {};
      surface_point[v] = motion.surface_point;
    } else {
      // Free vertices have no axis: where the surface slides, it was never written.
      FreeMotion motion{{dof[v], dof[v] == VertexDof::free ? Vec3{} : axis[v]}};
      if (!ring.maximize(x, motion, target_cot)) return {};
    }
    mesh.points[v] = point(x);
    return {1};
  }
};

}  // namespace maximize_min_angle_detail

template <class Backend>
Size maximize_min_angle(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                        const RingsView& rings, const Coloring<Backend>& coloring, VertexDofs<Backend>& dofs,
                        Span<const std::uint8_t> flags, double target_cot) {
  using namespace maximize_min_angle_detail;
  const MaximizeMinAngle<typename Backend::Pack> kernel{
      rated(mesh, criterion), rings, dofs.kind.span(), dofs.axis.span(), dofs.site.span(), dofs.reference.view(),
      dofs.max_deviation,     flags, target_cot};
  return reduce_colors<backend::Sum<Size>>(backend, coloring, kernel).value;
}

}  // namespace tetune

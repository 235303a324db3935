// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/vertex_dofs.hpp"
#include "energy/criterion.hpp"
#include "mesh/work_mesh.hpp"
#include "relocation/angle_cost_ring.hpp"
#include "relocation/coloring.hpp"

namespace tetune {

namespace minimize_angle_cost_detail {

/// Moves one vertex. A team moves it together, as each step takes the angles of all tetrahedra around it. Without
/// `kSlides` no vertex slides on a curved surface: a kernel of its own, as for RelocateVertex.
template <class Pack, bool kSlides>
struct MinimizeAngleCost : DofsView {
  static constexpr Size kGrain = 16;
  RatedMesh mesh;
  RingsView rings;
  Span<const std::uint8_t> flags;
  double target_cost;
  Span<const Index> vertices = {};
  using Shared = MinimaxModel;

  TETUNE_HD Sum<Size> operator()(Size i) const {
    MinimaxModel model;
    return (*this)(backend::PackThread<Pack>(), model, i);
  }
  template <class Team>
  TETUNE_HD Sum<Size> operator()(const Team& team, MinimaxModel& model, Size i) const {
    const Index v = vertices[i];
    const Size begin = rings.offsets[v];
    const auto count = to_index(rings.offsets[v + 1] - begin);
    if (flags[v] == 0 || count == 0) return {};
    const AngleCostRing ring(mesh, rings.faces.data() + begin, count, true);
    Vec3 x = vec(backend::read_once(team, mesh.points[v]));
    if constexpr (kSlides) {
      if (slides(dof[v])) return slide(v, ring, x, team, model);
    }
    FreeMotion motion{motion_space(dof, axis, v)};
    if (!ring.minimize(x, motion, target_cost, model, team)) return {};
    if (team.rank() == 0) mesh.points[v] = point(x);
    return {1};
  }

 private:
  template <class Team>
  TETUNE_HD Sum<Size> slide(Index v, const AngleCostRing& ring, Vec3 x, const Team& team, MinimaxModel& model) const {
    const SurfacePoint start = backend::read_once(team, surface_point[v]);
    SlideMotion<DeviationBound<Pack>> motion{
        reference, DeviationBound<Pack>({reference, mesh.points, surface_point, v, max_deviation}), dof[v], start,
        start};
    if (!ring.minimize(x, motion, target_cost, model, team)) return {};
    if (team.rank() == 0) {
      surface_point[v] = motion.surface_point;
      mesh.points[v] = point(x);
    }
    return {1};
  }
};

}  // namespace minimize_angle_cost_detail

/// Moves the flagged vertices, color by color, each within its degrees of freedom, to decrease the largest cost of
/// the dihedral angles of its ring until it is at most `target_cost`. Returns the pending number of vertices that
/// moved.
template <class Backend>
ResultOf<Backend, Sum<Size>> minimize_angle_cost(const Backend& backend, WorkMesh<Backend>& mesh,
                                                 const Criterion& criterion, const RingsView& rings,
                                                 const Coloring<Backend>& coloring, VertexDofs<Backend>& dofs,
                                                 Span<const std::uint8_t> flags, double target_cost) {
  using namespace minimize_angle_cost_detail;
  const auto run = [&](auto slides) {
    const MinimizeAngleCost<typename Backend::Pack, slides.value> kernel{dofs.view(), rated(mesh, criterion), rings,
                                                                         flags, target_cost};
    return reduce_colors<Sum<Size>>(backend, coloring, kernel);
  };
  return dofs.surface_point.size() > 0 ? run(std::true_type()) : run(std::false_type());
}

}  // namespace tetune

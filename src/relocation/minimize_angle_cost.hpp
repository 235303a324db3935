// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <type_traits>

#include "backend/atomic.hpp"
#include "boundary/sliding/deviation_bound.hpp"
#include "energy/criterion.hpp"
#include "mesh/work_mesh.hpp"
#include "relocation/angle_cost_ring.hpp"
#include "relocation/movable_vertices.hpp"
#include "relocation/reduce_colors.hpp"

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

  /// Almost all rings have at most this number of faces; larger ones are read from the mesh.
  static constexpr Size kStoredFaces = 64;
  struct Shared {
    MinimaxModel model;
    Point corners[3 * kStoredFaces];
    LinkFace faces[kStoredFaces];
  };
  static constexpr bool kUsesRingAlone = !kSlides;
  TETUNE_HD bool may_move(Index v) const { return flags[v] != 0; }

  TETUNE_HD Sum<Size> operator()(Size i) const {
    MinimaxModel model;
    return move(backend::PackThread<Pack>(), model, vertices[i], mesh.points, faces_of(vertices[i]));
  }
  template <class Team>
  TETUNE_HD Sum<Size> operator()(const Team& team, Shared& shared, Size i) const {
    const Index v = vertices[i];
    const Span<const LinkFace> faces = faces_of(v);
    if (!may_move(v) || faces.size() > kStoredFaces) return move(team, shared.model, v, mesh.points, faces);
    for (Size f = team.rank(); f < faces.size(); f += Team::kSize) store_face(faces[f], f, shared);
    team.sync();
    return move(team, shared.model, v, {shared.corners, 3 * faces.size()}, {shared.faces, faces.size()});
  }

 private:
  TETUNE_HD Span<const LinkFace> faces_of(Index v) const {
    const Size begin = rings.offsets[v];
    return {rings.faces.data() + begin, rings.offsets[v + 1] - begin};
  }
  /// Each position is loaded once, as other teams may store it in the same loop, and such loads bypass a cache.
  TETUNE_HD void store_face(const LinkFace& face, Size f, Shared& shared) const {
    for (int k = 0; k < 3; ++k) {
      const Index corner = to_index(3 * f + k);
      shared.corners[corner] = point(load_position(face.v[k]));
      shared.faces[f].v[k] = corner;
    }
  }
  TETUNE_HD Vec3 load_position(Index v) const {
    const Point& p = mesh.points[v];
    return {backend::load_shared(p.x), backend::load_shared(p.y), backend::load_shared(p.z)};
  }
  TETUNE_HD void store_position(Index v, const Vec3& x) const {
    Point& p = mesh.points[v];
    backend::store_shared(p.x, x.x);
    backend::store_shared(p.y, x.y);
    backend::store_shared(p.z, x.z);
  }

  /// `faces`: the ring of the vertex, with the positions of its corners.
  template <class Team>
  TETUNE_HD Sum<Size> move(const Team& team, MinimaxModel& model, Index v, Span<Point> corners,
                           Span<const LinkFace> faces) const {
    if (!may_move(v) || faces.size() == 0) return {};
    RatedMesh rated = mesh;
    rated.points = corners;
    const AngleCostRing ring(rated, faces.data(), to_index(faces.size()), FloorRule::kept);
    Vec3 x = team.broadcast(load_position(v), 0);
    if constexpr (kSlides) {
      if (slides(dof[v])) return slide(v, ring, x, team, model);
    }
    FreeMotion motion{motion_space(dof, axis, v)};
    if (!ring.minimize(x, motion, target_cost, model, team)) return {};
    if (team.rank() == 0) store_position(v, x);
    return {1};
  }
  template <class Team>
  TETUNE_HD Sum<Size> slide(Index v, const AngleCostRing& ring, Vec3 x, const Team& team, MinimaxModel& model) const {
    const SurfacePoint start = backend::read_once(team, surface_point[v]);
    SlideMotion<DeviationBound<Pack>> motion{reference, deviation_bound<Pack>(*this, team, v), dof[v], start, start};
    if (!ring.minimize(x, motion, target_cost, model, team)) return {};
    if (team.rank() == 0) {
      surface_point[v] = motion.surface_point;
      mesh.points[v] = point(x);
      motion.deviation.store(checked, v);
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
                                                 const Criterion& criterion, const MovableVertices<Backend>& vertices,
                                                 Span<const std::uint8_t> flags, double target_cost) {
  using namespace minimize_angle_cost_detail;
  const auto run = [&](auto slides) {
    const MinimizeAngleCost<typename Backend::Pack, slides.value> kernel{vertices.dofs.view(), rated(mesh, criterion),
                                                                         vertices.rings, flags, target_cost};
    return reduce_colors<Sum<Size>>(backend, vertices.coloring, kernel);
  };
  return vertices.dofs.surface_point.size() > 0 ? run(std::true_type()) : run(std::false_type());
}

}  // namespace tetune

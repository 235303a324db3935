// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/atomic.hpp"
#include "energy/criterion.hpp"
#include "relocation/angle_cost_ring.hpp"
#include "relocation/periodic_set.hpp"
#include "relocation/reduce_colors.hpp"
#include "relocation/sweep.hpp"

namespace tetune {
namespace move_periodic_detail {

/// The joint ring of a class, and the motion of its members.
struct ClassMove : PeriodicSetView {
  Span<Point> points;
  RingsView rings;

  TETUNE_HD Vec3 root_position(Index c) const { return vec(points[members[first[c]].vertex]); }
  TETUNE_HD Size faces_of(Index c) const { return offsets[c + 1] - offsets[c]; }
  /// Copies the vertices of the joint ring, moved to the root.
  TETUNE_HD void copy_ring(Index c) const {
    Size at = 3 * Size{offsets[c]};
    for (std::uint32_t m = first[c]; m < first[c + 1]; ++m) {
      const PeriodicMember member = members[m];
      for (std::uint32_t i = rings.offsets[member.vertex]; i < rings.offsets[member.vertex + 1]; ++i) {
        for (int k = 0; k < 3; ++k) copies[at++] = point(vec(points[rings.faces[i].v[k]]) - member.shift);
      }
    }
  }
  /// Moves all members, if `allows(member, position)` for each. It tests the rounded positions of the members in their
  /// own rings, as the copies in the joint ring have been rounded differently.
  template <class Allows>
  TETUNE_HD bool move_to(Index c, const Vec3& root, const Allows& allows) const {
    for (std::uint32_t m = first[c]; m < first[c + 1]; ++m) {
      if (!allows(members[m].vertex, members[m].from_root(root))) return false;
    }
    for (std::uint32_t m = first[c]; m < first[c + 1]; ++m) {
      points[members[m].vertex] = point(members[m].from_root(root));
    }
    return true;
  }
};

/// Relocates one class in its joint ring.
template <class Step>
struct RelocateClass : ClassMove {
  static constexpr Size kGrain = 16;
  Criterion criterion;
  Step step;
  SweepScope scope;
  Span<std::uint8_t> active;
  Span<const Index> vertices = {};  ///< classes of one color

  TETUNE_HD SweepSum operator()(Size i) const {
    const Index c = vertices[i];
    if (faces_of(c) == 0 || !is_active(c)) return {};
    copy_ring(c);
    const Span<const Point> ring_points(copies.data(), copies.size());
    PlainRing<> ring(criterion.objective, ring_points, faces.data() + offsets[c], faces_of(c), criterion.floor);
    MotionSpace motion = space[c];
    if (scope == SweepScope::selection) motion.displacement_bound = {};
    StepResult result = step(ring, root_position(c), motion);
    const bool moves = result.decrease > 0 && move_to(c, result.position, [this](Index v, const Vec3& x) {
                         const Size begin = rings.offsets[v];
                         return PlainRing<>(criterion.objective, points, rings.faces.data() + begin,
                                            rings.offsets[v + 1] - begin, criterion.floor)
                             .value(x)
                             .certified;
                       });
    set_active(c, moves && result.relative_move > kActivationThreshold);
    return {moves ? result.decrease : 0, result.gradient2, moves ? first[c + 1] - first[c] : 0};
  }

 private:
  TETUNE_HD bool is_active(Index c) const {
    for (std::uint32_t m = first[c]; m < first[c + 1]; ++m) {
      if (backend::load_shared(active[members[m].vertex]) != 0) return true;
    }
    return false;
  }
  TETUNE_HD void set_active(Index c, bool far) const {
    for (std::uint32_t m = first[c]; m < first[c + 1]; ++m) {
      const Index v = members[m].vertex;
      backend::store_shared(active[v], far ? 1 : 0);
      if (!far || scope != SweepScope::mesh) continue;
      for (std::uint32_t f = rings.offsets[v]; f < rings.offsets[v + 1]; ++f) {
        for (int k = 0; k < 3; ++k) backend::store_shared(active[rings.faces[f].v[k]], 1);
      }
    }
  }
};

/// Opens the angles around one class.
struct OpenClass : ClassMove {
  static constexpr Size kGrain = 16;
  RatedMesh mesh;
  Span<const std::uint8_t> flags;
  double target_cost;
  Span<const Index> vertices = {};  ///< classes of one color

  TETUNE_HD Sum<Size> operator()(Size i) const {
    const Index c = vertices[i];
    bool is_selected = false;
    for (std::uint32_t m = first[c]; m < first[c + 1]; ++m) {
      is_selected = is_selected || flags[members[m].vertex] != 0;
    }
    if (!is_selected || faces_of(c) == 0) return {};
    copy_ring(c);
    RatedMesh copied = mesh;
    copied.points = copies;
    Vec3 x = root_position(c);
    FreeMotion motion{space[c]};
    MinimaxModel model;
    const AngleCostRing ring(copied, faces.data() + offsets[c], to_index(faces_of(c)), FloorRule::kept);
    if (!ring.minimize(x, motion, target_cost, model)) return {};
    const bool moves = move_to(c, x, [this](Index v, const Vec3& position) {
      const Size begin = rings.offsets[v];
      const AngleCostRing own(mesh, rings.faces.data() + begin, to_index(rings.offsets[v + 1] - begin),
                              FloorRule::kept);
      int worst = 0;
      return own.largest_cost(position, kInfeasible, worst) < kInfeasible;
    });
    return {moves ? first[c + 1] - first[c] : 0};
  }
};

}  // namespace move_periodic_detail

/// One sweep over the classes with an active member, as sweep() over single vertices. Requires refresh_periodic().
template <class Backend, class Step>
ResultOf<Backend, SweepSum> sweep_periodic(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                                           const MovableClasses<Backend>& classes, const Step& step, SweepScope scope) {
  const move_periodic_detail::RelocateClass<Step> kernel{
      {classes.set.view(), mesh.points, classes.rings}, criterion, step, scope, classes.dofs.active.span()};
  return reduce_colors<SweepSum>(backend, classes.set.coloring, kernel);
}

/// Moves the classes with a flagged member, as minimize_angle_cost() moves single vertices. Returns the pending number
/// of vertices that moved.
template <class Backend>
ResultOf<Backend, Sum<Size>> minimize_periodic_cost(const Backend& backend, WorkMesh<Backend>& mesh,
                                                    const Criterion& criterion, const MovableClasses<Backend>& classes,
                                                    Span<const std::uint8_t> flags, double target_cost) {
  const move_periodic_detail::OpenClass kernel{
      {classes.set.view(), mesh.points, classes.rings}, rated(mesh, criterion), flags, target_cost};
  return reduce_colors<Sum<Size>>(backend, classes.set.coloring, kernel);
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <type_traits>

#include "backend/atomic.hpp"
#include "backend/prefetch.hpp"
#include "boundary/sliding/deviation_bound.hpp"
#include "relocation/reduce_colors.hpp"
#include "relocation/slide.hpp"
#include "relocation/sweep.hpp"

namespace tetune {
namespace sweep_detail {

/// Relocates one vertex. Without `kSlides` no vertex slides on a curved surface: a kernel of its own, as the registers
/// and the memory per thread that sliding takes would otherwise be reserved in every sweep.
template <class Ring, class Pack, class Step, bool kSlides>
struct RelocateVertex : DofsView {
  static constexpr Size kGrain = 16;
  /// A team evaluates a ring whose class has a form for teams.
  struct NoMemory {};
  using Shared = std::conditional_t<std::is_same_v<Ring, PlainRing<>>, NoMemory, void>;
  static constexpr int kTeamSize = kRingLanes;
  static constexpr bool kScalesToWarp = !kSlides;
  Criterion criterion;
  Span<Point> points;
  RingsView rings;
  Step step;
  SweepScope scope;
  Span<const Index> vertices = {};

  /// Vertices of one color are scattered in memory, which hardware does not prefetch. Surface points from `end` on are
  /// written by other threads.
  TETUNE_INLINE void prefetch(Size i, Size end) const {
    constexpr Size kRingsAhead = 8;
    constexpr Size kMotionAhead = 5;
    constexpr Size kPointsAhead = 3;
    if (i + kRingsAhead >= vertices.size()) return;
    const Index far = vertices[i + kRingsAhead];
    rings.prefetch(far);
    backend::prefetch(&dof[far]);
    if (surface_point.size() > 0) backend::prefetch(&surface_point[far]);
    prefetch_motion(vertices[i + kMotionAhead]);
    if (surface_point.size() > 0 && i + kMotionAhead < end) prefetch_reference(vertices[i + kMotionAhead]);
    const Index near = vertices[i + kPointsAhead];
    if (backend::load_shared(active[near]) == 0) return;
    for (Size f = rings.offsets[near]; f < rings.offsets[near + 1]; ++f) {
      backend::prefetch(&points[rings.faces[f].v[0]]);
    }
    if (surface_point.size() > 0 && i + kPointsAhead < end) prefetch_corners(surface_point[near]);
  }

  TETUNE_HD SweepSum operator()(Size i) const { return relocate<Ring>(backend::SingleThread(), vertices[i]); }
  template <class Team>
  TETUNE_HD SweepSum operator()(const Team& team, NoMemory&, Size i) const {
    return relocate<PlainRing<Team>>(team, vertices[i]);
  }

 private:
  template <class AnyRing, class Team>
  TETUNE_HD SweepSum relocate(const Team& team, Index v) const {
    if (read_once(team, active[v]) == 0) return {};
    const Size begin = rings.offsets[v];
    const Size count = rings.offsets[v + 1] - begin;
    const bool writes = team.rank() == 0;
    if (count == 0) {
      if (writes) backend::store_shared(active[v], 0);
      return {};
    }
    const LinkFace* faces = rings.faces.data() + begin;
    const auto step_in = [&](auto&& ring) { return step_from(vec(read_once(team, points[v])), ring, team, v); };
    const StepResult result = [&] {
      if constexpr (!std::is_same_v<AnyRing, PlainRing<Team>>) {
        if (count <= AnyRing::kCapacity)
          return step_in(AnyRing(criterion.objective, points, faces, count, criterion.floor));
      }
      return step_in(PlainRing<Team>(criterion.objective, points, faces, count, criterion.floor));
    }();
    if (writes && result.decrease > 0) points[v] = point(result.position);
    const bool far = result.relative_move > kActivationThreshold;
    if (writes) backend::store_shared(active[v], far ? 1 : 0);
    if (far && scope == SweepScope::mesh) {
      for (Size j = team.rank(); j < count; j += Team::kSize) {
        for (int k = 0; k < 3; ++k) backend::store_shared(active[faces[j].v[k]], 1);
      }
    }
    return {result.decrease, result.gradient2, result.decrease > 0 ? 1 : 0};
  }
  static Index triangle_of(const SurfacePoint& s) {
    return s.kind == SurfacePointKind::triangle ? s.item : s.kind == SurfacePointKind::edge ? s.item / 3 : -1;
  }
  TETUNE_INLINE void prefetch_motion(Index v) const {
    if (dof[v] == VertexDof::free) return;
    if (displacement_bound.size() > 0) backend::prefetch(&displacement_bound[v]);
    if (surface_point.size() == 0) backend::prefetch(&axis[v]);
  }
  TETUNE_INLINE void prefetch_reference(Index v) const {
    const Index triangle = dof[v] == VertexDof::free ? -1 : triangle_of(surface_point[v]);
    if (triangle < 0) return;
    backend::prefetch(&reference.triangles[triangle]);
    backend::prefetch(&reference.across[3 * triangle]);
  }
  TETUNE_INLINE void prefetch_corners(const SurfacePoint& s) const {
    const Index triangle = triangle_of(s);
    if (triangle < 0) return;
    for (const Index corner : reference.triangles[triangle].v) backend::prefetch(&reference.points[corner]);
  }

  template <class AnyRing, class Team>
  TETUNE_HD StepResult step_from(const Vec3& x, AnyRing& ring, const Team& team, Index v) const {
    const VertexDof own_dof = dof[v];
    // Most vertices are free; the arrays that only others read are not in the cache.
    if (own_dof == VertexDof::free) return step(ring, x, MotionSpace{own_dof, {}});
    const DisplacementBound bound = displacement_bound.size() == 0 ? DisplacementBound{} : displacement_bound[v];
    if constexpr (kSlides) {
      if (slides(own_dof)) return slide(x, ring, team, v, bound);
    }
    return step(ring, x, MotionSpace{own_dof, axis[v], bound});
  }
  /// Out of line to reduce register pressure in the steps of the free vertices.
  template <class AnyRing, class Team>
  TETUNE_HD __attribute__((noinline)) StepResult slide(const Vec3& x, AnyRing& ring, const Team& team, Index v,
                                                       const DisplacementBound& displacement) const {
    DeviationBound<Pack> deviation = deviation_bound<Pack>(*this, team, v);
    const SurfacePlace start{x, read_once(team, surface_point[v]), dof[v]};
    const SlideResult slid = slide_of(step)(ring, start, reference, deviation, displacement);
    if (team.rank() == 0 && slid.step.decrease > 0) {
      surface_point[v] = slid.surface_point;
      deviation.store(checked, v);
    }
    return slid.step;
  }
};

}  // namespace sweep_detail

template <class Ring, class Backend, class Step>
ResultOf<Backend, SweepSum> sweep(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                                  const MovableVertices<Backend>& vertices, const Step& step, SweepScope scope) {
  using namespace sweep_detail;
  DofsView view = vertices.dofs.view();
  if (scope == SweepScope::selection) view.displacement_bound = {};
  const auto run = [&](auto slides) {
    using Kernel = RelocateVertex<Ring, typename Backend::Pack, Step, slides.value>;
    return reduce_colors<SweepSum>(backend, vertices.coloring,
                                   Kernel{view, criterion, mesh.points, vertices.rings, step, scope});
  };
  return vertices.dofs.surface_point.size() > 0 ? run(std::true_type()) : run(std::false_type());
}

}  // namespace tetune

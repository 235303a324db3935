// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/connect.inl"
#include "core/rows.hpp"
#include "par/atomic.hpp"
#include "par/prefetch.hpp"
#include "relocate/reduce_colors.hpp"
#include "relocate/slide.hpp"
#include "relocate/sweep.hpp"

namespace tetune {
namespace sweep_detail {

/// The face opposite a corner.
struct FaceOfCorner {
  Span<const Tet> tets;
  TETUNE_HD LinkFace operator()(std::uint32_t corner) const {
    const Tet tet = tets[corner >> 2];
    const int k = static_cast<int>(corner & 3);
    return {{tet[face_vertex(k, 0)], tet[face_vertex(k, 1)], tet[face_vertex(k, 2)]}};
  }
};

/// The same two where only some tetrahedra are looked at, and only flagged vertices get a ring.
struct FaceOfListedCorner {
  FaceOfCorner face;
  Span<const Index> slots;
  TETUNE_HD LinkFace operator()(std::uint32_t corner) const {
    return face(4 * static_cast<std::uint32_t>(slots[corner >> 2]) + (corner & 3));
  }
};
struct FlaggedVertexOfCorner {
  Span<const Tet> tets;
  Span<const Index> slots;
  Span<const std::uint8_t> flags;
  TETUNE_HD Size operator()(Size corner) const {
    const Index v = tets[slots[corner >> 2]][static_cast<int>(corner & 3)];
    return flags[v] != 0 ? v : -1;
  }
};

/// Ring is the backend's own: see each instantiation. Without `kSlides` no vertex slides: a kernel of its own, as what
/// sliding takes of registers and of each thread's memory would be taken in any sweep.
template <class Ring, class Step, bool kSlides>
struct RelocateVertex {
  static constexpr Size kGrain = 16;
  EnergyLaw law;
  QualityFloor floor;
  Span<Point> points;
  RingsView rings;
  Span<const Index> vertices;
  Span<const Mobility> kind;
  Span<const Vec3> axis;
  Span<const Leash> leash;
  Span<std::uint8_t> awake;
  bool local;
  Span<Site> site;
  ReferenceView reference;
  double max_deviation;
  Step step;

  /// Vertices of one colour lie apart in memory, where no hardware looks ahead. Sites from `end` on are another
  /// thread's.
  TETUNE_INLINE void prefetch(Size i, Size end) const {
    constexpr Size kRowsAhead = 8;
    constexpr Size kMotionAhead = 5;
    constexpr Size kPointsAhead = 3;
    if (i + kRowsAhead >= vertices.size()) return;
    const Index far = vertices[i + kRowsAhead];
    rings.prefetch(far);
    par::prefetch(&kind[far]);
    if (site.size() > 0) par::prefetch(&site[far]);
    prefetch_motion(vertices[i + kMotionAhead], i + kMotionAhead < end);
    const Index near = vertices[i + kPointsAhead];
    if (par::load_shared(awake[near]) == 0) return;
    for (Size f = rings.offsets[near]; f < rings.offsets[near + 1]; ++f) {
      par::prefetch(&points[rings.faces[f].v[0]]);
    }
    if (site.size() > 0 && i + kPointsAhead < end) prefetch_corners(site[near]);
  }

  TETUNE_HD SweepSum operator()(Size i) const {
    const Index v = vertices[i];
    if (awake[v] == 0) return {};
    const Size begin = rings.offsets[v];
    const Size count = rings.offsets[v + 1] - begin;
    if (count == 0) {
      par::store_shared(awake[v], 0);
      return {};
    }
    const LinkFace* faces = rings.faces.data() + begin;
    StepResult result;
    if (count <= Ring::kCapacity) {
      Ring ring(law, points, faces, count, floor);
      result = relocate(ring, v);
    } else {
      PlainRing ring(law, points, faces, count, floor);
      result = relocate(ring, v);
    }
    if (result.decrease > 0) points[v] = point(result.position);
    const bool far = result.relative_move > kWake;
    par::store_shared(awake[v], far ? 1 : 0);
    if (far && !local) {
      for (Size j = 0; j < count; ++j) {
        for (int k = 0; k < 3; ++k) par::store_shared(awake[faces[j].v[k]], 1);
      }
    }
    return {result.decrease, result.gradient2, result.decrease > 0 ? 1 : 0};
  }

 private:
  static Index triangle_of(const Site& s) {
    return s.kind == SiteKind::triangle ? s.item : s.kind == SiteKind::edge ? s.item / 3 : -1;
  }
  TETUNE_INLINE void prefetch_motion(Index v, bool may_read) const {
    if (kind[v] == Mobility::free) return;
    if (leash.size() > 0) par::prefetch(&leash[v]);
    if (site.size() == 0) {
      par::prefetch(&axis[v]);
      return;
    }
    const Index triangle = may_read ? triangle_of(site[v]) : -1;
    if (triangle < 0) return;
    par::prefetch(&reference.triangles[triangle]);
    par::prefetch(&reference.across[3 * triangle]);
  }
  TETUNE_INLINE void prefetch_corners(const Site& s) const {
    const Index triangle = triangle_of(s);
    if (triangle < 0) return;
    for (const Index corner : reference.triangles[triangle].v) par::prefetch(&reference.points[corner]);
  }

  template <class AnyRing>
  TETUNE_HD StepResult relocate(AnyRing& ring, Index v) const {
    const Vec3 x = vec(points[v]);
    const Mobility where = kind[v];
    // Most vertices are free. What they do not need would not be in the cache.
    if (where == Mobility::free) return step(ring, x, Motion{where, {}});
    const Leash held = leash.size() == 0 ? Leash{} : leash[v];
    if constexpr (kSlides) {
      if (where == Mobility::curve || where == Mobility::surface) return slide(ring, v, x, held);
    }
    return step(ring, x, Motion{where, axis[v], held});
  }
  template <class AnyRing>
  TETUNE_HD __attribute__((noinline)) StepResult slide(AnyRing& ring, Index v, const Vec3& x, const Leash& held) const {
    const DeviationBound bound(reference, points, site, v, max_deviation);
    const SlideResult slid = slide_of(step)(ring, x, site[v], kind[v], reference, bound, held);
    if (slid.step.decrease > 0) site[v] = slid.site;
    return slid.step;
  }
};

}  // namespace sweep_detail

template <class Backend>
void build_rings(const Backend& par, WorkMesh<Backend>& mesh, Rings<Backend>& rings) {
  const Span<const Tet> tets = mesh.tet2vertex.span();
  group_by_row<Backend, connect_detail::VertexOfCorner, sweep_detail::FaceOfCorner, LinkFace>(
      par, mesh.vertices(), 4 * mesh.slots(), {tets}, {tets}, rings.offsets, rings.faces);
}

template <class Backend>
void build_rings_of(const Backend& par, WorkMesh<Backend>& mesh, Span<const Index> around,
                    Span<const std::uint8_t> flags, Rings<Backend>& rings) {
  const Span<const Tet> tets = mesh.tet2vertex.span();
  group_by_row<Backend, sweep_detail::FlaggedVertexOfCorner, sweep_detail::FaceOfListedCorner, LinkFace>(
      par, mesh.vertices(), 4 * around.size(), {tets, around, flags}, {{tets}, around}, rings.offsets, rings.faces);
}

namespace sweep_detail {

template <class Ring, bool kSlides, class Backend, class Step>
SweepSum sweep_colors(const Backend& par, WorkMesh<Backend>& mesh, const RingsView& rings,
                      const Coloring<Backend>& coloring, Mobilities<Backend>& mobilities, const Step& step) {
  return reduce_colors<SweepSum>(par, coloring, [&](Span<const Index> vertices) {
    return RelocateVertex<Ring, Step, kSlides>{mesh.law,
                                               mesh.floor,
                                               mesh.points.span(),
                                               rings,
                                               vertices,
                                               mobilities.kind.span(),
                                               mobilities.axis.span(),
                                               mobilities.leashes(),
                                               mobilities.awake.span(),
                                               mobilities.local,
                                               mobilities.site.span(),
                                               mobilities.reference.view(),
                                               mobilities.max_deviation,
                                               step};
  });
}

}  // namespace sweep_detail

template <class Ring, class Backend, class Step>
SweepSum sweep_with(const Backend& par, WorkMesh<Backend>& mesh, const RingsView& rings,
                    const Coloring<Backend>& coloring, Mobilities<Backend>& mobilities, const Step& step) {
  using namespace sweep_detail;
  return mobilities.site.size() > 0 ? sweep_colors<Ring, true>(par, mesh, rings, coloring, mobilities, step)
                                    : sweep_colors<Ring, false>(par, mesh, rings, coloring, mobilities, step);
}

}  // namespace tetune

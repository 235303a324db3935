// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/motion.hpp"
#include "core/work_mesh.hpp"
#include "energy/ring.hpp"
#include "relocate/coloring.hpp"
#include "relocate/step.hpp"
#include "surface/reference.hpp"

namespace tetune {

/// The one-rings of all vertices, owned.
template <class Backend>
struct Rings {
  typename Backend::template Buffer<std::uint32_t> offsets;
  typename Backend::template Buffer<LinkFace> faces;
  RingsView view() const { return {offsets.span(), faces.span()}; }
};

template <class Backend>
void build_rings(const Backend& par, WorkMesh<Backend>& mesh, Rings<Backend>& rings);

/// The same of the flagged vertices alone, all of whose tetrahedra are given; the others have empty ones.
template <class Backend>
void build_rings_of(const Backend& par, WorkMesh<Backend>& mesh, Span<const Index> around,
                    Span<const std::uint8_t> flags, Rings<Backend>& rings);

/// How far each vertex may go, and which ones are worth a visit.
template <class Backend>
struct Mobilities {
  typename Backend::template Buffer<Mobility> kind;
  typename Backend::template Buffer<Vec3> axis;
  /// Where each vertex is on the reference surface, and that surface; empty unless vertices slide.
  typename Backend::template Buffer<Site> site;
  ReferenceSurface<Backend> reference;
  /// For each vertex; meaningful on the surface. Empty: endless.
  typename Backend::template Buffer<Leash> leash;
  /// Most distance between the two surfaces; 0: no bound.
  double max_deviation = 0;
  /// What color_vertices() needs of the surface.
  SurfaceStars stars() const {
    if (!(max_deviation > 0)) return {};
    return {reference.triangles.span(), reference.vertex2corner.view(), reference.line.span()};
  }
  /// 1: worth a visit: at its last visit the vertex, or since then one of its ring, moved by more than kWake at once,
  /// or a flip changed its ring.
  typename Backend::template Buffer<std::uint8_t> awake;
  /// Work on a few vertices: one that moves far wakes no neighbours, and leashes do not hold, as few spoil no sizes.
  bool local = false;

  Span<const Leash> leashes() const { return local ? Span<const Leash>() : leash.span(); }
};

/// A move beyond this part of the local length makes the neighbours worth another visit.
inline constexpr double kWake = 1e-2;
struct SweepSum {
  double decrease = 0;
  double gradient2 = 0;
  Size moved = 0;
  TETUNE_HD void merge(const SweepSum& other) {
    decrease += other.decrease;
    gradient2 += other.gradient2;
    moved += other.moved;
  }
};

/// One sweep: the colours in turn, the vertices of a colour in parallel (Alg. 1). `Step` is NewtonStep or GradientStep.
/// Vertices that are asleep are passed over. Ends between two colours when a stop is requested.
template <class Backend, class Step>
SweepSum sweep(const Backend& par, WorkMesh<Backend>& mesh, const RingsView& rings, const Coloring<Backend>& coloring,
               Mobilities<Backend>& mobilities, const Step& step);

/// The same where volumes may be negative: under the law's softness, which must not be 0.
template <class Backend, class Step>
SweepSum soft_sweep(const Backend& par, WorkMesh<Backend>& mesh, const RingsView& rings,
                    const Coloring<Backend>& coloring, Mobilities<Backend>& mobilities, const Step& step);

}  // namespace tetune

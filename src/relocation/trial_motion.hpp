// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/sliding/trace.hpp"
#include "boundary/vertex_dof.hpp"

/// Where a vertex goes by the trial steps of AngleCostRing::minimize().
namespace tetune {

/// The trial steps of a vertex in its space of motion.
struct FreeMotion {
  MotionSpace space;
  TETUNE_HD Vec3 tangent(const Vec3& gradient) const { return project(gradient, space); }
  /// The position after a step from x.
  TETUNE_HD Vec3 trial(const Vec3& x, const Vec3& step) const { return x + project(step, space); }
  /// Whether the vertex may move to the last trial position; if so, makes it the current one.
  TETUNE_HD bool accept(const Vec3&) const { return true; }
};

/// A surface without a bound on its deviation.
struct NoDeviationBound {
  TETUNE_HD bool allows(const Vec3&, const SurfacePoint&) const { return true; }
};

/// The trial steps of a vertex on the input surface: each ends at the boundary of the surface element at the latest.
template <class Deviation>
struct SlideMotion {
  ReferenceView reference;
  Deviation deviation;
  VertexDof dof;
  SurfacePoint surface_point;
  SurfacePoint trial_point;

  TETUNE_HD Vec3 tangent(const Vec3& gradient) const { return gradient; }
  TETUNE_HD Vec3 trial(const Vec3& x, const Vec3& step) {
    const TraceResult end = project_step(reference, dof, surface_point, x, step);
    trial_point = end.surface_point;
    return end.position;
  }
  TETUNE_HD bool accept(const Vec3& x) {
    if (!deviation.allows(x, trial_point)) return false;
    surface_point = trial_point;
    return true;
  }
};

/// The trial steps of the apex of a cavity: on the reference surface where it has a surface point, else in its space of
/// motion.
struct ApexMotion {
  FreeMotion free;
  SlideMotion<NoDeviationBound> slide;

  TETUNE_HD bool slides() const { return slide.surface_point.kind != SurfacePointKind::none; }
  TETUNE_HD Vec3 tangent(const Vec3& gradient) const { return slides() ? gradient : free.tangent(gradient); }
  TETUNE_HD Vec3 trial(const Vec3& x, const Vec3& step) {
    return slides() ? slide.trial(x, step) : free.trial(x, step);
  }
  TETUNE_HD bool accept(const Vec3& x) { return !slides() || slide.accept(x); }
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/sliding/deviation_bound.hpp"
#include "boundary/sliding/trace.hpp"
#include "boundary/vertex_dof.hpp"
#include "energy/criterion.hpp"
#include "energy/ring.hpp"
#include "math/orient.hpp"
#include "mesh/work_mesh.hpp"
#include "relocation/step.hpp"

namespace tetune {

/// Cotangent of the smallest dihedral angle of a tetrahedron. Where its volume is not certified, the error bound of the
/// volume takes its place.
TETUNE_HD inline double max_dihedral_cot(const MeshView& mesh, Size t) {
  const Tet tet = mesh.tet2vertex[t];
  const Vec3 p[4] = {vec(mesh.points[tet[0]]), vec(mesh.points[tet[1]]), vec(mesh.points[tet[2]]),
                     vec(mesh.points[tet[3]])};
  const Orient o = orient(p[0], p[1], p[2], p[3]);
  return QualityFloor::max_dihedral_cot(p, o.certified() ? o.det : o.bound);
}

/// The trial steps of a vertex in its space of motion.
struct FreeMotion {
  MotionSpace space;
  /// The position after a step from x.
  TETUNE_HD Vec3 trial(const Vec3& x, const Vec3& step) const { return x + tangent_gradient(step, space); }
  /// Whether the vertex may move to the last trial position; if so, makes it the current one.
  TETUNE_HD bool accept(const Vec3&) const { return true; }
};

/// The trial steps of a vertex on the input surface: each ends at the boundary of the surface element at the latest.
template <class Pack>
struct SlideMotion {
  ReferenceView reference;
  DeviationBound<Pack> deviation;
  VertexDof dof;
  SurfacePoint surface_point;
  SurfacePoint trial_point;

  TETUNE_HD Vec3 trial(const Vec3& x, const Vec3& step) {
    const SurfaceElement element = steepest(reference, dof, surface_point, -1.0 * step);
    trial_point = surface_point;
    if (element.on.kind == SurfacePointKind::none) return x;
    const TraceResult end = advance(reference, dof, element, surface_point, x, element.descent, 1);
    trial_point = end.surface_point;
    return end.position;
  }
  TETUNE_HD bool accept(const Vec3& x) {
    if (!deviation.allows(x, trial_point)) return false;
    surface_point = trial_point;
    return true;
  }
};

/// The smallest dihedral angle of the tetrahedra between a point and given faces, in terms of its cotangent, which is
/// to be minimized. It is neither a smooth nor a convex function of the point: a pattern search minimizes it.
class MinAngleRing {
 public:
  TETUNE_HD MinAngleRing(const RatedMesh& mesh, const LinkFace* faces, int count)
      : mesh_(mesh), faces_(faces), count_(count) {}

  /// Moves x by steps of `motion` (FreeMotion, SlideMotion) while these increase the smallest angle, until its
  /// cotangent is at most `target_cot`. Returns whether x moved.
  template <class VertexMotion>
  TETUNE_HD bool maximize(Vec3& x, VertexMotion& motion, double target_cot) const {
    double length2 = 0;
    for (int k = 0; k < count_; ++k) {
      const Vec3 d = corner(k, 0) - x;
      length2 += dot(d, d);
    }
    const double length = std::sqrt(length2 / count_);
    int worst = 0;
    double cot = max_dihedral_cot(x, kInfeasible, worst);
    bool moved = false;
    for (double step = kFirstStep * length; step > kLastStep * length && cot > target_cot;) {
      bool improved = false;
      for (int d = 0; d < kDirections && !improved; ++d) {
        const Vec3 trial = motion.trial(x, step * direction(d));
        const double limit = cot - kMinGain * (1 + cot);
        const double trial_cot = max_dihedral_cot(trial, limit, worst);
        if (!(trial_cot < limit) || !motion.accept(trial)) continue;
        x = trial;
        cot = trial_cot;
        improved = true;
      }
      moved = moved || improved;
      if (!improved) step *= 0.5;
    }
    return moved;
  }

  /// The cotangent of the smallest angle with the point at x; `limit` where it is not below `limit`, or where a
  /// tetrahedron is not certified positive or is worse than the floor. Tetrahedron `first` is evaluated first, and the
  /// one with the smallest angle replaces it.
  TETUNE_HD double max_dihedral_cot(const Vec3& x, double limit, int& first) const {
    double max_cot = -1;
    const int start = first;
    for (int k = 0; k < count_; ++k) {
      const int at = k == 0 ? start : k <= start ? k - 1 : k;
      const Vec3 p[4] = {x, corner(at, 0), corner(at, 1), corner(at, 2)};
      const TetEnergy e = tet_energy(mesh_.objective, p[0], p[1], p[2], p[3]);
      const bool feasible = e.certified && e.shape <= mesh_.floor.worst_shape;
      const double cot = feasible ? QualityFloor::max_dihedral_cot(p, e.w) : limit;
      if (cot > max_cot) {
        max_cot = cot;
        first = at;
      }
      if (!(max_cot < limit)) return limit;
    }
    return max_cot;
  }

 private:
  /// In local lengths.
  static constexpr double kFirstStep = 0.2;
  static constexpr double kLastStep = 5e-3;
  /// The smallest relative decrease of the cotangent for which a step is taken.
  static constexpr double kMinGain = 1e-3;
  static constexpr int kDirections = 14;

  /// The directions from the center of a cube to its faces and corners.
  TETUNE_HD static Vec3 direction(int d) {
    const double s = d % 2 == 0 ? 1 : -1;
    if (d < 2) return {s, 0, 0};
    if (d < 4) return {0, s, 0};
    if (d < 6) return {0, 0, s};
    const double c = 0.57735026918962573;
    return {(d & 1) != 0 ? c : -c, (d & 2) != 0 ? c : -c, (d & 4) != 0 ? c : -c};
  }
  TETUNE_HD Vec3 corner(int face, int k) const { return vec(mesh_.points[faces_[face].v[k]]); }

  RatedMesh mesh_;
  const LinkFace* faces_;
  int count_;
};

}  // namespace tetune

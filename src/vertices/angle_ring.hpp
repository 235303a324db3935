// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/motion.hpp"
#include "core/orient.hpp"
#include "core/work_mesh.hpp"
#include "energy/ring.hpp"
#include "relocate/step.hpp"
#include "surface/deviation.hpp"

namespace tetune {

/// Cotangent of the smallest dihedral angle of a tetrahedron; where its volume is in doubt, of the smallest volume that
/// rounding leaves possible.
TETUNE_HD inline double largest_cot(const MeshView& mesh, Size t) {
  const Tet tet = mesh.tet2vertex[t];
  const Vec3 p[4] = {vec(mesh.points[tet[0]]), vec(mesh.points[tet[1]]), vec(mesh.points[tet[2]]),
                     vec(mesh.points[tet[3]])};
  const Orient o = orient(p[0], p[1], p[2], p[3]);
  return QualityFloor::largest_cot(p, o.certified() ? o.det : o.bound);
}

/// Where a vertex may go from a place: within its space of motion.
struct FreeWay {
  Motion motion;
  TETUNE_HD Vec3 from(const Vec3& x, const Vec3& step) const { return x + tangent_gradient(step, motion); }
  TETUNE_HD bool take(const Vec3& x) const { return motion.leash.holds(x); }
};

/// The same on the input surface, up to the rim of a triangle or segment.
struct SlideWay {
  ReferenceView reference;
  DeviationBound bound;
  Mobility walker;
  Site site;
  Site next;
  Leash leash;

  TETUNE_HD Vec3 from(const Vec3& x, const Vec3& step) {
    const Primitive primitive = steepest(reference, walker, site, -1.0 * step);
    next = site;
    if (primitive.on.kind == SiteKind::none) return x;
    const Landing landing = advance(reference, walker, primitive, site, x, primitive.down, 1);
    next = landing.site;
    return landing.at;
  }
  TETUNE_HD bool take(const Vec3& x) {
    if (!leash.holds(x) || !bound.allows(x, next)) return false;
    site = next;
    return true;
  }
};

/// The smallest dihedral angle of the tetrahedra between a point and some faces, as its cotangent: so it is to become
/// small. It is no smooth function of the point, and not convex; its minimum is sought by trials.
class AngleRing {
 public:
  TETUNE_HD AngleRing(const MeshView& mesh, const LinkFace* faces, int count)
      : mesh_(mesh), faces_(faces), count_(count) {}

  /// Moves x along a way (FreeWay, SlideWay) to where the smallest angle is larger, until its cotangent is no more than
  /// `enough`. Whether it moved.
  template <class Way>
  TETUNE_HD bool open(Vec3& x, Way& way, double enough) const {
    double length2 = 0;
    for (int k = 0; k < count_; ++k) {
      const Vec3 d = corner(k, 0) - x;
      length2 += dot(d, d);
    }
    const double length = std::sqrt(length2 / count_);
    int worst = 0;
    double cot = largest_cot(x, kNoLimit, worst);
    bool moved = false;
    for (double step = kFirstStep * length; step > kLastStep * length && cot > enough;) {
      bool better = false;
      for (int d = 0; d < kDirections && !better; ++d) {
        const Vec3 trial = way.from(x, step * direction(d));
        const double limit = cot - kLeastGain * (1 + cot);
        const double there = largest_cot(trial, limit, worst);
        if (!(there < limit) || !way.take(trial)) continue;
        x = trial;
        cot = there;
        better = true;
      }
      moved = moved || better;
      if (!better) step *= 0.5;
    }
    return moved;
  }

  /// The cotangent of the smallest angle with the point at x; `limit` where it is not below that, or where a
  /// tetrahedron is not certified positive or worse than the floor. Begins with tetrahedron `first`, and leaves there
  /// the one that decided.
  TETUNE_HD double largest_cot(const Vec3& x, double limit, int& first) const {
    double most = -1;
    const int start = first;
    for (int k = 0; k < count_; ++k) {
      const int at = k == 0 ? start : k <= start ? k - 1 : k;
      const Vec3 p[4] = {x, corner(at, 0), corner(at, 1), corner(at, 2)};
      const TetEnergy e = tet_energy(mesh_.law, p[0], p[1], p[2], p[3]);
      const bool fine = e.certified && e.shape <= mesh_.floor.worst_shape;
      const double cot = fine ? QualityFloor::largest_cot(p, e.w) : limit;
      if (cot > most) {
        most = cot;
        first = at;
      }
      if (!(most < limit)) return limit;
    }
    return most;
  }

 private:
  static constexpr double kNoLimit = 1e300;
  /// In parts of the local length.
  static constexpr double kFirstStep = 0.2;
  static constexpr double kLastStep = 5e-3;
  /// Relative: so much must a step gain.
  static constexpr double kLeastGain = 1e-3;
  static constexpr int kDirections = 14;

  /// To the faces and to the corners of a cube.
  TETUNE_HD static Vec3 direction(int d) {
    const double s = d % 2 == 0 ? 1 : -1;
    if (d < 2) return {s, 0, 0};
    if (d < 4) return {0, s, 0};
    if (d < 6) return {0, 0, s};
    const double c = 0.57735026918962573;
    return {(d & 1) != 0 ? c : -c, (d & 2) != 0 ? c : -c, (d & 4) != 0 ? c : -c};
  }
  TETUNE_HD Vec3 corner(int face, int k) const { return vec(mesh_.points[faces_[face].v[k]]); }

  MeshView mesh_;
  const LinkFace* faces_;
  int count_;
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "backend/span.hpp"
#include "mesh/tet.hpp"

namespace tetune {

/// The degrees of freedom of a vertex: V_C, V_E, V_F of the paper (Sect. 2), the interior, and the input surface.
enum class VertexDof : std::uint8_t {
  fixed,
  line,   ///< along a straight line
  plane,  ///< within a plane
  free,
  curve,    ///< along a feature line of the input surface (Sect. 4.3)
  surface,  ///< on the input surface, not across its feature lines
};

/// Whether a vertex slides on the reference surface.
TETUNE_HD inline bool slides(VertexDof dof) { return dof == VertexDof::surface || dof == VertexDof::curve; }

/// The caller's constraint on a vertex.
enum class VertexConstraint : std::uint8_t {
  none,
  frozen,    ///< it must not move
  corner,    ///< it is listed as a corner of the shape: see fix_corners()
  line_end,  ///< the edges of one tag end or branch there: see fix_line_ends()
};

/// A ball around the initial position of a surface vertex that the vertex must not leave, so that the surface keeps
/// its element sizes (docs/method.md, "Sizes of the surface"); the radius of a trust region over the whole run.
struct DisplacementBound {
  static constexpr double kUnbounded = 1e300;
  /// The bound counts as reached where it leaves less than this part of a Newton step or of the local length.
  static constexpr double kMinStep = 1e-2;

  Vec3 center;
  double radius = kUnbounded;

  TETUNE_HD bool contains(const Vec3& x) const {
    if (radius == kUnbounded) return true;
    const Vec3 d = x - center;
    return dot(d, d) <= radius * radius;
  }
  /// The largest t for which x + t p is inside.
  TETUNE_HD double max_step(const Vec3& x, const Vec3& p) const {
    if (radius == kUnbounded) return kUnbounded;
    const Vec3 d = x - center;
    const double a = dot(p, p);
    const double b = dot(d, p);
    const double c = dot(d, d) - radius * radius;
    if (!(a > 0)) return kUnbounded;
    return c < 0 ? (std::sqrt(b * b - a * c) - b) / a : b < 0 ? -2 * b / a : 0;
  }
};

/// The set of positions of a vertex that does not slide on a curved surface.
struct MotionSpace {
  VertexDof dof;
  Vec3 axis;  ///< unit tangent of the line, unit normal of the plane; unused otherwise
  DisplacementBound displacement_bound = {};
};

/// The space of motion of a vertex. The axis of a free one is not read: where the surface slides it was never written.
TETUNE_HD inline MotionSpace motion_space(Span<const VertexDof> dof, Span<const Vec3> axis, Index v) {
  return {dof[v], dof[v] == VertexDof::free ? Vec3{} : axis[v]};
}

struct PlaneBasis {
  Vec3 u, v;
};

/// Two orthonormal vectors of the plane with unit normal n. For a normal along a coordinate axis they are axes too, so
/// that a vertex in such a plane keeps that coordinate to the last bit.
TETUNE_HD inline PlaneBasis plane_basis(const Vec3& n) {
  using std::fabs;
  const double ax = fabs(n.x);
  const double ay = fabs(n.y);
  const double az = fabs(n.z);
  const Vec3 axis = ax <= ay && ax <= az ? Vec3{1, 0, 0} : ay <= az ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  Vec3 u = cross(n, axis);
  u = (1 / norm(u)) * u;
  return {u, cross(n, u)};
}

/// The part of a vector that is tangent to a space of motion: of a gradient, the gradient within it (Alg. 2).
TETUNE_HD inline Vec3 project(const Vec3& d, const MotionSpace& motion) {
  switch (motion.dof) {
    case VertexDof::free:
      return d;
    case VertexDof::plane: {
      // With the basis, a coordinate that is the same all over the plane stays to the last bit.
      const PlaneBasis basis = plane_basis(motion.axis);
      return dot(d, basis.u) * basis.u + dot(d, basis.v) * basis.v;
    }
    case VertexDof::line:
      return dot(d, motion.axis) * motion.axis;
    default:
      return {0, 0, 0};
  }
}

}  // namespace tetune

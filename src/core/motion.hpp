// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <cmath>

#include "core/types.hpp"

namespace tetune {

/// Where a vertex may go: V_C, V_E, V_F of the paper (Sect. 2), the interior, and the input surface.
enum class Mobility : std::uint8_t {
  fixed,
  line,   ///< along a straight line
  plane,  ///< within a plane
  free,
  curve,    ///< along a feature line of the input surface (Sect. 4.3)
  surface,  ///< on the input surface, not across its feature lines
};

/// How far from where it was a vertex of the surface may go, so that the surface keeps its sizes (docs/method.md,
/// "Sizes of the surface").
struct Leash {
  static constexpr double kEndless = 1e300;
  /// Below this part of a step the leash is at its end.
  static constexpr double kShortest = 1e-2;

  Vec3 home;
  double length = kEndless;

  TETUNE_HD bool holds(const Vec3& x) const {
    if (length == kEndless) return true;
    const Vec3 d = x - home;
    return dot(d, d) <= length * length;
  }
  /// Largest t for which x + t p is not beyond it.
  TETUNE_HD double reach(const Vec3& x, const Vec3& p) const {
    if (length == kEndless) return kEndless;
    const Vec3 d = x - home;
    const double a = dot(p, p);
    const double b = dot(d, p);
    const double c = dot(d, d) - length * length;
    if (!(a > 0)) return kEndless;
    return c < 0 ? (std::sqrt(b * b - a * c) - b) / a : b < 0 ? -2 * b / a : 0;
  }
};

struct Motion {
  Mobility kind;
  Vec3 axis;  ///< unit tangent of the line, unit normal of the plane; unused otherwise
  Leash leash = {};
};

struct PlaneBasis {
  Vec3 u, v;
};

/// Two orthonormal vectors of the plane with unit normal n. For a normal along an axis they are axes too, so that a
/// vertex in such a plane keeps that coordinate to the last bit.
TETUNE_HD inline PlaneBasis plane_basis(const Vec3& n) {
  using std::fabs;
  const double ax = fabs(n.x);
  const double ay = fabs(n.y);
  const double az = fabs(n.z);
  const Vec3 other = ax <= ay && ax <= az ? Vec3{1, 0, 0} : ay <= az ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  Vec3 u = cross(n, other);
  u = (1 / norm(u)) * u;
  return {u, cross(n, u)};
}

}  // namespace tetune

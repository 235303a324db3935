// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

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

struct Motion {
  Mobility kind;
  Vec3 axis;  ///< unit tangent of the line, unit normal of the plane; unused otherwise
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

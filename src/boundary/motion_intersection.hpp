// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "boundary/classify.hpp"
#include "boundary/vertex_dof.hpp"

namespace tetune {

/// The intersection of the spaces of motion of two vertices that move by the same vector. Where it is one of the two,
/// it has the bits of that one's axis, and of the first one's if they are equal.
inline MotionSpace intersect(const MotionSpace& a, const MotionSpace& b) {
  const MotionSpace fixed{VertexDof::fixed, {}};
  const auto can_move = [](const MotionSpace& s) {
    return s.dof == VertexDof::free || s.dof == VertexDof::plane || s.dof == VertexDof::line;
  };
  const auto are_parallel = [](const Vec3& u, const Vec3& v) { return norm(cross(u, v)) <= kFlat; };
  if (!can_move(a) || !can_move(b)) return fixed;
  if (a.dof == VertexDof::free) return b;
  if (b.dof == VertexDof::free) return a;
  if (a.dof == b.dof && are_parallel(a.axis, b.axis)) return a;
  if (a.dof == VertexDof::plane && b.dof == VertexDof::plane) {
    const Vec3 along = cross(a.axis, b.axis);
    return {VertexDof::line, (1 / norm(along)) * along};
  }
  if (a.dof == b.dof || std::fabs(dot(a.axis, b.axis)) > kFlat) return fixed;
  return a.dof == VertexDof::line ? a : b;
}

}  // namespace tetune

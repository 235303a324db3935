// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "curved/jacobian.hpp"
#include "curved/relaxation.hpp"

namespace tetune {

/// An upper bound on the scaled Jacobian of a tetrahedron, wherever its nodes that are not held are: the Jacobian
/// determinant at a vertex depends on the three edges there alone, and along an edge on all edges but the opposite one.
/// Infinity if an edge of each of these sets is not held. An element with two faces on a smooth surface has a bound
/// near 0, or below.
double bound_by_held(const std::array<Index, 4>& tet, const TenNodes& nodes, const HeldNodes& held);

/// Elements of a smaller bound are split where vertices may be inserted.
inline constexpr double kSmallBound = 0.2;

/// The tetrahedra with a curved edge whose bound is below `limit`, those of the smallest bound first.
std::vector<Index> find_bounded(const TetMesh& mesh, const HeldNodes& held, double limit);

}  // namespace tetune

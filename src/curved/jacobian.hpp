// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "math/vec3.hpp"
#include "tetune/curved.hpp"

/// The Jacobian determinant of a ten-node tetrahedron: a polynomial of degree 3 in barycentric coordinates.
namespace tetune {

/// The ends of the edges of a tetrahedron, in the order of their mid-side nodes.
inline constexpr std::array<std::array<std::size_t, 2>, 6> kCurvedTetEdges{
    {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};

/// Four vertices, then the mid-side nodes of kCurvedTetEdges.
using TenNodes = std::array<Vec3, 10>;

inline constexpr std::size_t kJacobianTerms = 20;
using JacobianCoefficients = std::array<double, kJacobianTerms>;

/// A polynomial of degree 3 over a tetrahedron by its Bernstein-Bezier coefficients, each with an error of at most
/// `error`.
struct JacobianPolynomial {
  JacobianCoefficients coefficients{};
  double error = 0;
  /// Value at a vertex, 0 to 3.
  double corner(std::size_t vertex) const;
  double smallest_coefficient() const;
  double largest_coefficient() const;
};

/// The determinant of the Jacobian matrix with respect to the reference tetrahedron with three unit edges: that of a
/// straight element is six times its volume. Lengths are multiplied by a power of two near the inverse size of the
/// element: products do not overflow.
struct ScaledJacobian {
  JacobianPolynomial polynomial;
  double straight = 0;  ///< the determinant of the straight element with the same vertices
  double scale = 1;     ///< the power of two
};
ScaledJacobian jacobian_of(const TenNodes& nodes);

/// The signed volume of a ten-node tetrahedron: the integral of the determinant, exact but for rounding.
double signed_volume(const TenNodes& nodes);

/// The eight parts of a polynomial, on the tetrahedra that the midpoints of the edges divide the element into.
std::array<JacobianPolynomial, 8> subdivide(const JacobianPolynomial& polynomial);

/// The value at barycentric coordinates that sum to 1.
double evaluate(const JacobianPolynomial& polynomial, const std::array<double, 4>& at);

/// Certified bounds of the minimum of a polynomial.
struct MinimumBounds {
  double lower = 0, upper = 0;
};

/// Branch and bound: subdivides the part of the smallest lower bound until the sign of the minimum is proved and both
/// bounds differ by at most `tolerance` beyond rounding errors, or the limit of subdivisions is reached.
MinimumBounds bound_minimum(const JacobianPolynomial& polynomial, double tolerance);

/// All measures but the id and the centroid.
CurvedTet measure_nodes(const TenNodes& nodes);

}  // namespace tetune

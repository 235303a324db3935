// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "math/vec3.hpp"

namespace tetune {

/// An energy above that of any tetrahedron: marks a candidate that is not feasible.
inline constexpr double kInfeasible = 1e300;

/// The square root of a double, or of each lane of a pack.
template <class T>
TETUNE_HD TETUNE_INLINE T square_root(const T& x) {
  if constexpr (requires { x[0]; }) {
    T root;
    for (unsigned l = 0; l < sizeof(T) / sizeof(x[0]); ++l) root[l] = std::sqrt(x[l]);
    return root;
  } else {
    return std::sqrt(x);
  }
}

/// The energy of one tetrahedron, E = c q^(gu / 2) w^gv with q = 4 * sum of squared areas and w = 6 * volume, and the
/// coefficients of its derivatives: with u = grad q / (2 q), v = grad w / w and Q = Hess q / 2,
///   grad E = E (gu u + gv v),   Hess E = E (gu Q / q + uu u u^T + uv (u v^T + v u^T) + vv v v^T).
/// Every such energy is convex where w > 0 (docs/method.md), but for roots of the shape energy, in place of whose
/// Hessian the coefficients give a convex upper bound.
struct Objective {
  bool shape;      ///< a power of the shape energy; otherwise the harmonic energy
  int log2_power;  ///< binary logarithm of the power of the shape energy; negative: a root
  double factor;   ///< c
  double gu, gv, uu, uv, vv;
  /// Regularization of volumes while a mesh is untangled, relative to the cube of the local length: see
  /// RegularizedRing.
  double regularization = 0;

  /// E / c. The order of the products avoids overflow for lengths in the range of a mesh's own unit.
  template <class T>
  TETUNE_HD TETUNE_INLINE T term(const T& q, const T& inverse_w) const {
    const T harmonic = q * inverse_w;
    return shape ? power(shape_term(q, inverse_w)) : harmonic;
  }
  /// E / c, and in `shape_only` q^(3/2) / w^2.
  template <class T>
  TETUNE_HD TETUNE_INLINE T term(const T& q, const T& inverse_w, T& shape_only) const {
    shape_only = shape_term(q, inverse_w);
    return shape ? power(shape_only) : q * inverse_w;
  }

  template <class T>
  TETUNE_HD TETUNE_INLINE static T shape_term(const T& q, const T& inverse_w) {
    return (q * inverse_w) * (square_root(q) * inverse_w);
  }

 private:
  template <class T>
  TETUNE_HD TETUNE_INLINE T power(T e) const {
    for (int i = 0; i < log2_power; ++i) e = e * e;
    for (int i = log2_power; i < 0; ++i) e = square_root(e);
    return e;
  }
};

/// The harmonic index eta = 1.5 q / w (Stroeter et al. 2022, Eq. 5).
inline constexpr Objective kHarmonicObjective{false, 0, 1.5, 2, -1, 0, -2, 2};

/// 1 / (6 sqrt(3)): the shape energy of a regular tetrahedron is 1.
inline constexpr double kShapeFactor = 0.096225044864937627;

/// A lower bound on the shape energy of a tetrahedron, and on its powers, with the rounding errors.
inline constexpr double kMinShapeEnergy = 1 - 1e-12;

/// The shape energy (eta / eta_r)^(3/2) = q^(3/2) / (6 sqrt(3) w^2) raised to 2^log2_power, where eta_r is the harmonic
/// index of the regular tetrahedron of the same volume. It is 1 for a regular tetrahedron of any size; a higher power
/// gives more weight to the worst tetrahedra, a root less.
constexpr Objective shape_objective(int log2_power) {
  double factor = kShapeFactor;
  double power = 1;
  for (int i = 0; i < log2_power; ++i) {
    factor *= factor;
    power *= 2;
  }
  double root = 1;
  for (int i = log2_power; i < 0; ++i) {
    factor = std::sqrt(factor);
    root /= 2;
  }
  const double a = 1.5 * power;
  const double b = 2 * power;
  // A root is concave in E: E^root is below its tangent, whose Hessian is root E^(root - 1) times that of E.
  return {true,
          log2_power,
          factor,
          root * 2 * a,
          -root * b,
          root * (4 * a * a - 4 * a),
          root * (-2 * a * b),
          root * (b * b + b)};
}
inline constexpr Objective kShapeObjective = shape_objective(0);

}  // namespace tetune
